//! Rules of pictures of sessions that server, worker and clients share: the check of a request against limits, and the
//! size of its reply.

mod check;
mod error;

pub use self::{
    check::{
        MAX_CAMERAS, MAX_PIXELS, MAX_PROPS, MAX_SIDE, MAX_SLOTS, check_pictures, look,
        memory_bytes, pixels, reply_bytes,
    },
    error::Error,
};
