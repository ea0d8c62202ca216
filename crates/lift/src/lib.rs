//! Lifting: a raw recording (`bendtwin_capture::raw`) becomes a capture of tracked points that a
//! fit can use.
//!
//! [`lift()`] runs these steps, each in a separate file:
//!
//! 1. `survey::clean`: masks lose flying pixels, specks, and pixels that belong to the hand rather
//!    than the object.
//! 2. `survey::lift`: 2D tracks become points, at sub-pixel accuracy and only where nothing hides
//!    them.
//! 3. `motion`: tracks that do not move as their neighbours do are not believed.
//! 4. `thin`: of several tracks of one spot the one that is seen longest stays.
//! 5. `shape`, `shape::complete`: a mesh fills in what no camera saw, or else what no camera saw
//!    through (`shape::sight`, `shape::carve`).
//! 6. `hands`: tracks on hands become control points that move as rigid bodies, where these meet the
//!    object.
//!
//! The first two read frames, camera by camera in blocks, and are what a checkpoint keeps
//! (`survey`); the rest takes seconds. Frames are read one at a time, so memory does not grow with
//! their number or size. Results do not depend on the number of threads, nor on interruptions.

mod checkpoint;
mod error;
pub mod evidence;
mod grid;
mod hands;
mod job;
mod motion;
mod rigid;
mod score;
mod shape;
mod survey;
mod thin;
mod tracks;

pub use error::Error;
pub use evidence::Evidence;
pub use job::{
    Observation, lift,
    progress::{Progress, Step},
};
pub use score::{Score, score};

#[cfg(test)]
mod testing;
