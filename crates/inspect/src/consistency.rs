//! Multi-view consistency: the surface that one camera measured is reprojected into each of the
//! others.
//!
//! A point must appear inside the other camera's masks, and not in front of what that camera
//! measured; where both cameras face the surface, both must measure one depth. The misfit says how
//! badly this fails, from 0 to 1. A hypothesis about the calibration (these two cameras are
//! exchanged, that depth is in millimetres) is judged by how much of the misfit it removes.

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
use crate::{
    scan::{
        CameraScan,
        crop::{Crop, Label, Surfel},
    },
    thresholds::ConsistencyThresholds,
};

/// A camera of a [`ViewSet`], with what it saw in the frames whose crops were kept.
#[derive(Debug)]
pub(crate) struct View<'a> {
    /// Index into the recording's cameras.
    pub(crate) index: usize,
    pub(crate) camera: &'a Camera,
    pub(crate) crops: Vec<SampledCrop<'a>>,
}

/// A crop and surfels of its surface.
#[derive(Debug)]
pub(crate) struct SampledCrop<'a> {
    pub(crate) crop: &'a Crop,
    pub(crate) surfels: Vec<Surfel>,
}

/// The views of a recording: cameras that saw the object in some frame of which a crop was kept. A
/// frame whose mask of the object is empty is left out: what should be the object there would count
/// against the others.
pub(crate) fn views<'a>(
    cameras: &'a [Camera],
    scans: &'a [CameraScan],
    thresholds: &ConsistencyThresholds,
) -> Vec<View<'a>> {
    let seeing = scans.iter().filter(|scan| !scan.crops.is_empty()).count();
    let most = if seeing > thresholds.many_cameras {
        thresholds.max_surfels_many_cameras
    } else {
        thresholds.max_surfels
    };
    let shows_object = |crop: &&Crop| crop.labels.contains(&Label::Object);
    let with_crops = cameras.iter().zip(scans).enumerate();
    with_crops
        .filter(|(_, (_, scan))| scan.crops.iter().any(|crop| shows_object(&crop)))
        .map(|(index, (camera, scan))| {
            let crops = scan.crops.iter().filter(shows_object).map(|crop| SampledCrop {
                crop,
                surfels: surfels(crop, camera, most, thresholds.min_normal_share),
            });
            View { index, camera, crops: crops.collect() }
        })
        .collect()
}

fn surfels(crop: &Crop, camera: &Camera, most: usize, min_normal_share: f64) -> Vec<Surfel> {
    let all = crop.surfels(camera, 2 * most);
    let with_normal: Vec<Surfel> = all.iter().filter(|s| s.normal != [0.0; 3]).copied().collect();
    let enough = with_normal.len() as f64 > min_normal_share * all.len() as f64;
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
    /// Frames in which views are compared: those in which the object moves least, so that skew does
    /// not matter.
    pub(crate) frames: Vec<usize>,
    /// Every `stride`-th surfel is reprojected.
    pub(crate) stride: usize,
    pub(crate) thresholds: &'a ConsistencyThresholds,
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
            compare(surfels, &posed, other.crop, &other_posed, self.thresholds, &mut reprojection);
        }
        reprojection
    }

    /// Mean misfit over the pairs that `selects` names, both ways, 0..=1; `None` if nothing can be
    /// compared.
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

    /// Median distance over all pairs between the surfaces of two views where both face them [m].
    pub(crate) fn disagreement_m(&self, hypothesis: &Hypothesis) -> Option<f64> {
        let n = self.views.len();
        let pairs = (0..n).flat_map(|a| (0..n).map(move |b| (a, b))).filter(|(a, b)| a != b);
        let apart = pairs.filter_map(|(a, b)| self.reproject(a, b, hypothesis).disagreement_m());
        crate::statistics::median(apart)
    }

    /// Mean misfit over all pairs.
    pub(crate) fn misfit(&self, hypothesis: &Hypothesis) -> Option<f64> {
        self.misfit_of(hypothesis, |_, _| true)
    }
}

#[cfg(test)]
mod tests;
