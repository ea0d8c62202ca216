//! The raw form of BendTwin's bundle: `capture.json` with a `raw` section, images and arrays, in a
//! folder or a ZIP archive. `docs/formats/capture.md` specifies it for other programs.

mod reader;
mod section;
mod writer;

pub(super) use reader::read;
pub(crate) use section::Section;
pub(super) use section::{DistortionEntry, IntrinsicsEntry, PoseEntry};
pub use writer::{BundleOptions, write_bundle, write_bundle_to};

#[cfg(test)]
mod tests;
