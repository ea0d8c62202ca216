//! Mistakes that people make with calibrations, tried one after the other: which of them, if it had been made, would
//! explain why the cameras disagree?

use super::{
    Court,
    setup::{Change, Setup},
};

/// Units of translations that people mix up.
const UNITS: [f64; 8] = [0.001, 0.01, 0.0254, 0.1, 10.0, 39.37, 100.0, 1000.0];
/// More cameras are not permuted in all ways.
const MOST_PERMUTED: usize = 4;

/// A mistake that may have been made.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Mistake {
    /// The same change of every camera's pose.
    All(Change),
    /// A change of one witness's pose.
    One(usize, Change),
    /// Witness i has the calibration of the i-th of these.
    Exchanged(Vec<usize>),
    /// Depth of every camera is off by a factor.
    Depth(f64),
    /// Depth of one witness is off by a factor.
    DepthOfOne(usize, f64),
}

impl Mistake {
    /// Whether it is about lengths alone.
    pub(crate) fn is_about_units(&self) -> bool {
        let is_unit = |factor: &f64| is_unit(*factor);
        match self {
            Self::All(change) | Self::One(_, change) => matches!(change, Change::Units(_)),
            Self::Depth(factor) | Self::DepthOfOne(_, factor) => is_unit(factor),
            Self::Exchanged(_) => false,
        }
    }
}

/// What remains if a mistake is repaired.
#[derive(Clone, Debug)]
pub(crate) struct Explanation {
    pub(crate) mistake: Mistake,
    pub(crate) misfit: f64,
}

/// The mistake that explains most. Simple and frequent ones come first and win ties.
pub(crate) fn explain(court: &Court<'_>) -> Option<Explanation> {
    let declared = Setup::declared(court.witnesses.len());
    let mut best: Option<Explanation> = None;
    for (mistake, setup) in mistakes(court, &declared) {
        let Some(misfit) = court.misfit(&setup) else { continue };
        if best.as_ref().is_none_or(|b| misfit < 0.97 * b.misfit) {
            best = Some(Explanation { mistake, misfit });
        }
    }
    best
}

fn mistakes(court: &Court<'_>, declared: &Setup) -> Vec<(Mistake, Setup)> {
    let n = court.witnesses.len();
    let changes = [
        Change::Inverse,
        Change::OpenGl,
        Change::InverseOpenGl,
        Change::RotationInverse,
        Change::Mirrored(0),
        Change::Mirrored(1),
        Change::Mirrored(2),
        Change::MirroredPlace(0),
        Change::MirroredPlace(1),
        Change::MirroredPlace(2),
    ];
    let units = UNITS.map(Change::Units);
    let mut all: Vec<(Mistake, Setup)> = Vec::new();
    for change in changes.into_iter().chain(units) {
        all.push((Mistake::All(change), declared.with_all(|s| s.change = change)));
    }
    for order in orders(n) {
        let mut setup = declared.clone();
        for (supposed, calibration) in setup.0.iter_mut().zip(&order) {
            supposed.calibration = *calibration;
        }
        all.push((Mistake::Exchanged(order), setup));
    }
    if let Some(scaled) = super::scale::of_all(court, declared).filter(|s| s.factor != 1.0) {
        let setup = declared.with_all(|s| s.depth_scale = scaled.factor);
        all.push((Mistake::Depth(scaled.factor), setup));
    }
    for which in 0..n {
        if let Some(scaled) =
            super::scale::of_one(court, declared, which).filter(|s| n > 2 || is_unit(s.factor))
        {
            let setup = declared.with(which, |s| s.depth_scale = scaled.factor);
            all.push((Mistake::DepthOfOne(which, scaled.factor), setup));
        }
        for change in changes.into_iter().chain(units) {
            let setup = declared.with(which, |s| s.change = change);
            all.push((Mistake::One(which, change), setup));
        }
    }
    all
}

/// Of two cameras, nothing tells which depth is a little off; other units are clear.
fn is_unit(factor: f64) -> bool {
    !(0.5..2.0).contains(&factor)
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
    if n <= MOST_PERMUTED {
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
