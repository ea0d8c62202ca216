//! The derive of `bendtwin_core::Problem`, which puts category and reason of an error beside its
//! message:
//!
//! ```text
//! #[derive(Debug, thiserror::Error, Problem)]
//! enum Error {
//!     #[error("{name} does not exist")]
//!     #[problem(NotFound, "CAPTURE_NOT_FOUND")]
//!     Missing { name: String },
//!     #[error("the disk is busy: retry")]
//!     #[problem(Unavailable, "DISK_BUSY", retry = Duration::from_secs(1))]
//!     Busy,
//!     #[error("cannot write {path}: {source}")]
//!     #[problem(ResourceExhausted, "DISK_FULL", if source.kind() == ErrorKind::StorageFull)]
//!     #[problem(Internal, "DISK_FAILED")]
//!     Disk { path: String, source: std::io::Error },
//!     #[error("recording {name}: {error}")]
//!     #[problem(transparent)]
//!     Recording { name: String, error: reader::Error },
//!     #[error(transparent)]
//!     Engine(#[from] engine::Error),
//! }
//! ```
//!
//! | argument | meaning |
//! |---|---|
//! | `NotFound` | the category: a variant of `Category`, or an expression such as `fault.category` |
//! | `"DISK_FULL"` | the reason |
//! | `transparent` | category, reason and retry are those of the cause: the only field, or the one named `error` or `source`. A variant with `#[error(transparent)]` needs no attribute |
//! | `retry = EXPR` | delay after which another attempt makes sense: a `Duration`, or an option of one |
//! | `fault = EXPR` | the portable form, of an error that carries it |
//! | `if EXPR` | the attribute applies where this is true, else the next one does |
//!
//! Expressions see the fields as references, by name, or as `_0`, `_1`. An attribute on the type
//! applies to variants without one, and to a struct.

mod attribute;
mod expand;

/// Implements `bendtwin_core::Problem` by the `#[problem(...)]` of each variant.
#[proc_macro_derive(Problem, attributes(problem))]
pub fn problem(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let input = syn::parse_macro_input!(input as syn::DeriveInput);
    expand::problem(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}
