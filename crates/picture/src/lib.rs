//! What the project's pictures are drawn with: a [`Canvas`] of anti-aliased shapes, letters and photographs that becomes a
//! PNG file, and a [`View`] that places points of space on it. Pure Rust, no system font: pictures are the same
//! everywhere. What is drawn is the business of the crates that use this.

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
