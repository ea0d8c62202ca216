//! Requests that are right but for one thing: the check, the server and the worker must refuse each of
//! them with the same fault. And a small twin with requests to it ([`hanging`]).

pub mod hanging;
pub mod picture;
pub mod plan;
pub mod registration;
pub mod rollout;
