//! Domain nouns of BendTwin: capture, graph, params, twin, settings, ids and error categories. No
//! I/O, no async, no physics. All other crates use these types, so that one word means one thing
//! everywhere.
//!
//! Units are SI. Frames are right-handed; up and ground are declared, never
//! guessed. Arrays are flat `Vec`s whose shape stands in the field's comment.

// The derive of `Problem` names this crate by its path.
extern crate self as bendtwin_core;

pub mod cancel;
pub mod capture;
pub mod capture_files;
pub mod checkpoint;
pub mod environment;
pub mod error;
pub mod finding;
pub mod geometry;
pub mod graph;
pub mod ids;
pub mod observer;
pub mod params;
pub mod progress;
pub mod sets;
pub mod settings;
pub mod twin;
pub mod views;

pub use cancel::CancelToken;
pub use capture::{Capture, Sequence};
pub use environment::{Environment, FRAME_RATES, MASSES, Plane, Timing};
pub use error::{Category, Fault, Problem};
pub use finding::{Finding, Severity};
pub use graph::{Graph, NodeKind, Pin};
pub use observer::{Observer, ObserverError};
pub use params::{Contact, Params};
pub use progress::{ModelLoss, Preview, PreviewErrors, Progress, Stage};
pub use sets::DisjointSets;
pub use settings::FitSettings;
pub use twin::{
    Twin,
    appearance::{Appearance, Splats},
    fidelity::{FastVariant, Fidelity},
    identifiability::{self, Identifiability},
    planner::{PlannerQuality, PlannersTwin},
    quality::{self, Quality},
    skin::Skin,
    surface::{Surface, Tube},
};
pub use views::{View, ViewCamera, Views};

/// Name and version of this software, as twins, checkpoints and reports record them.
pub const BUILD: &str = concat!("bendtwin ", env!("CARGO_PKG_VERSION"));

/// A point or vector in space: x, y, z.
pub type Point = [f32; 3];
