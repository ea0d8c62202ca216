//! What a camera sees in a frame, at the resolution at which masks are made, and where its pixels lie
//! in the world.

use bendtwin_capture::raw::{Camera, Frames};
use bendtwin_core::Point;

use crate::Error;

/// Pixels of all cameras together at which masks are made. Larger images are read at every second,
/// third, ... pixel: a mask needs no more, and memory stays bounded.
const MOST_PIXELS: usize = 3_000_000;
/// Depth nearer or farther than this counts as not measured [m].
const RANGE_M: std::ops::RangeInclusive<f32> = 0.05..=10.0;

/// A camera with the ray of every pixel.
pub(crate) struct Lens<'a> {
    pub(crate) camera: &'a Camera,
    /// Pixels of the image for one of the view, along columns and rows.
    pub(crate) stride: usize,
    /// Columns and rows of the view.
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Places on the plane at depth 1, shape [height, width].
    rays: Vec<[f32; 2]>,
}

/// Colour and depth of a camera in one frame.
pub(crate) struct View {
    pub(crate) frame: usize,
    /// Shape [height, width].
    pub(crate) colors: Vec<[u8; 3]>,
    /// Depth [m], 0 where nothing was measured. Shape [height, width].
    pub(crate) depths: Vec<f32>,
}

/// Columns and rows that a view skips, plus one, for cameras with these sizes.
pub(crate) fn stride(cameras: &[Camera]) -> usize {
    let pixels = |stride: usize| -> usize {
        cameras.iter().map(|c| c.width.div_ceil(stride) * c.height.div_ceil(stride)).sum()
    };
    let mut stride = 1;
    while pixels(stride) > MOST_PIXELS && stride < 64 {
        stride += 1;
    }
    stride
}

impl<'a> Lens<'a> {
    pub(crate) fn new(camera: &'a Camera, stride: usize) -> Self {
        let (width, height) = (camera.width.div_ceil(stride), camera.height.div_ceil(stride));
        let ray = |at: usize| {
            let pixel = [at % width, at / width].map(|n| (n * stride) as f64);
            camera.distortion.undistort(camera.intrinsics.plane(pixel)).map(|x| x as f32)
        };
        let rays = (0..width * height).map(ray).collect();
        Self { camera, stride, width, height, rays }
    }

    /// Number of pixels of a view.
    pub(crate) fn len(&self) -> usize {
        self.rays.len()
    }

    /// Points of the world at pixels with their depths, for one frame.
    pub(crate) fn places(&self, frame: usize) -> impl Fn(usize, f32) -> Point + '_ {
        let pose = self.camera.pose(frame);
        let rotation = pose.rotation.map(|row| row.map(|x| x as f32));
        let centre = pose.translation.map(|x| x as f32);
        move |at, depth| {
            let [x, y] = self.rays[at];
            let ray = [x * depth, y * depth, depth];
            std::array::from_fn(|a| {
                let row = rotation[a];
                row[0] * ray[0] + row[1] * ray[1] + row[2] * ray[2] + centre[a]
            })
        }
    }

    /// Reads a frame; `None` if its colour was not recorded. Without depth, nothing is measured.
    pub(crate) fn read(
        &self,
        frames: &mut dyn Frames,
        frame: usize,
    ) -> Result<Option<View>, Error> {
        let camera = self.camera;
        let Some(color) = frames.color(frame)? else { return Ok(None) };
        let depth = frames.depth(frame)?;
        let fits = |width: usize, height: usize| (width, height) == (camera.width, camera.height);
        if !fits(color.width, color.height)
            || !depth.as_ref().is_none_or(|d| fits(d.width, d.height))
        {
            let found = [color.width, color.height];
            let expected = [camera.width, camera.height];
            return Err(Error::ImageSize { camera: camera.name.clone(), frame, found, expected });
        }
        let kept = |at: usize| {
            let (column, row) = (at % self.width, at / self.width);
            row * self.stride * camera.width + column * self.stride
        };
        let colors = match self.stride {
            1 => color.pixels,
            _ => (0..self.len()).map(|at| color.pixels[kept(at)]).collect(),
        };
        let mut depths = match (depth, self.stride) {
            (None, _) => vec![0.0; self.len()],
            (Some(depth), 1) => depth.pixels,
            (Some(depth), _) => (0..self.len()).map(|at| depth.pixels[kept(at)]).collect(),
        };
        depths.iter_mut().filter(|d| !RANGE_M.contains(*d)).for_each(|d| *d = 0.0);
        Ok(Some(View { frame, colors, depths }))
    }
}

/// Square of the difference of two colours, of 255².
pub(crate) fn color_square(a: [u8; 3], b: [u8; 3]) -> f32 {
    (0..3).map(|k| (f32::from(a[k]) - f32::from(b[k])).powi(2)).sum()
}
