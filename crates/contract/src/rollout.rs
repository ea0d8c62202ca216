//! Rules of a rollout that server, worker and clients share: [`Limits`] of a request, the check of a
//! request against them and against a twin's [`TwinShape`], its price (work, size of the reply and
//! memory at a worker), and the parts that a streamed reply comes in. Both ends call the same functions
//! with the same limits (a worker gets those of its server when it registers), so no request passes one
//! and is refused by the other.

mod check;
mod encoded;
mod error;
mod implausible;
mod limits;
mod memory;
mod message;
mod parts;
mod points;
mod price;
mod request;
mod session;
pub mod split;
mod twin;

/// Metadata of a call from the server to a worker: the length of its message, for which the worker
/// takes memory before it reads it.
pub const REQUEST_BYTES: &str = "bendtwin-request-bytes";
/// Metadata of a call from the server to a worker: a name that stands for the owner of the request.
/// Accounts take turns at the device, however many requests each has under way.
pub const ACCOUNT: &str = "bendtwin-account";

pub use self::{
    check::{Batch, SessionParts, check, check_for, check_in, fidelity, too_much_memory},
    encoded::{Encoded, check_encoded},
    error::Error,
    implausible::ImplausibleReason,
    limits::{ENVELOPE_BYTES, Limits},
    memory::{Memory, request_bytes},
    parts::{STREAMED_PART, part_frames, part_instances},
    points::{measured, recorded},
    price::{memory, models_bytes, reply_bytes, work},
    request::{
        gradients::has_gradients,
        returns::has_spread,
        vary::{MOST_SUBSTEPS, finer_substeps, has_mean_prediction, members},
    },
    session::{MOST_SLOTS, check_advance, check_session, slots, states_bytes},
    twin::{PlannerShape, TwinShape},
};
pub(crate) use self::{
    check::{sizes, within},
    request::{SHORTEST_QUATERNION, tensors, world},
    session::states_size,
};
