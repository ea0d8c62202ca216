//! A twin that is loaded, and the models of it that answer requests.

mod planner;
pub(crate) mod rest_shape;
pub(crate) mod serve;
pub(crate) mod warm;
