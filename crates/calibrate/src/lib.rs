//! Calibration of cameras: poses from a board that all of them see, from files of other programs and
//! from COLMAP, and the ground from depth. Everything ends in a
//! [`Calibration`](bendtwin_capture::raw::Calibration), which replaces that of a recording.

pub mod board;
pub mod colmap;
mod error;
pub mod files;
pub mod ground;
mod lens;
mod place;
mod statistics;
mod upright;

pub use self::error::Error;
