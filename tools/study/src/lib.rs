//! Suites of fits: every capture of a list, fitted under every configuration with every seed, and
//! one table of the results.
//!
//! A [`Suite`] is a JSON file (docs/develop/suites.md). A [`Plan`] reads its captures and lists the
//! pending runs: a run's result is kept in a [`Folder`] under the digest of its capture, its
//! settings and the build, so that an interrupted suite continues where it stopped, and one whose
//! settings changed repeats only the runs that they change. [`Plan::run`] executes runs in
//! parallel, one at a time on each backend that it is given; [`Table`] compares the results.
//!
//! Fits are documented in `bendtwin-fit`, their errors in `bendtwin-eval`.

mod bootstrap;
mod command;
mod digest;
mod error;
mod execute;
mod figure;
mod fit_observer;
mod folder;
mod picture;
mod plan;
mod record;
mod run;
mod suite;
mod table;

pub use bootstrap::{Certainty, Verdict};
pub use command::Invocation;
pub use error::Error;
pub use execute::{Devices, Event, Summary};
pub use figure::draw_figure;
pub use folder::Folder;
pub use picture::draw_pictures;
pub use plan::{Plan, PlanOptions, Read};
pub use record::{Finished, GraphCounts, Losses, Outcome, Record};
pub use suite::{
    CaptureEntry, Comparison, Configuration, FigureEntry, Reference, RunId, Selection, Series,
    Suite,
};
pub use table::{Difference, Failure, Figure, Figures, Gain, Gains, Kind, Row, Size, Table};
