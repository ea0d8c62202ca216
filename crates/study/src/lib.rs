//! Suites of fits: every capture of a list, fitted under every configuration with every seed, and one table of what came of it.
//!
//! A [`Suite`] is a JSON file (docs/accuracy.md). A [`Plan`] reads its captures and says which runs are still to be done:
//! a run's result is kept in a [`Folder`] under the digest of its capture, its settings and the build, so a suite that was
//! interrupted goes on where it was, and one whose settings changed repeats only what they change. [`Plan::run`] runs side
//! by side, one run at a time on each backend that it is given; [`Table`] compares what there is.
//!
//! How a fit works is for `bendtwin-fit` to say, what its errors are for `bendtwin-eval`.

mod command;
mod digest;
mod error;
mod execute;
mod folder;
mod keeper;
mod picture;
mod plan;
mod record;
mod run;
mod suite;
mod table;

pub use command::Invocation;
pub use error::Error;
pub use execute::{Event, Tally};
pub use folder::Folder;
pub use picture::draw_pictures;
pub use plan::{Plan, PlanOptions, Read};
pub use record::{Finished, GraphCounts, Losses, Outcome, Record};
pub use suite::{CaptureEntry, Comparison, Configuration, Reference, RunId, Selection, Suite};
pub use table::{Difference, Failure, Figure, Figures, Kind, Row, Size, Table};
