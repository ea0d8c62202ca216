//! Clamps of rods while hands open and close: which part of each rod is twisted, what stays of its
//! twist, and how fast the clamps turn about it.
//!
//! A hand that holds an edge of a rod gives it the direction d along the rod in the hand's own
//! coordinates, d = (b - a) / |b - a| with the places of its two nodes. From a frame's beginning
//! to its end the hand turns by `B = Rᵀ R'` in its own coordinates, while parallel transport turns what
//! belongs to d by the smallest rotation that brings d along. The rest is the clamp's roll. In
//! quaternions it is twice the angle between w and v . d, with B's parts w and v: as 4 w v is the
//! axial vector of B and 4 w² its trace and one,
//!
//! ```text
//! roll = 2 atan(sum over rows k of d . (R'_k x R_k) / (1 + sum over k of R_k . R'_k))
//! ```
//!
//! which is that of the hand's rotation, along any path, up to half a turn a frame.

use super::{
    Around, Surroundings,
    body::{BodyFrame, BodyFrameAdjoint},
    grasp::{AroundAdjoint, Hands, Hold},
};
use crate::cpu::{
    arithmetic::{Quad, Real, add, add_scaled, dot, scale, sub},
    elements::{Holder, RodGradient, Span},
    system::System,
};

/// Least 1 + trace of a hand's rotation in a frame; below it the hand has no roll.
const MIN_TURN: f64 = 1e-3;
/// Distance of two places that give a direction [m].
const MIN_EDGE_M: f64 = 1e-9;

/// Hold of a rod's twist in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldRod<T> {
    pub(crate) span: Span,
    /// Share of the twist beyond the rest that the frame begins with.
    pub(crate) kept: T,
}

fn cross<T: Real>(a: Quad<T>, b: Quad<T>) -> Quad<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], T::ZERO]
}

/// A row of a rotation.
fn row<T: Real>(row: Quad<T>) -> Quad<T> {
    [row[0], row[1], row[2], T::ZERO]
}

/// The turn of a hand about an edge that it holds, in a frame.
struct Roll<T> {
    /// Unit vector along the edge, and the edge's length [m].
    along: Quad<T>,
    length: T,
    /// Axial vector of the hand's turn, and 1 + trace.
    axial: Quad<T>,
    turn: T,
    /// tan(roll / 2).
    tangent: T,
}

impl<T: Real> Roll<T> {
    /// About the edge between two places; none where it has no direction.
    fn new(body: &BodyFrame<T>, places: [Quad<T>; 2]) -> Option<Self> {
        let edge = sub(places[1], places[0]);
        let length = dot(edge, edge).sqrt();
        let (mut axial, mut turn) = ([T::ZERO; 4], T::ONE);
        for k in 0..3 {
            let (from, to) = (row(body.from[k]), row(body.to[k]));
            axial = add(axial, cross(to, from));
            turn += dot(from, to);
        }
        let is_known = length.to_f64() > MIN_EDGE_M && turn.to_f64() > MIN_TURN;
        is_known.then(|| {
            let along = scale(edge, T::ONE / length);
            Self { along, length, axial, turn, tangent: dot(along, axial) / turn }
        })
    }

    /// [rad]
    fn angle(&self) -> T {
        T::from_f64(2.0 * self.tangent.to_f64().atan())
    }

    /// Adds d loss / d poses and gives that by the second place, minus that by the first.
    fn back(&self, body: &BodyFrame<T>, bar: T, to: &mut BodyFrameAdjoint<T>) -> Quad<T> {
        let square = T::ONE + self.tangent * self.tangent;
        let by_axial = (bar + bar) / (square * self.turn);
        let by_turn = -(by_axial * self.tangent);
        for k in 0..3 {
            let (from, then) = (row(body.from[k]), row(body.to[k]));
            let by_from = add_scaled(scale(cross(self.along, then), by_axial), by_turn, then);
            let by_to = add_scaled(scale(cross(from, self.along), by_axial), by_turn, from);
            to.from[k] = add(to.from[k], by_from);
            to.to[k] = add(to.to[k], by_to);
        }
        let by_along = scale(self.axial, by_axial);
        let across = add_scaled(by_along, -dot(self.along, by_along), self.along);
        scale(across, T::ONE / self.length)
    }
}

/// The part of a hold by which a hand clamps an edge of a rod.
struct Grip<'a, T> {
    hand: usize,
    holds: [&'a Hold<T>; 2],
}

impl<T: Real> Hands<T> {
    fn hold_of(&self, node: u32) -> Option<&Hold<T>> {
        let at = self.holds.binary_search_by_key(&(node as usize), |h| h.node).ok()?;
        Some(&self.holds[at])
    }

    /// Holder of each held node; `open` has an entry for every control point.
    fn spans(&self, open: &[bool], system: &System<T>) -> Vec<Span> {
        let mut pinned = vec![false; system.nodes];
        system.pins.iter().filter(|p| !open[p.control]).for_each(|p| pinned[p.node] = true);
        system.rods.spans(|node| {
            if pinned[node as usize] {
                return Some(Holder::Controls);
            }
            self.hold_of(node).map(|hold| Holder::Hand(hold.grasp))
        })
    }

    /// The edge of a rod in the hand that holds it.
    fn grip(
        &self,
        system: &System<T>,
        rod: usize,
        edge: usize,
        holder: Option<Holder>,
    ) -> Option<Grip<'_, T>> {
        let Some(Holder::Hand(hand)) = holder else { return None };
        let [a, b] = system.rods.edge(rod, edge).map(|node| self.hold_of(node));
        Some(Grip { hand, holds: [a?, b?] })
    }
}

impl<T: Real> Around<T> {
    /// Spans of rods between what holds them now; empty without hands.
    pub(crate) fn spans(&self, of: &Surroundings<T>, system: &System<T>) -> Vec<Span> {
        if of.hands.is_empty() || system.rods.rods.is_empty() {
            return Vec::new();
        }
        let open = self.hands.open_controls(&of.hands, system.controls);
        self.hands.spans(&open, system)
    }

    /// Once hands have opened and closed: takes from the twists what lay outside the clamps that
    /// hold now. `before` are the spans until then.
    pub(crate) fn hold_rods(
        &mut self,
        of: &Surroundings<T>,
        before: &[Span],
        system: &System<T>,
        twists: &mut [T],
    ) {
        self.rods = self
            .spans(of, system)
            .into_iter()
            .zip(before)
            .enumerate()
            .map(|(r, (span, before))| HeldRod { span, kept: system.rods.kept(r, before, &span) })
            .collect();
        for ((held, rod), twist) in self.rods.iter().zip(&system.rods.rods).zip(twists) {
            if held.kept != T::ONE {
                *twist = rod.rest_twist + held.kept * (*twist - rod.rest_twist);
            }
        }
    }

    /// Rates at which clamps turn the rods of a frame, 0-based [rad/s]; empty if none does.
    pub(crate) fn roll_rates_in(
        &self,
        of: &Surroundings<T>,
        frame: usize,
        system: &System<T>,
    ) -> Vec<T> {
        let rate = T::from_f64(1.0 / system.frame_s);
        let rods = system.rods.rods.len();
        let row = |f: usize| of.rolls.get(2 * f * rods..2 * (f + 1) * rods);
        let prescribed = row(frame).zip(row(frame + 1));
        let by_controls = |end: usize| prescribed.map_or(T::ZERO, |(a, b)| b[end] - a[end]);
        let has_grip = |held: &HeldRod<T>| {
            [held.span.near, held.span.far].iter().any(|h| matches!(h, Some(Holder::Hand(_))))
        };
        if prescribed.is_none() && !self.rods.iter().any(has_grip) {
            return Vec::new();
        }
        let roll = |r: usize, edge: usize, end: usize, holder: Option<Holder>| match holder {
            None => T::ZERO,
            Some(Holder::Controls) => by_controls(2 * r + end),
            Some(Holder::Hand(_)) => {
                let grip = self.hands.grip(system, r, edge, holder);
                let roll = grip.and_then(|grip| self.roll(of, &grip));
                roll.map_or(T::ZERO, |roll| roll.angle())
            }
        };
        let of_rod = |r: usize| match self.rods.get(r).map(|held| held.span) {
            None => by_controls(2 * r) - by_controls(2 * r + 1),
            Some(s) => roll(r, s.first, 0, s.near) - roll(r, s.end, 1, s.far),
        };
        (0..rods).map(|r| of_rod(r) * rate).collect()
    }

    fn roll(&self, of: &Surroundings<T>, grip: &Grip<'_, T>) -> Option<Roll<T>> {
        let body = &self.bodies[of.hands[grip.hand].body];
        Roll::new(body, grip.holds.map(|hold| hold.place))
    }
}

impl<T: Real> AroundAdjoint<T> {
    /// Adjoint of [`Around::roll_rates_in`]: from the sums for the rates in the frame.
    pub(crate) fn roll_rates(
        &mut self,
        of: &Surroundings<T>,
        around: &Around<T>,
        system: &System<T>,
    ) {
        let rate = T::from_f64(1.0 / system.frame_s);
        for r in 0..self.roll_rates.len() {
            let bar = self.roll_rates[r] * rate;
            let Some(Span { first, end, near, far }) = around.rods.get(r).map(|held| held.span)
            else {
                [self.rolls[2 * r], self.rolls[2 * r + 1]] = [bar, -bar];
                continue;
            };
            for (side, edge, holder, bar) in [(0, first, near, bar), (1, end, far, -bar)] {
                if holder == Some(Holder::Controls) {
                    self.rolls[2 * r + side] = bar;
                }
                let Some(grip) = around.hands.grip(system, r, edge, holder) else { continue };
                let Some(roll) = around.roll(of, &grip) else { continue };
                let b = of.hands[grip.hand].body;
                let by_edge = roll.back(&around.bodies[b], bar, &mut self.bodies[b]);
                let [from, to] = grip.holds.map(|hold| hold.node);
                self.places[to] = add(self.places[to], by_edge);
                self.places[from] = sub(self.places[from], by_edge);
            }
        }
    }
}

/// Adjoint of [`Around::hold_rods`].
pub(crate) fn hold_rods_adjoint<T: Real>(
    around: &Around<T>,
    twist_bar: &mut [T],
    rods: &mut [RodGradient<T>],
) {
    for ((held, bar), rod) in around.rods.iter().zip(twist_bar).zip(rods) {
        rod.rest_twist += (T::ONE - held.kept) * *bar;
        *bar = held.kept * *bar;
    }
}
