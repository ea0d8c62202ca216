//! Frequent mistakes with calibrations, tried one after another. The one that explains the misfit
//! is the one whose reversal leaves the smallest misfit.

use super::{
    ViewSet,
    hypothesis::{Hypothesis, PoseChange},
};
use crate::thresholds::ConsistencyThresholds;

/// Units of translations that people mix up.
const UNITS: [f64; 8] = [0.001, 0.01, 0.0254, 0.1, 10.0, 39.37, 100.0, 1000.0];
/// Cameras up to which all permutations are tried; with more, only pairs are exchanged.
const MAX_PERMUTED_CAMERAS: usize = 4;

/// A mistake that may have been made.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Mistake {
    /// The same change of every camera's pose.
    All(PoseChange),
    /// A change of one view's pose.
    One(usize, PoseChange),
    /// View i has the calibration of the i-th of these.
    Exchanged(Vec<usize>),
    /// Depth of every camera is off by a factor.
    Depth(f64),
    /// Depth of one view is off by a factor.
    DepthOfOne(usize, f64),
}

impl Mistake {
    /// True if it is about lengths alone.
    pub(crate) fn is_about_units(&self, thresholds: &ConsistencyThresholds) -> bool {
        let is_unit = |factor: &f64| is_unit(*factor, thresholds);
        match self {
            Self::All(change) | Self::One(_, change) => matches!(change, PoseChange::Units(_)),
            Self::Depth(factor) | Self::DepthOfOne(_, factor) => is_unit(factor),
            Self::Exchanged(_) => false,
        }
    }
}

/// A mistake and the misfit that remains when it is undone.
#[derive(Clone, Debug)]
pub(crate) struct Explanation {
    pub(crate) mistake: Mistake,
    /// The cameras without it.
    pub(crate) hypothesis: Hypothesis,
    pub(crate) misfit: f64,
}

/// The mistake whose undoing leaves the least misfit. Simple and frequent ones come first and win
/// ties.
pub(crate) fn explain(set: &ViewSet<'_>) -> Option<Explanation> {
    let declared = Hypothesis::declared(set.views.len());
    let mut best: Option<Explanation> = None;
    for (mistake, hypothesis) in mistakes(set, &declared) {
        let Some(misfit) = set.misfit(&hypothesis) else { continue };
        if best.as_ref().is_none_or(|b| misfit < set.thresholds.better_ratio * b.misfit) {
            best = Some(Explanation { mistake, hypothesis, misfit });
        }
    }
    best
}

fn mistakes(set: &ViewSet<'_>, declared: &Hypothesis) -> Vec<(Mistake, Hypothesis)> {
    let n = set.views.len();
    let changes = [
        PoseChange::Inverse,
        PoseChange::OpenGl,
        PoseChange::Body,
        PoseChange::InverseOpenGl,
        PoseChange::RotationInverse,
        PoseChange::Mirrored(0),
        PoseChange::Mirrored(1),
        PoseChange::Mirrored(2),
        PoseChange::MirroredPlace(0),
        PoseChange::MirroredPlace(1),
        PoseChange::MirroredPlace(2),
    ];
    let units = UNITS.map(PoseChange::Units);
    let mut all: Vec<(Mistake, Hypothesis)> = Vec::new();
    for change in changes.into_iter().chain(units) {
        all.push((Mistake::All(change), declared.with_all(|s| s.change = change)));
    }
    for order in orders(n) {
        let mut hypothesis = declared.clone();
        for (camera, calibration) in hypothesis.0.iter_mut().zip(&order) {
            camera.calibration = *calibration;
        }
        all.push((Mistake::Exchanged(order), hypothesis));
    }
    if let Some(scaled) = super::depth_scale::of_all(set, declared).filter(|s| s.factor != 1.0) {
        let hypothesis = declared.with_all(|s| s.depth_scale = scaled.factor);
        all.push((Mistake::Depth(scaled.factor), hypothesis));
    }
    for which in 0..n {
        if let Some(scaled) = super::depth_scale::of_one(set, declared, which)
            .filter(|s| n > 2 || is_unit(s.factor, set.thresholds))
        {
            let hypothesis = declared.with(which, |s| s.depth_scale = scaled.factor);
            all.push((Mistake::DepthOfOne(which, scaled.factor), hypothesis));
        }
        for change in changes.into_iter().chain(units) {
            let hypothesis = declared.with(which, |s| s.change = change);
            all.push((Mistake::One(which, change), hypothesis));
        }
    }
    all
}

/// True for a factor of another unit rather than an error of scale. With two cameras, smaller
/// factors cannot be assigned to one of them.
fn is_unit(factor: f64, thresholds: &ConsistencyThresholds) -> bool {
    !thresholds.same_unit.contains(&factor)
}

/// Exchanges of two, and for few cameras all orders but the declared.
fn orders(n: usize) -> Vec<Vec<usize>> {
    let mut orders = Vec::new();
    for a in 0..n {
        for b in a + 1..n {
            let mut order: Vec<usize> = (0..n).collect();
            order.swap(a, b);
            orders.push(order);
        }
    }
    if n <= MAX_PERMUTED_CAMERAS {
        let mut order: Vec<usize> = (0..n).collect();
        permute(&mut order, 0, &mut orders);
    }
    orders
}

fn permute(order: &mut Vec<usize>, from: usize, orders: &mut Vec<Vec<usize>>) {
    if from == order.len() {
        let is_declared = order.iter().enumerate().all(|(i, o)| i == *o);
        if !is_declared && !orders.contains(order) {
            orders.push(order.clone());
        }
        return;
    }
    for i in from..order.len() {
        order.swap(from, i);
        permute(order, from + 1, orders);
        order.swap(from, i);
    }
}
