//! Tools for the project's pictures: a [`Canvas`] of anti-aliased shapes, letters and photographs
//! that becomes a PNG file, and a [`View`] that places points of space on it. Pure Rust, no system
//! font: pictures are the same everywhere. The content of pictures is left to the crates that use
//! this.

mod canvas;
mod error;
mod photograph;
mod view;

pub use self::{
    canvas::{Align, Canvas, Clip, Color, Rect},
    error::Error,
    photograph::Photograph,
    view::View,
};
