//! The look of a twin, from views of the recording that it was fitted to: colours of its skin,
//! Gaussians trained along its predicted motion, and its renderings beside what the cameras saw, as
//! numbers and as videos. Knows no physics: the motion is given.

mod camera;
mod colors;
mod dressed;
mod error;
mod motion;
mod pairs;
mod score;
mod side_by_side;
mod target;
#[cfg(test)]
mod testing;
mod train;

pub use self::{
    colors::skin_colors,
    dressed::Dressed,
    error::Error,
    motion::Motion,
    pairs::{ComparedPair, compared_pairs},
    score::{Scene, score},
    side_by_side::side_by_side,
    train::{Step, Training, TrainingOptions},
};
