//! The log of each camera's tracks, and the result that is made of it.

use bendtwin_capture::raw::{Region, Tracks};
use bendtwin_core::geometry::median;

use crate::{Guide, Texture, TrackerQuality, quality::mean_share};

/// Tracks of one camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraTracks {
    /// Tracks of the object, then of the manipulator. While a point is not seen, its place is where
    /// its neighbours put it, or where it was last seen; before it was seeded, where it was seeded.
    pub tracks: Tracks,
    /// The region that each track lies on, shape [N].
    pub regions: Vec<Region>,
    /// Their quality.
    pub quality: TrackerQuality,
}

/// Everything found in one camera, frame after frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct CameraLog {
    /// Region of each track.
    pub(crate) regions: Vec<Region>,
    /// Median texture of the object and of the manipulator.
    pub(crate) textures: [Option<f64>; 2],
    pub(crate) guide: Option<Guide>,
    pub(crate) contradicted_by: Vec<usize>,
    /// Places by frame since the tracks were seeded, then by track.
    points: Vec<[f32; 2]>,
    visible: Vec<bool>,
    pub(crate) forward_backward: Vec<f64>,
    pub(crate) deviations: Vec<f64>,
}

impl CameraLog {
    /// The next track of the frame that is being logged.
    pub(crate) fn push(&mut self, at: [f64; 2], visible: bool) {
        self.points.push(at.map(|v| v as f32));
        self.visible.push(visible);
    }

    /// The tracks, over all frames.
    pub(crate) fn finish(mut self, frames: usize, camera: &str, min_texture: f64) -> CameraTracks {
        let count = self.regions.len();
        let missing = (frames * count).saturating_sub(self.points.len());
        let first = &self.points[..count.min(self.points.len())];
        let mut points: Vec<_> = first.iter().copied().cycle().take(missing).collect();
        points.append(&mut self.points);
        let mut visible = vec![false; missing];
        visible.append(&mut self.visible);
        let of = |region| self.regions.iter().filter(|&&r| r == region).count();
        let survivors = |region| -> Vec<usize> {
            let seen = |f: usize| {
                let row = visible[f * count..(f + 1) * count].iter().zip(&self.regions);
                row.filter(|&(&seen, &on)| seen && on == region).count()
            };
            (0..frames).map(seen).collect()
        };
        let object_points = of(Region::Object);
        let object_survivors = survivors(Region::Object);
        let kept = mean_share(&object_survivors, object_points);
        let verdict = Texture::judge(self.textures[0], object_points, kept, min_texture);
        let quality = TrackerQuality {
            object_points,
            manipulator_points: of(Region::Manipulator),
            object_survivors,
            manipulator_survivors: survivors(Region::Manipulator),
            manipulator_guide: self.guide,
            forward_backward_px: median(&mut self.forward_backward),
            deviation_m: median(&mut self.deviations),
            object_texture: self.textures[0],
            manipulator_texture: self.textures[1],
            verdict,
            summary: verdict.summary(camera, &self.contradicted_by),
            contradicted_by: self.contradicted_by,
        };
        CameraTracks { tracks: Tracks { count, points, visible }, regions: self.regions, quality }
    }
}
