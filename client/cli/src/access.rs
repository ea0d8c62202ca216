//! The commands about access: sign-in, keys, projects of their owners, and what owners have.

pub(crate) mod admin;
pub(crate) mod console;
pub(crate) mod key;
pub(crate) mod login;
pub(crate) mod project;
