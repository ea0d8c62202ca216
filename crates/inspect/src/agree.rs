//! Whether cameras see one and the same thing: the surface that one camera measured is looked at from each of the others.
//!
//! A point must appear inside the other camera's masks, and not in front of what that camera measured; where both cameras
//! face the surface, both must measure one depth. How badly this fails is the misfit, and a suspicion about the recording
//! (these two cameras are exchanged, that depth is in millimetres) is tried by how well it removes the misfit.

pub(crate) mod correct;
pub(crate) mod meet;
pub(crate) mod scale;
pub(crate) mod setup;
pub(crate) mod suspect;

use bendtwin_capture::raw::Camera;

use self::{
    meet::{Meeting, meet},
    setup::Setup,
};
use crate::watch::{
    Log,
    sketch::{Sketch, Surfel},
};

/// Spots of each sketch that are compared.
const SPOTS: usize = 900;
/// Spots where there are many cameras, whose pairs grow with the square.
const FEW_SPOTS: usize = 200;
/// So many cameras are many.
const MANY_CAMERAS: usize = 6;
/// If fewer of the spots have a normal, the object is a thread, and spots without are taken too.
const SMOOTH_SHARE: f64 = 0.25;

/// What one camera saw in the sketched frames.
#[derive(Debug)]
pub(crate) struct Witness<'a> {
    /// Index into the recording's cameras.
    pub(crate) index: usize,
    pub(crate) camera: &'a Camera,
    pub(crate) views: Vec<Seen<'a>>,
}

/// One sketch and spots of its surface.
#[derive(Debug)]
pub(crate) struct Seen<'a> {
    pub(crate) sketch: &'a Sketch,
    pub(crate) spots: Vec<Surfel>,
}

/// The witnesses of a recording: cameras that saw the object in some sketched frame.
pub(crate) fn witnesses<'a>(cameras: &'a [Camera], logs: &'a [Log]) -> Vec<Witness<'a>> {
    let seeing = logs.iter().filter(|log| !log.sketches.is_empty()).count();
    let most = if seeing > MANY_CAMERAS { FEW_SPOTS } else { SPOTS };
    let with_sketches = cameras.iter().zip(logs).enumerate();
    with_sketches
        .filter(|(_, (_, log))| !log.sketches.is_empty())
        .map(|(index, (camera, log))| {
            let views = log
                .sketches
                .iter()
                .map(|sketch| Seen { sketch, spots: spots(sketch, camera, most) });
            Witness { index, camera, views: views.collect() }
        })
        .collect()
}

fn spots(sketch: &Sketch, camera: &Camera, most: usize) -> Vec<Surfel> {
    let all = sketch.surfels(camera, 2 * most);
    let smooth: Vec<Surfel> = all.iter().filter(|s| s.normal != [0.0; 3]).copied().collect();
    let enough = smooth.len() as f64 > SMOOTH_SHARE * all.len() as f64;
    let mut chosen = if enough { smooth } else { all };
    let step = chosen.len().div_ceil(most).max(1);
    let mut at = 0;
    chosen.retain(|_| {
        at += 1;
        (at - 1) % step == 0
    });
    chosen
}

/// Looks at all witnesses from each other.
pub(crate) struct Court<'a> {
    pub(crate) witnesses: Vec<Witness<'a>>,
    /// Frames in which cameras are compared: those in which the object moves least, so that skew does not matter.
    pub(crate) frames: Vec<usize>,
    /// Every so many spots are heard.
    pub(crate) every: usize,
}

impl Court<'_> {
    /// What witness `b` says of the spots of witness `a`.
    pub(crate) fn hear(&self, a: usize, b: usize, setup: &Setup) -> Meeting {
        let mut meeting = Meeting::default();
        let (Some(from), Some(to)) = (self.witnesses.get(a), self.witnesses.get(b)) else {
            return meeting;
        };
        for view in from.views.iter().filter(|v| self.frames.contains(&v.sketch.frame)) {
            let same = |other: &&Seen<'_>| other.sketch.frame == view.sketch.frame;
            let Some(other) = to.views.iter().find(same) else { continue };
            let frame = view.sketch.frame;
            let (Some(stand), Some(other_stand)) =
                (setup.stand(&self.witnesses, a, frame), setup.stand(&self.witnesses, b, frame))
            else {
                continue;
            };
            let spots = view.spots.iter().step_by(self.every.max(1));
            meet(spots, &stand, other.sketch, &other_stand, &mut meeting);
        }
        meeting
    }

    /// Mean misfit over the pairs that `concerns` selects, both ways, 0..=1; `None` if nothing can be compared.
    pub(crate) fn misfit_of(
        &self,
        setup: &Setup,
        concerns: impl Fn(usize, usize) -> bool,
    ) -> Option<f64> {
        let n = self.witnesses.len();
        let pairs = (0..n).flat_map(|a| (0..n).map(move |b| (a, b))).filter(|(a, b)| a != b);
        let heard = pairs.filter(|(a, b)| concerns(*a, *b)).map(|(a, b)| self.hear(a, b, setup));
        crate::statistics::mean(heard.filter_map(|m| m.misfit()))
    }

    /// Mean misfit over all pairs.
    pub(crate) fn misfit(&self, setup: &Setup) -> Option<f64> {
        self.misfit_of(setup, |_, _| true)
    }
}

#[cfg(test)]
mod tests;
