//! The commands about access: keys, projects of their owners, and what owners have.

pub(crate) mod admin;
pub(crate) mod key;
pub(crate) mod project;
