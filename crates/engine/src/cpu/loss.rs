//! Values and exact gradients of an objective's terms. The nearest point of a target counts as fixed
//! in the gradient, which is exact almost everywhere.

mod clearance;
mod coverage;
mod force;
mod nearest;
mod order;
mod points;
mod region;
mod strain;
mod winding;

use self::{coverage::Coverage, order::Order, points::Points, region::Region, winding::Winding};
use super::{
    arithmetic::{Node, Quad, Real, add, add_scaled, dot},
    surroundings::{
        Surroundings,
        body::Pose,
        force::{ForceSeeds, FrameForces},
    },
    system::System,
};
use crate::objective::{Objective, Term, WeightedTerm};

/// Node states at a frame and at the two before it.
#[derive(Clone, Copy)]
pub(crate) struct Moment<'a, T> {
    pub(crate) frame: usize,
    /// Shape [N].
    pub(crate) now: &'a [Node<T>],
    /// Nodes one frame and two frames earlier, if there were such frames.
    pub(crate) earlier: Option<[&'a [Node<T>]; 2]>,
    pub(crate) system: &'a System<T>,
    /// Surroundings of the object beside the ground.
    pub(crate) around: Option<&'a Surroundings<T>>,
    /// Mean forces of the frame that ends here, if they were measured.
    pub(crate) forces: Option<&'a FrameForces<T>>,
}

/// d loss / d what the terms of a frame depend on.
#[derive(Debug)]
pub(crate) struct TermBars<'a, T> {
    /// The state at the frame's end, shape [N] or longer.
    pub(crate) nodes: &'a mut [Node<T>],
    /// Rest lengths, shape [E].
    pub(crate) rest_lengths: &'a mut [T],
    /// Poses of bodies at the frame's end, shape [B].
    pub(crate) poses: &'a mut [Pose<T>],
    /// The frame's mean forces, if they are measured.
    pub(crate) forces: Option<&'a mut ForceSeeds<T>>,
}

/// The terms of an objective, found by frame.
pub(crate) struct Terms<'a> {
    terms: &'a [WeightedTerm],
    order: Vec<u32>,
}

impl<'a> Terms<'a> {
    pub(crate) fn new(objective: &'a Objective) -> Self {
        let terms = objective.terms.as_slice();
        let mut order: Vec<u32> = (0..terms.len() as u32).collect();
        order.sort_by_key(|&t| terms[t as usize].frame);
        Self { terms, order }
    }

    /// Terms at the end of a frame, in the objective's order.
    pub(crate) fn at(&self, frame: usize) -> impl Iterator<Item = &'a WeightedTerm> + '_ {
        let frame_of = |t: &u32| self.terms[*t as usize].frame;
        let first = self.order.partition_point(|t| frame_of(t) < frame);
        let count = self.order[first..].partition_point(|t| frame_of(t) <= frame);
        self.order[first..first + count].iter().map(|&t| &self.terms[t as usize])
    }

    /// True if a term depends on earlier frames.
    pub(crate) fn look_back(&self) -> bool {
        self.terms.iter().any(|t| t.term == Term::Acceleration)
    }

    /// Adds the terms of a frame to their groups.
    pub(crate) fn score<T: Real>(&self, frame: usize, moment: Moment<'_, T>, groups: &mut [f64]) {
        let points = Points::new(moment);
        for t in self.at(frame) {
            groups[t.group] += f64::from(t.weight) * value(&t.term, moment, &points);
        }
    }

    /// Adds the gradient of the terms of a frame to `bars`, as far as they depend on that frame
    /// itself.
    pub(crate) fn add_gradient<T: Real>(
        &self,
        frame: usize,
        moment: Moment<'_, T>,
        bars: &mut TermBars<'_, T>,
    ) {
        let points = Points::new(moment);
        for t in self.at(frame) {
            add_term_gradient(&t.term, f64::from(t.weight), moment, &points, bars);
        }
    }

    /// Adds d loss / d position of the terms of a later frame that look back `back` frames (1 or
    /// 2).
    pub(crate) fn add_gradient_back<T: Real>(
        &self,
        later: usize,
        back: usize,
        moment: Moment<'_, T>,
        bar: &mut [Node<T>],
    ) {
        let share = if back == 1 { -2.0 } else { 1.0 };
        for t in self.at(later).filter(|t| t.term == Term::Acceleration) {
            add_acceleration_gradient(f64::from(t.weight) * share, moment, bar);
        }
    }
}

fn mean_over(count: usize) -> f64 {
    1.0 / count.max(1) as f64
}

fn value<T: Real>(term: &Term, at: Moment<'_, T>, points: &Points<'_, T>) -> f64 {
    match term {
        Term::Chamfer { of, targets } => points.chamfer(*of, targets),
        Term::Track { of, points: which, targets, loss } => {
            points.track(*of, which, targets, *loss)
        }
        Term::Strain { limit } => strain::value(at.system, at.now, *limit),
        Term::Above { nodes, normal, offset_m } => {
            Region::Above { normal: *normal, offset_m: *offset_m }.value(nodes.as_ref(), at.now)
        }
        Term::Within { nodes, low, high } => {
            Region::Within { low: *low, high: *high }.value(nodes.as_ref(), at.now)
        }
        Term::Clearance { collider, margin_m } => {
            clearance::value(at, *collider as usize, *margin_m)
        }
        Term::Force { by, limit } => {
            at.forces.map_or(0.0, |forces| force::value(forces, *by, *limit))
        }
        Term::Order { of, points: chain, direction, gap_m } => {
            Order { direction: *direction, gap_m: *gap_m }.value(points, *of, chain)
        }
        Term::Winding { of, points: chain, origin, direction, turns } => {
            Winding::new(*origin, *direction, *turns).value(points, *of, chain)
        }
        Term::Coverage { of, targets, reach_m } => {
            Coverage { reach_m: *reach_m }.value(points, *of, targets)
        }
        Term::Acceleration => at.earlier.map_or(0.0, |[one, two]| acceleration(at.now, one, two)),
    }
}

/// Mean squared second difference of positions, one and two frames earlier.
pub(crate) fn acceleration<T: Real>(now: &[Node<T>], one: &[Node<T>], two: &[Node<T>]) -> f64 {
    let squares = (0..now.len()).map(|i| {
        let d = second_difference(now, one, two, i);
        dot(d, d).to_f64()
    });
    squares.sum::<f64>() * mean_over(now.len())
}

fn second_difference<T: Real>(
    now: &[Node<T>],
    one: &[Node<T>],
    two: &[Node<T>],
    i: usize,
) -> Quad<T> {
    add(add_scaled(now[i].x, -T::from_f64(2.0), one[i].x), two[i].x)
}

fn add_term_gradient<T: Real>(
    term: &Term,
    weight: f64,
    at: Moment<'_, T>,
    points: &Points<'_, T>,
    bars: &mut TermBars<'_, T>,
) {
    let bar = &mut *bars.nodes;
    match term {
        Term::Chamfer { of, targets } => points.add_chamfer_gradient(*of, targets, weight, bar),
        Term::Track { of, points: which, targets, loss } => {
            points.add_track_gradient(*of, which, targets, *loss, weight, bar);
        }
        Term::Acceleration => add_acceleration_gradient(weight, at, bar),
        Term::Strain { limit } => {
            strain::add_gradient(at.system, at.now, *limit, weight, bar, bars.rest_lengths);
        }
        Term::Above { nodes, normal, offset_m } => {
            let region = Region::Above { normal: *normal, offset_m: *offset_m };
            region.add_gradient(nodes.as_ref(), at.now, weight, bar);
        }
        Term::Within { nodes, low, high } => {
            let region = Region::Within { low: *low, high: *high };
            region.add_gradient(nodes.as_ref(), at.now, weight, bar);
        }
        Term::Clearance { collider, margin_m } => {
            let poses = &mut *bars.poses;
            clearance::add_gradient(at, *collider as usize, *margin_m, weight, bar, poses);
        }
        Term::Force { by, limit } => {
            if let (Some(forces), Some(seeds)) = (at.forces, &mut bars.forces) {
                force::add_gradient(forces, *by, *limit, weight, seeds);
            }
        }
        Term::Order { of, points: chain, direction, gap_m } => {
            let order = Order { direction: *direction, gap_m: *gap_m };
            order.add_gradient(points, *of, chain, weight, bar);
        }
        Term::Winding { of, points: chain, origin, direction, turns } => {
            let winding = Winding::new(*origin, *direction, *turns);
            winding.add_gradient(points, *of, chain, weight, bar);
        }
        Term::Coverage { of, targets, reach_m } => {
            Coverage { reach_m: *reach_m }.add_gradient(points, *of, targets, weight, bar);
        }
    }
}

fn add_acceleration_gradient<T: Real>(weight: f64, at: Moment<'_, T>, bar: &mut [Node<T>]) {
    let Some([one, two]) = at.earlier else { return };
    let w = T::from_f64(2.0 * weight * mean_over(at.now.len()));
    for (i, bar) in bar.iter_mut().enumerate().take(at.now.len()) {
        bar.x = add_scaled(bar.x, w, second_difference(at.now, one, two, i));
    }
}
