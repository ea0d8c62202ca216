//! Rules of the source tree, and agreement of the documents with the code.

mod architecture;
mod doc_comments;
mod documents;
mod folders;
mod idioms;
mod reasons;
mod rust_code;
mod sentences;
mod shared_build;
mod tidy;
pub(crate) mod workspace;
