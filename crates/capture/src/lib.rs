//! Capture bundles, PhysTwin cases and motion capture: read, check, write.
//!
//! [`read()`] accepts the formats that people have and gives a [`bendtwin_core::Capture`] in metres
//! with z up. All input is treated as hostile: sizes are checked before allocation, archives are
//! never extracted, pickles go through an allow-list. [`open()`] also accepts [`raw`] recordings of
//! colour and depth. [`check()`] says in plain words why a capture will not fit.

pub mod bundle;
pub mod check;
pub mod mocap;
pub mod npy;
pub mod phystwin;
pub mod raw;
pub mod read;
pub mod several;
pub mod sources;
pub mod views;

mod array;
mod digest;
mod error;
mod files;
mod format;
mod frame;
mod limits;
mod pickle;
mod torch;

pub use bundle::{write_bundle, write_bundle_file};
pub use check::{CheckReport, check, check_gravity, check_path, structure::validate};
pub use digest::digest;
pub use error::Error;
pub use files::contents::{FilesRead, files_read};
pub use format::{is_npz, root};
pub use limits::Limits;
pub use mocap::described;
pub use read::{Opened, Remarks, open, read, read_bytes};
pub use several::Part;
pub use sources::Sources;
pub use views::{read_views, write_observation};
