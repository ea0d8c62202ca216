//! The built-in point tracker, for recordings without 2D tracks.
//!
//! [`track`] follows textured points of the object and of the manipulator through all cameras at
//! once. Each frame goes through the same stages:
//!
//! 1. *flow*: pyramidal Lucas-Kanade on colour from the frame before, forward and backward
//!    (`matching::align`, `matching::follow`);
//! 2. *motion*: matches are lifted through depth; the rigid motion of each point's neighbours, seen
//!    by any camera, since the point was seeded predicts its place and its rotation (`motion`);
//! 3. *refinement*: the patch that was cut out when the point was seeded is turned and bent as its
//!    surface was and matched at sub-pixel accuracy, so that errors do not add up; points that were
//!    hidden are looked for where they should reappear;
//! 4. *checks*: masks, depth edges, agreement with the neighbours and with the other cameras' masks
//!    and depth.
//!
//! Colours are normalised by masks, so that neither the background nor a hand leaks into the
//! object's patches.

mod appearance;
mod error;
mod frame;
mod matching;
mod motion;
mod multi_view;
mod outcome;
mod quality;
mod seed;
mod settings;
mod shape_tracking;
mod track;
mod tracker;
mod view;

#[cfg(test)]
mod tests;

pub use error::Error;
pub use outcome::CameraTracks;
pub use quality::{Guide, Texture, TrackerQuality};
pub use seed::seed_count;
pub use settings::FlowSettings;
pub use tracker::track;
