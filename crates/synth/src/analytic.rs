//! Analytic shapes in front of cameras, drawn by casting a ray through every pixel, so that it is
//! known exactly where each of their points appears. Tests of trackers and of measurements on
//! images need that; [`film`](crate::film()) draws triangles instead.
//!
//! Motion, textures, noise and faults belong to the tests: they place the shapes of each frame and
//! turn what a pixel shows into its colour or depth.

mod primitive;
mod ray;

use bendtwin_capture::raw::{Camera, Image, Mask};
use bendtwin_core::geometry::Vector;

pub use self::{
    primitive::Primitive,
    ray::{Precision, Ray},
};

/// Bodies of one moment, each a tag that identifies it and a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Bodies<T>(pub Vec<(T, Primitive)>);

/// First point of a body on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<T> {
    /// Tag of the body.
    pub body: T,
    /// Depth along the optical axis [m].
    pub depth_m: f64,
    /// Coordinates on the body, as [`Primitive::local`] gives them.
    pub local: Vector,
}

impl<T: Copy> Bodies<T> {
    /// The nearest body on a ray, the earlier one of two at the same depth.
    pub fn hit(&self, ray: &Ray) -> Option<Hit<T>> {
        let met = self.0.iter().filter_map(|(tag, shape)| Some((*tag, shape, shape.depth_m(ray)?)));
        let (body, shape, depth_m) = met.min_by(|a, b| a.2.total_cmp(&b.2))?;
        Some(Hit { body, depth_m, local: shape.local(ray.at(depth_m)) })
    }

    /// View of a camera in a frame.
    pub fn view(&self, camera: &Camera, frame: usize, precision: Precision) -> View<T> {
        let (width, height) = (camera.width, camera.height);
        let hit = |i: usize| {
            let pixel = [(i % width) as f64, (i / width) as f64];
            self.hit(&Ray::through(camera, pixel, frame, precision))
        };
        View { width, height, hits: (0..width * height).map(hit).collect() }
    }
}

/// View of one camera in one frame, from which colour, depth and masks are computed.
#[derive(Clone, Debug, PartialEq)]
pub struct View<T> {
    width: usize,
    height: usize,
    /// Shape [height, width].
    hits: Vec<Option<Hit<T>>>,
}

impl<T: Copy> View<T> {
    /// An image, computed from each pixel (column, row) and what it shows: colour by a texture, or
    /// depth.
    pub fn image<P>(&self, pixel: impl Fn([usize; 2], Option<Hit<T>>) -> P) -> Image<P> {
        let at = |i: usize| [i % self.width, i / self.width];
        let pixels = self.hits.iter().enumerate().map(|(i, hit)| pixel(at(i), *hit)).collect();
        Image { width: self.width, height: self.height, pixels }
    }

    /// Mask of the pixels that show certain bodies.
    pub fn mask(&self, shown: impl Fn(T) -> bool) -> Mask {
        self.image(|_, hit| hit.is_some_and(|h| shown(h.body)))
    }
}

#[cfg(test)]
mod tests;
