//! Rules of a rollout that server, worker and clients share: [`Limits`] of a request, the check of
//! a request against them and against a twin's [`TwinShape`], the size of its reply, and the parts
//! that a streamed reply comes in. Both ends call the same functions with the same limits (a worker
//! gets those of its server when it registers), so no request passes one and is refused by the
//! other.

// Not behind a feature: the binary and the tests of all crates then share one build.
#[doc(hidden)]
pub mod cases;
mod check;
mod error;
mod limits;
mod parts;
mod size;
mod twin;

pub use self::{
    check::{Batch, check, check_for, fidelity, work},
    error::Error,
    limits::{ENVELOPE_BYTES, Limits},
    parts::{STREAMED_PART, part_instances},
    size::reply_bytes,
    twin::TwinShape,
};
