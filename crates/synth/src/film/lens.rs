//! The recording of one camera: colour, depth as a stereo camera measures it, and masks as a
//! segmenter draws them.

use bendtwin_core::Point;

use super::{
    Stage,
    props::{MIDDLE_M, Props, TABLE_Z_M, Thing},
    tracker,
};
use crate::{
    pose::{add, dot, scale, sub, unit},
    raster::{Hit, Raster},
    sheet::Sheet,
    texture::{chance, normal},
};
use bendtwin_capture::{
    Error,
    raw::{Camera, ColorImage, DepthImage, Frames, Image, Mask, Region, Tracks},
};

/// Deviation of depth [m at 1 m]; it grows with the square of distance.
const DEPTH_NOISE: f32 = 0.0012;
/// Share of pixels without depth anywhere, at edges of things, and where a surface is seen flatter
/// than the cosine.
const HOLES: f32 = 0.004;
const EDGE_HOLES: f32 = 0.6;
const FLAT: f32 = 0.2;
/// A neighbour this much nearer or farther makes an edge [m].
const EDGE_M: f32 = 0.015;
/// Share of pixels at a mask's rim that the segmenter leaves out.
const RIM: f32 = 0.3;
/// Deviation of colour, of 255.
const COLOR_NOISE: f32 = 2.0;
/// Length [m] over which colours vary at least, and the same in pixels.
const PATCH_M: f64 = 0.012;
const PATCH_PIXELS: f64 = 5.0;

/// Rays to each side through a pixel of a sheet.
const RAYS: usize = 4;

/// Keys that keep the kinds of noise apart.
const COLOR: i64 = 1;
const DEPTH: i64 = 4;
const HOLE: i64 = 5;
const MASK: i64 = 6;

/// Reads the frames of a camera.
pub(super) struct Reader<'a> {
    stage: &'a Stage,
    camera: usize,
    /// The frame drawn last: colour, depth and masks are requested one after another.
    last: Option<(usize, View)>,
}

/// A drawn frame.
#[derive(Clone, Debug)]
pub(super) struct View {
    pub(super) vertices: Vec<Point>,
    pub(super) raster: Raster,
}

impl<'a> Reader<'a> {
    pub(super) fn new(stage: &'a Stage, camera: usize) -> Self {
        Self { stage, camera, last: None }
    }

    fn lens(&self) -> &'a Camera {
        &self.stage.cameras[self.camera]
    }

    /// Computes an image pixel by pixel, `None` if there is no such frame.
    fn image<P>(
        &mut self,
        frame: usize,
        pixel: impl Fn(&Stage, &View, usize, usize) -> P,
    ) -> Option<Image<P>> {
        let (stage, camera) = (self.stage, self.lens());
        if self.last.as_ref().is_none_or(|(drawn, _)| *drawn != frame) {
            self.last = Some((frame, stage.view(self.camera, frame)?));
        }
        let (_, view) = self.last.as_ref()?;
        let (width, height) = (camera.width, camera.height);
        let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
        let pixels = pixels.map(|(column, row)| pixel(stage, view, column, row)).collect();
        Some(Image { width, height, pixels })
    }

    /// A seed of this camera and frame.
    fn seed(&self, frame: usize) -> u64 {
        self.stage.options.seed ^ ((self.camera as u64) << 40) ^ ((frame as u64) << 16)
    }
}

impl Stage {
    /// Draws a frame as a camera sees it.
    pub(super) fn view(&self, camera: usize, frame: usize) -> Option<View> {
        let vertices = self.props.posed(self.bodies.get(frame)?, &self.actors, frame)?;
        let raster = Raster::draw(self.cameras.get(camera)?, &vertices, &self.props.triangles);
        Some(View { vertices, raster })
    }

    /// The corners of a triangle in `positions`.
    pub(super) fn corners(&self, triangle: u32, positions: &[Point]) -> [Point; 3] {
        self.props.triangles[triangle as usize].map(|v| positions[v as usize])
    }
}

impl Frames for Reader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        let (seed, camera) = (self.seed(frame), self.lens());
        let patch_m = PATCH_M.max(PATCH_PIXELS * 0.9 / camera.intrinsics.fx) as f32;
        Ok(self.image(frame, |stage, view, column, row| {
            let Some(hit) = view.raster.get(column as i64, row as i64) else { return [200; 3] };
            let corners = stage.corners(hit.triangle, &stage.props.rest);
            let (thing, rest) = (stage.props.thing(hit.triangle), blend(&hit, corners));
            let mut color = Props::color(thing, rest, patch_m, &stage.options.dyes);
            if let Some(sheet) = stage.options.sheet.as_ref().filter(|_| thing == Thing::Table) {
                color = printed(sheet, camera, frame, [column, row], color);
            }
            let light = unit([0.3, -0.2, 0.9]);
            let facing = dot(normal_of(stage.corners(hit.triangle, &view.vertices)), light);
            let shade = 0.8 + 0.2 * facing.max(0.0);
            std::array::from_fn(|channel| {
                let at = [column as i64, row as i64, channel as i64, COLOR];
                let noise = COLOR_NOISE * normal(seed, at);
                (255.0 * color[channel] * shade + noise).round().clamp(0.0, 255.0) as u8
            })
        }))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        let (seed, camera) = (self.seed(frame), self.lens());
        let eye = camera.pose(frame).translation.map(|x| x as f32);
        Ok(self.image(frame, |stage, view, column, row| {
            let (column, row) = (column as i64, row as i64);
            let Some(hit) = view.raster.get(column, row) else { return 0.0 };
            let corners = stage.corners(hit.triangle, &view.vertices);
            let towards = unit(sub(eye, blend(&hit, corners)));
            let is_edge = [[1, 0], [-1, 0], [0, 1], [0, -1]].iter().any(|[x, y]| {
                let beside = view.raster.get(column + x, row + y);
                beside.is_some_and(|b| (b.depth_m - hit.depth_m).abs() > EDGE_M)
            });
            let holes = if is_edge { EDGE_HOLES } else { HOLES };
            if chance(seed, [column, row, 0, HOLE]) < holes
                || dot(normal_of(corners), towards).abs() < FLAT
            {
                return 0.0;
            }
            let sigma = stage.options.noise * DEPTH_NOISE * hit.depth_m * hit.depth_m;
            let measured = hit.depth_m + sigma * normal(seed, [column, row, 0, DEPTH]);
            // Cameras give whole millimetres.
            (measured * 1000.0).round() / 1000.0
        }))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        let seed = self.seed(frame);
        let wanted = match region {
            Region::Object => Thing::Body,
            Region::Manipulator => Thing::Hand,
        };
        Ok(self.image(frame, |stage, view, column, row| {
            let (column, row) = (column as i64, row as i64);
            let shows = |column, row| {
                let hit: Option<Hit> = view.raster.get(column, row);
                hit.is_some_and(|hit| stage.props.thing(hit.triangle) == wanted)
            };
            if !shows(column, row) {
                return false;
            }
            let around = [[1, 0], [-1, 0], [0, 1], [0, -1]];
            let is_rim = around.iter().any(|[x, y]| !shows(column + x, row + y));
            !is_rim || chance(seed, [column, row, 0, MASK]) >= RIM
        }))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        if !self.stage.options.tracks {
            return Ok(None);
        }
        Ok(Some(tracker::track(self.stage, self.camera)))
    }
}

/// The colour of a pixel of the table, on part of which a sheet may lie.
fn printed(
    sheet: &Sheet,
    camera: &Camera,
    frame: usize,
    [column, row]: [usize; 2],
    table: Point,
) -> Point {
    let eye = camera.pose(frame).translation;
    let mut sum = [0.0; 3];
    for ray in 0..RAYS * RAYS {
        let [x, y] = [ray % RAYS, ray / RAYS].map(|k| (k as f64 + 0.5) / RAYS as f64 - 0.5);
        let to = camera.unproject([column as f64 + x, row as f64 + y], 1.0, frame);
        let down = f64::from(TABLE_Z_M) - eye[2];
        let share = down / (f64::from(to[2]) - eye[2]);
        let at: [f64; 2] = std::array::from_fn(|k| eye[k] + share * (f64::from(to[k]) - eye[k]));
        let color = match sheet.at([at[0] - f64::from(MIDDLE_M), at[1]]) {
            Some(true) => [0.08; 3],
            Some(false) => [0.92; 3],
            None => table,
        };
        sum = add(sum, color);
    }
    scale(sum, 1.0 / (RAYS * RAYS) as f32)
}

/// The point of a triangle that was hit.
pub(super) fn blend(hit: &Hit, corners: [Point; 3]) -> Point {
    std::array::from_fn(|a| (0..3).map(|k| hit.shares[k] * corners[k][a]).sum())
}

fn normal_of([a, b, c]: [Point; 3]) -> Point {
    let (u, v) = (sub(b, a), sub(c, a));
    unit([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]])
}
