//! The commands about access: keys, and projects of their owners.

pub(crate) mod key;
pub(crate) mod project;
