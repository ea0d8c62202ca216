//! Rules of registration and correction that server, worker and clients share: the check of an
//! observation and of its options against limits and a twin's [`TwinShape`](crate::rollout::TwinShape),
//! and the work and the memory that they take at a worker.

mod check;
mod cost;
mod error;

pub use self::{
    check::{
        MAX_CAMERAS, MAX_POINTS, MAX_SETTLE_FRAMES, begun, carry, check_correction,
        check_registration,
    },
    cost::{
        correction_reply_bytes, correction_work, evaluation_work, memory_bytes, registration_work,
        reply_bytes, settle_frames,
    },
    error::Error,
};
