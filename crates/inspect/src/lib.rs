//! The capture report: faults of a recording, in numbers and pictures.
//!
//! [`inspect()`] reads every frame of a raw recording once and keeps numbers and a few crops; from
//! these it judges time (dropped, repeated, late frames; skew, also without times), depth, masks,
//! tracks, scale, motion and contact, and whether the cameras see one world: if not, it tries the
//! mistakes that people make with calibrations and names the one that explains it.
//! [`inspect_observed()`] does what can be done for points that were lifted elsewhere. A [`Report`]
//! is a JSON document and one page without scripts. [`Code`] has every code with what to do.

mod alike;
mod codes;
mod consequences;
mod consistency;
mod draw;
mod error;
mod finding;
mod inspect;
mod inspection;
mod judge;
mod observed;
mod page;
mod picture_inputs;
mod report;
mod scan;
mod statistics;
mod thresholds;
mod vector;

use bendtwin_core::Finding;

pub use self::{
    codes::Code,
    error::Error,
    finding::Verdict,
    inspect::inspect,
    inspection::{
        Agreement, CameraReport, DetectedGround, Inspection, Kind, ObservedReport, PairReport,
        Scene, TrackReport,
    },
    observed::inspect_observed,
    report::{FORMAT, Lifted, Report, VERSION},
};

#[cfg(test)]
mod testing;
