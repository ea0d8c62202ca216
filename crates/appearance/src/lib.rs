//! The look of a twin, from views of the recording that it was fitted to: colours of its skin,
//! Gaussians trained along its predicted motion, and the likeness of its renderings to what the
//! cameras saw. Knows no physics: the motion is given.

mod camera;
mod colors;
mod dressed;
mod error;
mod motion;
mod score;
mod target;
#[cfg(test)]
mod testing;
mod train;

pub use self::{
    colors::skin_colors,
    dressed::Dressed,
    error::Error,
    motion::Motion,
    score::{Scene, score},
    train::{Step, Training, TrainingOptions},
};
