//! Tools for the project's pictures: a [`Canvas`] of anti-aliased shapes, letters and photographs
//! that becomes a PNG file, an [`Animation`] of several, and a [`View`] that places points of space
//! on them. Pure Rust, no system font: pictures are the same everywhere. The content of pictures is
//! left to the crates that use this.

mod animation;
mod canvas;
mod error;
mod photograph;
mod view;

pub use self::{
    animation::Animation,
    canvas::{Align, Canvas, Clip, Color, Rect},
    error::Error,
    photograph::Photograph,
    view::View,
};
