//! Images of a sheet, ray by ray.

use std::sync::{Arc, OnceLock};

use bendtwin_capture::{
    Error, Sources,
    raw::{
        Camera, ColorImage, DepthImage, Frames, Image, Mask, Pose, Recording, Region, Source,
        Tracks,
    },
};
use bendtwin_core::{Environment, geometry::IDENTITY};

use super::SheetFilm;
use crate::texture::normal;

/// Rays to each side through a pixel.
const RAYS: usize = 4;
/// Brightness of black, of white and of the table, of 255.
const INK: f64 = 25.0;
const PAPER: f64 = 215.0;
const TABLE: f64 = 120.0;
/// Deviation of depth [m at 1 m]; it grows with the square of distance.
const DEPTH_NOISE: f64 = 0.0012;
/// Frames per second.
const FPS: f64 = 30.0;

/// Films a sheet.
pub fn film_sheet(film: SheetFilm) -> Recording {
    let frame_count = film.places.len();
    let cameras = film.cameras.clone();
    let rays = cameras.iter().map(|_| OnceLock::new()).collect();
    Recording {
        name: "sheet".to_owned(),
        fps: FPS,
        frame_count,
        train_frame_count: frame_count,
        environment: Environment::Z_UP,
        source_to_world: IDENTITY,
        cameras,
        mesh: None,
        truth_tracks: Vec::new(),
        mass_kg: None,
        grippers: Vec::new(),
        notes: Vec::new(),
        sources: Sources::default(),
        source: Arc::new(Stage { film, rays }),
    }
}

#[derive(Debug)]
struct Stage {
    film: SheetFilm,
    /// For each camera where the rays at the corners of its pixels meet depth 1, shape
    /// [height + 1, width + 1].
    rays: Vec<OnceLock<Vec<[f64; 2]>>>,
}

impl Source for Stage {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        let seen = self.film.cameras.get(camera).ok_or(Error::NoCamera(camera))?;
        let rays = self.rays[camera].get_or_init(|| corner_rays(seen));
        Ok(Box::new(Reader { film: &self.film, index: camera, camera: seen, rays }))
    }
}

fn corner_rays(camera: &Camera) -> Vec<[f64; 2]> {
    let corners = (0..=camera.height).flat_map(|row| (0..=camera.width).map(move |c| (row, c)));
    corners
        .map(|(row, column)| {
            let at = [column as f64 - 0.5, row as f64 - 0.5];
            camera.distortion.undistort(camera.intrinsics.plane(at))
        })
        .collect()
}

struct Reader<'a> {
    film: &'a SheetFilm,
    index: usize,
    camera: &'a Camera,
    rays: &'a [[f64; 2]],
}

/// The sheet as a camera sees it in a frame.
struct Scene {
    /// From the camera to the sheet.
    to_sheet: Option<Pose>,
    /// From the camera to the world.
    to_world: Pose,
}

impl Reader<'_> {
    fn scene(&self, frame: usize) -> Option<Scene> {
        let place = *self.film.places.get(frame)?;
        let to_world = *self.camera.pose(0);
        let to_sheet = place.map(|place| place.inverse().after(&to_world));
        Some(Scene { to_sheet, to_world })
    }

    /// The ray through a pixel, at shares of its width and height.
    fn ray(&self, column: usize, row: usize, [x, y]: [f64; 2]) -> [f64; 2] {
        let stride = self.camera.width + 1;
        let corner = |dc: usize, dr: usize| self.rays[(row + dr) * stride + column + dc];
        let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
        std::array::from_fn(|k| {
            (a[k] * (1.0 - x) + b[k] * x) * (1.0 - y) + (c[k] * (1.0 - x) + d[k] * x) * y
        })
    }

    fn brightness(&self, scene: &Scene, ray: [f64; 2]) -> f64 {
        let sheet = scene.to_sheet.as_ref().and_then(|to_sheet| {
            let ([x, y], _) = hit(to_sheet, ray, 0.0)?;
            self.film.sheet.at([x, y])
        });
        match sheet {
            Some(true) => INK,
            Some(false) => PAPER,
            None => TABLE,
        }
    }
}

/// Where a ray meets the plane at a height in the frame that `motion` leads to, and its depth.
fn hit(motion: &Pose, ray: [f64; 2], height: f64) -> Option<([f64; 2], f64)> {
    let from = motion.translation;
    let to = motion.moved([ray[0], ray[1], 1.0]);
    let fall = to[2] - from[2];
    let depth = (height - from[2]) / fall;
    let at = |axis: usize| from[axis] + (to[axis] - from[axis]) * depth;
    (fall < 0.0 && depth > 0.0).then(|| ([at(0), at(1)], depth))
}

impl Frames for Reader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        let Some(scene) = self.scene(frame) else { return Ok(None) };
        let (width, height) = (self.camera.width, self.camera.height);
        let mut image = Vec::with_capacity(width * height);
        for (row, column) in (0..height).flat_map(|row| (0..width).map(move |c| (row, c))) {
            let ends = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
            let values = ends.map(|end| self.brightness(&scene, self.ray(column, row, end)));
            // Only where something ends, or small things may lie, more rays are needed.
            let value = if values.iter().all(|value| *value == TABLE) {
                TABLE
            } else {
                let places = (0..RAYS * RAYS)
                    .map(|n| [n % RAYS, n / RAYS].map(|k| (k as f64 + 0.5) / RAYS as f64));
                let sum: f64 =
                    places.map(|at| self.brightness(&scene, self.ray(column, row, at))).sum();
                sum / (RAYS * RAYS) as f64
            };
            let light = 0.75 + 0.35 * column as f64 / width as f64;
            image.push(value * light);
        }
        let image = blurred(&image, width, self.film.blur_px);
        let seed = self.film.seed ^ ((self.index as u64) << 40) ^ ((frame as u64) << 16);
        let pixel = |(number, value): (usize, &f64)| {
            let at = [(number % width) as i64, (number / width) as i64, 0, 1];
            let noisy = value + self.film.noise * f64::from(normal(seed, at));
            [noisy.round().clamp(0.0, 255.0) as u8; 3]
        };
        let pixels = image.iter().enumerate().map(pixel).collect();
        Ok(Some(Image { width, height, pixels }))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        let Some(scene) = self.scene(frame) else { return Ok(None) };
        let (width, height) = (self.camera.width, self.camera.height);
        let seed = self.film.seed ^ ((self.index as u64) << 40) ^ ((frame as u64) << 16);
        let pixel = |(row, column): (usize, usize)| {
            let ray = self.ray(column, row, [0.5, 0.5]);
            let sheet = scene.to_sheet.as_ref().and_then(|to_sheet| {
                let (at, depth) = hit(to_sheet, ray, 0.0)?;
                self.film.sheet.at(at).map(|_| depth)
            });
            let table = hit(&scene.to_world, ray, self.film.table_m).map(|(_, depth)| depth);
            let depth = sheet.or(table).filter(|depth| *depth < 4.0).unwrap_or_default();
            let at = [column as i64, row as i64, 0, 4];
            let noise = DEPTH_NOISE * depth * depth * f64::from(normal(seed, at));
            (((depth + noise) * self.film.depth_scale * 1e3).round() / 1e3) as f32
        };
        let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
        Ok(Some(Image { width, height, pixels: pixels.map(pixel).collect() }))
    }

    fn mask(&mut self, _: usize, _: Region) -> Result<Option<Mask>, Error> {
        Ok(None)
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        Ok(None)
    }
}

/// An image blurred by a Gaussian.
fn blurred(image: &[f64], width: usize, sigma: f64) -> Vec<f64> {
    let reach = (3.0 * sigma).ceil() as i64;
    if reach == 0 || image.is_empty() {
        return image.to_vec();
    }
    let weights: Vec<f64> =
        (-reach..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
    let total: f64 = weights.iter().sum();
    let height = image.len() / width;
    let pass = |source: &[f64], across: bool| -> Vec<f64> {
        let at = |row: usize, column: usize| {
            let sum: f64 = (-reach..=reach)
                .zip(&weights)
                .map(|(k, weight)| {
                    let moved =
                        |n: usize, size: usize| (n as i64 + k).clamp(0, size as i64 - 1) as usize;
                    let (row, column) = if across {
                        (row, moved(column, width))
                    } else {
                        (moved(row, height), column)
                    };
                    weight * source[row * width + column]
                })
                .sum();
            sum / total
        };
        (0..image.len()).map(|n| at(n / width, n % width)).collect()
    };
    pass(&pass(image, true), false)
}
