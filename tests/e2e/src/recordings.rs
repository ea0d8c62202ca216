//! Recordings of users: uploads of any size, ingests, recordings with faults, and several recordings of
//! one object.

mod broken_captures;
mod ingests;
mod resumable;
pub(crate) mod several_recordings;
mod supplements;
mod uploads;
