//! Pictures as a pinhole camera sees them: an object, rigid props and a background, by depth.

mod compose;

use std::cell::RefCell;

use bendtwin_core::{
    Point,
    geometry::{Vector, dot, wide},
};
use bendtwin_splat::{Camera, Image};
use rayon::prelude::*;

use self::compose::Composition;
use crate::{
    light::{Light, linear},
    mesh::Posed,
    raster::{NOTHING, Raster, SAMPLES},
    solid::Prop,
};

/// Depth below which surfaces and props are not seen [m].
pub(crate) const NEAR_M: f32 = 0.01;
/// Label of the object; those of props follow.
pub(crate) const OBJECT: u8 = NOTHING + 1;
/// Pixels of the bands that a large picture is drawn in: their samples stay in the cache of a core.
const BAND_PIXELS: usize = 1 << 14;

/// What is in a picture.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The object.
    pub object: Object<'a>,
    /// Rigid things beside it, at most 250.
    pub props: &'a [Prop<'a>],
    /// The light of props; a posed surface has had it.
    pub light: &'a Light,
    /// What is behind it all.
    pub background: Background<'a>,
}

/// The object of a picture.
#[derive(Clone, Copy, Debug)]
pub enum Object<'a> {
    /// A surface.
    Surface(&'a Posed<'a>),
    /// A rendering of Gaussians by the same camera, over black.
    Gaussians(&'a Image),
}

/// What is seen where there is nothing else (sRGB).
#[derive(Clone, Copy, Debug)]
pub enum Background<'a> {
    /// A colour.
    Color([u8; 3]),
    /// The colours of all pixels, shape [height, width, 3].
    Image(&'a [u8]),
}

/// What is returned of a picture beside its colours.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    /// Depths.
    pub depths: bool,
    /// Labels.
    pub labels: bool,
}

/// A picture. Arrays are row-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Colours (sRGB), shape [height, width, 3].
    pub colors: Vec<u8>,
    /// Depth of what the label names [m]; 0 for the background. Shape [height, width], or empty.
    pub depths: Vec<f32>,
    /// What covers most of a pixel: 0 the background, 1 the object, 2 + i prop i. Shape [height, width], or empty.
    pub labels: Vec<u8>,
}

/// Memory of a thread that draws pictures of this width [bytes].
pub fn scratch_bytes(width: u32) -> usize {
    BAND_PIXELS.max(width as usize) * Raster::PIXEL_BYTES
}

thread_local! {
    /// Samples of the band that a thread draws, kept for the next one.
    static RASTER: RefCell<Raster> = RefCell::default();
}

/// Draws a picture on the threads of rayon's current pool; `None` if `is_cancelled` says so meanwhile.
///
/// # Panics
/// If an image does not have the size of the camera.
pub fn draw(
    scene: &Scene<'_>,
    wanted: Wanted,
    is_cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<Picture> {
    let camera = scene.camera;
    let (width, pixels) = (camera.width as usize, camera.pixel_count());
    let sized = |is_wanted: bool| if is_wanted { pixels } else { 0 };
    let mut picture = Picture {
        colors: vec![0; 3 * pixels],
        depths: vec![0.0; sized(wanted.depths)],
        labels: vec![NOTHING; sized(wanted.labels)],
    };
    let band_rows = (BAND_PIXELS / width).max(1);
    let mut bands = Vec::new();
    let Picture { colors, depths, labels } = &mut picture;
    let size = band_rows * width;
    let (mut depths, mut labels) = (depths.chunks_mut(size), labels.chunks_mut(size));
    for (index, colors) in colors.chunks_mut(3 * size).enumerate() {
        let depths = depths.next().unwrap_or_default();
        let labels = labels.next().unwrap_or_default();
        bands.push(Band { first_row: index * band_rows, colors, depths, labels });
    }
    let view = View::of(camera);
    let projected = match scene.object {
        Object::Surface(posed) => Some(posed.projected(camera)),
        Object::Gaussians(_) => None,
    };
    let draw_band = |band: &mut Band<'_>| {
        if is_cancelled() {
            return;
        }
        RASTER.with_borrow_mut(|raster| {
            let rows = band.colors.len() / (3 * width);
            raster.begin(width, band.first_row, rows);
            if let Some(projected) = &projected {
                projected.draw(raster, OBJECT);
            }
            for (prop, label) in scene.props.iter().zip(OBJECT + 1..) {
                let color = linear(prop.color);
                prop.solid.draw(&prop.pose, color, scene.light, &view, raster, label);
            }
            Composition { scene, raster, width }.fill(band);
        });
    };
    // A band alone would only be handed to another thread.
    match &mut bands[..] {
        [band] => draw_band(band),
        bands => bands.par_iter_mut().for_each(draw_band),
    }
    (!is_cancelled()).then_some(picture)
}

/// A band of rows of a picture that is being drawn; depths and labels are empty if they are not wanted.
struct Band<'a> {
    first_row: usize,
    colors: &'a mut [u8],
    depths: &'a mut [f32],
    labels: &'a mut [u8],
}

/// A camera, by samples.
pub(crate) struct View {
    /// Axes of the camera in the world, and the motion to its coordinates.
    world_to_camera: [[f64; 4]; 3],
    /// Slopes x / z and y / z of the ray through the first sample, and their steps by column and row.
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) step: [f64; 2],
}

impl View {
    pub(crate) fn of(camera: &Camera) -> Self {
        let samples = SAMPLES as f64;
        // The centre of the first pixel is at 0, that of its first sample half a sample from the pixel's edge.
        let first = 0.5 / samples - 0.5;
        let [fx, fy, cx, cy] = [camera.fx, camera.fy, camera.cx, camera.cy].map(f64::from);
        Self {
            world_to_camera: camera.world_to_camera.map(|row| row.map(f64::from)),
            left: (first - cx) / fx,
            top: (first - cy) / fy,
            step: [1.0 / (samples * fx), 1.0 / (samples * fy)],
        }
    }

    /// A point of the world in the axes of the camera [m].
    pub(crate) fn seen_wide(&self, point: Vector) -> Vector {
        self.world_to_camera.map(|[x, y, z, t]| dot([x, y, z], point) + t)
    }

    /// The same of a point in single precision.
    pub(crate) fn seen(&self, point: Point) -> Point {
        self.seen_wide(wide(point)).map(|x| x as f32)
    }

    /// Place in the picture [samples] and inverse depth [1/m] of a point in the axes of the camera.
    pub(crate) fn placed(&self, [x, y, z]: Point) -> [f32; 3] {
        let inverse = 1.0 / f64::from(z);
        let column = (f64::from(x) * inverse - self.left) / self.step[0] + 0.5;
        let row = (f64::from(y) * inverse - self.top) / self.step[1] + 0.5;
        [column as f32, row as f32, inverse as f32]
    }

    /// A direction in the axes of the camera in those of the world.
    pub(crate) fn in_world(&self, direction: Vector) -> Vector {
        let m = &self.world_to_camera;
        [0, 1, 2].map(|a| m[0][a] * direction[0] + m[1][a] * direction[1] + m[2][a] * direction[2])
    }

    /// The plane n · x = offset of the world in the axes of the camera.
    pub(crate) fn plane(&self, normal: Vector, offset: f64) -> (Vector, f64) {
        let turned = self.world_to_camera.map(|[x, y, z, _]| dot([x, y, z], normal));
        let moved = dot(turned, self.world_to_camera.map(|row| row[3]));
        (turned, offset + moved)
    }
}

#[cfg(test)]
mod tests;
