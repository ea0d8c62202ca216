//! Appearance of a point at some time, with the shape of the surface around it, by which it is
//! recognised after the surface has turned.

use bendtwin_capture::raw::{Camera, Region};
use bendtwin_core::Point;
use nalgebra::{Matrix3, Vector3};

use crate::{
    matching::{
        align::{Alignment, Warp, align},
        patch::Patch,
    },
    motion::vector,
    view::View,
};

/// A camera's view of a frame, with the camera and so its pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosedView<'a> {
    pub(crate) view: &'a View,
    pub(crate) camera: &'a Camera,
    pub(crate) frame: usize,
}

impl PosedView<'_> {
    /// The point of the world that is seen at a place, through depth smoothed within its surface.
    pub(crate) fn lift(&self, at: [f64; 2], region: Region, jump: f32) -> Option<Point> {
        let depth = self.view.depth(at, region, jump)?;
        Some(self.camera.unproject(at, f64::from(depth), self.frame))
    }
}

/// A patch on its surface.
#[derive(Clone, Debug)]
pub(crate) struct Appearance {
    patch: Patch,
    /// Place of each sample relative to the point, in the world's axes [m].
    cloud: Vec<[f32; 3]>,
    /// Rotation of the surroundings since seeding.
    rotation: Matrix3<f64>,
}

/// Change of area between patch and image beyond which they cannot be compared.
const AREA_RATIO: std::ops::RangeInclusive<f32> = 0.3..=3.3;
/// Largest distance from its start at which a patch may be found [px].
const MAX_SHIFT_PX: f32 = 4.0;
/// Least share of a patch that lies on its point's surface.
const MIN_SUPPORT: f32 = 0.4;

impl Appearance {
    /// Cut out around a place at which `point` is seen. `None` where too little of the window
    /// belongs to its surface.
    pub(crate) fn new(
        posed: PosedView<'_>,
        at: [f64; 2],
        region: Region,
        rotation: Matrix3<f64>,
        window: usize,
        jump: f32,
    ) -> Option<Self> {
        let level = posed.view.layer(region)?.levels.first()?;
        let point = posed.lift(at, region, jump)?;
        let (_, depth) = posed.camera.project(point, posed.frame)?;
        let mut patch = Patch::cut(level, at, window);
        let before: f32 = patch.samples.iter().map(|s| s.weight).sum();
        let mut cloud = Vec::with_capacity(patch.samples.len());
        patch.samples.retain(|sample| {
            let there = [0, 1].map(|i| at[i] + f64::from(sample.offset[i]));
            let Some(d) = posed.view.depth(there, region, jump) else { return false };
            if (f64::from(d) - depth).abs() > f64::from(jump) {
                return false;
            }
            let there = posed.camera.unproject(there, f64::from(d), posed.frame);
            cloud.push(std::array::from_fn(|i| there[i] - point[i]));
            true
        });
        let kept: f32 = patch.samples.iter().map(|s| s.weight).sum();
        patch.support *= kept / before;
        (patch.support >= MIN_SUPPORT).then_some(Self { patch, cloud, rotation })
    }

    /// Seeks it near `start`, where the point is at `point` and its surroundings have turned by
    /// `rotation` since seeding. `None` if it is seen too obliquely, or not found.
    pub(crate) fn find(
        &self,
        posed: PosedView<'_>,
        region: Region,
        start: [f64; 2],
        point: Point,
        rotation: &Matrix3<f64>,
    ) -> Option<Alignment> {
        let level = posed.view.layer(region)?.levels.first()?;
        let warp = self.warp(posed, point, &(rotation * self.rotation.transpose()))?;
        align(&self.patch, &warp, level, start, MAX_SHIFT_PX)
    }

    /// The warp of its samples into an image after a turn.
    fn warp(&self, posed: PosedView<'_>, point: Point, turn: &Matrix3<f64>) -> Option<Warp> {
        let (center, _) = posed.camera.project(point, posed.frame)?;
        let at = vector(point);
        let mut offsets = Vec::with_capacity(self.cloud.len());
        for offset in &self.cloud {
            let there = at + turn * Vector3::from(offset.map(f64::from));
            let there = [there.x as f32, there.y as f32, there.z as f32];
            let (there, _) = posed.camera.project(there, posed.frame)?;
            offsets.push([0, 1].map(|i| (there[i] - center[i]) as f32));
        }
        let jacobian = self.jacobian(&offsets)?;
        let [[a, b], [c, d]] = jacobian;
        let area = a * d - b * c;
        // The inverse of the transposed matrix.
        let gradients = [[d / area, -c / area], [-b / area, a / area]];
        AREA_RATIO.contains(&area).then_some(Warp { offsets, gradients })
    }

    /// The linear map that takes the patch's offsets to `offsets`, by weighted least squares.
    fn jacobian(&self, offsets: &[[f32; 2]]) -> Option<[[f32; 2]; 2]> {
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        let mut moments = [[0.0; 2]; 2];
        for (sample, there) in self.patch.samples.iter().zip(offsets) {
            let ([x, y], w) = (sample.offset, sample.weight);
            xx += w * x * x;
            xy += w * x * y;
            yy += w * y * y;
            for i in 0..2 {
                moments[i][0] += w * there[i] * x;
                moments[i][1] += w * there[i] * y;
            }
        }
        let determinant = xx * yy - xy * xy;
        (determinant > 1e-6 * xx * yy).then(|| {
            moments.map(|[x, y]| [(yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant])
        })
    }
}
