//! Multi-view consistency: the surface that one camera measured is reprojected into each of the others.
//!
//! A point must appear inside the other camera's masks, and not in front of what that camera measured; where both cameras
//! face the surface, both must measure one depth. The misfit says how badly this fails, from 0 to 1. A hypothesis about the
//! calibration (these two cameras are exchanged, that depth is in millimetres) is judged by how much of the misfit it
//! removes.

pub(crate) mod correction;
pub(crate) mod depth_scale;
pub(crate) mod hypothesis;
pub(crate) mod mistake;
pub(crate) mod reprojection;

use bendtwin_capture::raw::Camera;

use self::{
    hypothesis::Hypothesis,
    reprojection::{Reprojection, compare},
};
use crate::scan::{
    CameraScan,
    crop::{Crop, Surfel},
};

/// Surfels of each crop that are compared.
const MAX_SURFELS: usize = 900;
/// Surfels where there are many cameras, whose pairs grow with the square.
const MAX_SURFELS_MANY_CAMERAS: usize = 200;
/// With more cameras than this, fewer surfels are compared.
const MANY_CAMERAS: usize = 6;
/// If fewer of the surfels have a normal, the object is a thread, and surfels without are taken too.
const MIN_NORMAL_SHARE: f64 = 0.25;

/// One camera of a [`ViewSet`], with what it saw in the frames of which crops were kept.
#[derive(Debug)]
pub(crate) struct View<'a> {
    /// Index into the recording's cameras.
    pub(crate) index: usize,
    pub(crate) camera: &'a Camera,
    pub(crate) crops: Vec<SampledCrop<'a>>,
}

/// One crop and surfels of its surface.
#[derive(Debug)]
pub(crate) struct SampledCrop<'a> {
    pub(crate) crop: &'a Crop,
    pub(crate) surfels: Vec<Surfel>,
}

/// The views of a recording: cameras that saw the object in some frame of which a crop was kept.
pub(crate) fn views<'a>(cameras: &'a [Camera], scans: &'a [CameraScan]) -> Vec<View<'a>> {
    let seeing = scans.iter().filter(|scan| !scan.crops.is_empty()).count();
    let most = if seeing > MANY_CAMERAS { MAX_SURFELS_MANY_CAMERAS } else { MAX_SURFELS };
    let with_crops = cameras.iter().zip(scans).enumerate();
    with_crops
        .filter(|(_, (_, scan))| !scan.crops.is_empty())
        .map(|(index, (camera, scan))| {
            let crops = scan
                .crops
                .iter()
                .map(|crop| SampledCrop { crop, surfels: surfels(crop, camera, most) });
            View { index, camera, crops: crops.collect() }
        })
        .collect()
}

fn surfels(crop: &Crop, camera: &Camera, most: usize) -> Vec<Surfel> {
    let all = crop.surfels(camera, 2 * most);
    let with_normal: Vec<Surfel> = all.iter().filter(|s| s.normal != [0.0; 3]).copied().collect();
    let enough = with_normal.len() as f64 > MIN_NORMAL_SHARE * all.len() as f64;
    let mut chosen = if enough { with_normal } else { all };
    let step = chosen.len().div_ceil(most).max(1);
    let mut at = 0;
    chosen.retain(|_| {
        at += 1;
        (at - 1) % step == 0
    });
    chosen
}

/// The views that are compared with each other, and the frames and surfels in which that is done.
pub(crate) struct ViewSet<'a> {
    pub(crate) views: Vec<View<'a>>,
    /// Frames in which views are compared: those in which the object moves least, so that skew does not matter.
    pub(crate) frames: Vec<usize>,
    /// Every `stride`-th surfel is reprojected.
    pub(crate) stride: usize,
}

impl ViewSet<'_> {
    /// The surfels of view `a`, reprojected into view `b`.
    pub(crate) fn reproject(&self, a: usize, b: usize, hypothesis: &Hypothesis) -> Reprojection {
        let mut reprojection = Reprojection::default();
        let (Some(from), Some(to)) = (self.views.get(a), self.views.get(b)) else {
            return reprojection;
        };
        for sampled in from.crops.iter().filter(|s| self.frames.contains(&s.crop.frame)) {
            let frame = sampled.crop.frame;
            let same = |other: &&SampledCrop<'_>| other.crop.frame == frame;
            let Some(other) = to.crops.iter().find(same) else { continue };
            let (Some(posed), Some(other_posed)) =
                (hypothesis.posed(&self.views, a, frame), hypothesis.posed(&self.views, b, frame))
            else {
                continue;
            };
            let surfels = sampled.surfels.iter().step_by(self.stride.max(1));
            compare(surfels, &posed, other.crop, &other_posed, &mut reprojection);
        }
        reprojection
    }

    /// Mean misfit over the pairs that `selects` names, both ways, 0..=1; `None` if nothing can be compared.
    pub(crate) fn misfit_of(
        &self,
        hypothesis: &Hypothesis,
        selects: impl Fn(usize, usize) -> bool,
    ) -> Option<f64> {
        let n = self.views.len();
        let pairs = (0..n).flat_map(|a| (0..n).map(move |b| (a, b))).filter(|(a, b)| a != b);
        let reprojected =
            pairs.filter(|(a, b)| selects(*a, *b)).map(|(a, b)| self.reproject(a, b, hypothesis));
        crate::statistics::mean(reprojected.filter_map(|r| r.misfit()))
    }

    /// Mean misfit over all pairs.
    pub(crate) fn misfit(&self, hypothesis: &Hypothesis) -> Option<f64> {
        self.misfit_of(hypothesis, |_, _| true)
    }
}

#[cfg(test)]
mod tests;
