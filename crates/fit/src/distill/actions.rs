//! Actions that the twin follows: its hands moved along smooth random ways of several kinds, as fast and
//! as far as hands move in the recording.

use std::f64::consts::{PI, TAU};

use bendtwin_core::{
    Capture, Environment, Point, Twin,
    geometry::{Vector, add, cross, distance, dot, length, scaled, sub, unit, wide},
};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::motion::{FRAMES, WINDOWS};

/// Frames of an action.
const LENGTH: usize = FRAMES * WINDOWS;
/// Speed of hands where no recording says it, and its bounds [m/s].
const SPEED: f64 = 0.25;
const SPEEDS: [f64; 2] = [0.05, 1.0];
/// Share of frames of the recording in which hands are slower.
const FAST: f64 = 0.9;
/// Time from knot to knot of a way [s].
const KNOT_S: f64 = 0.3;
/// Largest turn of a hand about its middle [rad].
const TURN: f64 = 0.5;
/// Share of the distance between two hands by which they leave each other, at most.
const APART: f64 = 0.15;
/// Way of a hand that shakes [s of its speed], and shakes a second.
const SHAKE_S: f64 = 0.12;
const SHAKE_HZ: f64 = 1.5;

/// Motion of all control points.
pub(super) struct Action {
    /// Positions at frame boundaries [m], shape [frames + 1, C, 3].
    pub(super) controls: Vec<Point>,
}

/// Kinds of ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Anywhere, from knot to knot.
    Wander,
    /// Up, and aside.
    Lift,
    /// Level, in one direction.
    Drag,
    /// Back and forth.
    Shake,
}

const KINDS: [Kind; 4] = [Kind::Wander, Kind::Lift, Kind::Drag, Kind::Shake];

/// The hands of a twin, and how fast they move.
pub(super) struct Hands {
    /// Control points at rest [m], shape [C, 3].
    rest: Vec<Point>,
    /// Hand of each, shape [C].
    of: Vec<u32>,
    /// Middle of each hand at rest [m].
    middles: Vec<Vector>,
    speed_m_s: f64,
    fps: f64,
    environment: Environment,
}

impl Hands {
    pub(super) fn new(twin: &Twin, capture: Option<&Capture>) -> Self {
        let rest = twin.graph.control_rest.clone();
        // Numbered without gaps: a file may number its hands as it likes.
        let mut numbers = twin.hands();
        numbers.sort_unstable();
        numbers.dedup();
        let place = |hand: &u32| numbers.binary_search(hand).unwrap_or_default() as u32;
        let of: Vec<u32> = twin.hands().iter().map(place).collect();
        let count = numbers.len();
        let middle = |hand: u32| {
            let own = || rest.iter().zip(&of).filter(|(_, of)| **of == hand).map(|(p, _)| wide(*p));
            let sum = own().fold([0.0; 3], add);
            scaled(sum, 1.0 / own().count().max(1) as f64)
        };
        let middles = (0..count as u32).map(middle).collect();
        let speed_m_s = capture.and_then(speed).unwrap_or(SPEED).clamp(SPEEDS[0], SPEEDS[1]);
        let (fps, environment) = (twin.timing.fps, twin.environment);
        Self { rest, of, middles, speed_m_s, fps, environment }
    }

    /// Actions drawn by seed; another stream has others.
    pub(super) fn actions(&self, count: usize, seed: u64, stream: u64) -> Vec<Action> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        (0..count).map(|i| self.action(KINDS[i % KINDS.len()], &mut rng)).collect()
    }

    fn action(&self, kind: Kind, rng: &mut ChaCha8Rng) -> Action {
        let common = self.way(kind, 1.0, rng);
        let least = |hand: usize| {
            let others = (0..self.middles.len()).filter(|&other| other != hand);
            others
                .map(|o| distance(self.middles[o], self.middles[hand]))
                .fold(f64::INFINITY, f64::min)
        };
        // Hands go together, and apart by a part of their distance: objects are not torn.
        let own: Vec<Option<Way>> = (0..self.middles.len())
            .map(|hand| {
                let apart_m = APART * least(hand);
                let all_m = self.speed_m_s * LENGTH as f64 / self.fps;
                apart_m.is_finite().then(|| self.way(Kind::Wander, (apart_m / all_m).min(1.0), rng))
            })
            .collect();
        let turns: Vec<(Vector, f64)> = self
            .middles
            .iter()
            .map(|_| (direction(rng), TURN * rng.random_range(-1.0..1.0)))
            .collect();
        let mut controls = Vec::with_capacity((LENGTH + 1) * self.rest.len());
        for frame in 0..=LENGTH {
            let t = frame as f64 / self.fps;
            let share = frame as f64 / LENGTH as f64;
            let mut moved: Vec<Vector> = common_and_own(&common, &own, t);
            self.keep_above(&mut moved);
            for (point, &hand) in self.rest.iter().zip(&self.of) {
                let (middle, (axis, angle)) = (self.middles[hand as usize], turns[hand as usize]);
                let arm = turned(
                    sub(wide(*point), middle),
                    axis,
                    angle * 0.5 * (1.0 - (PI * share).cos()),
                );
                let at = add(add(middle, arm), moved[hand as usize]);
                controls.push(at.map(|x| x as f32));
            }
        }
        Action { controls }
    }

    /// A way of a kind, whose knots are apart by this share of what the speed allows.
    fn way(&self, kind: Kind, share: f64, rng: &mut ChaCha8Rng) -> Way {
        let up = unit(scaled(wide(self.environment.gravity), -1.0)).unwrap_or([0.0, 0.0, 1.0]);
        let speed = share * self.speed_m_s * rng.random_range(0.3..1.0);
        let level = |v: Vector| unit(sub(v, scaled(up, dot(v, up)))).unwrap_or(v);
        let main = match kind {
            Kind::Wander | Kind::Shake => direction(rng),
            Kind::Lift => unit(add(up, scaled(level(direction(rng)), 0.4))).unwrap_or(up),
            Kind::Drag => level(direction(rng)),
        };
        let knots = (LENGTH as f64 / self.fps / KNOT_S).ceil().max(1.0) as usize;
        let mut at = [0.0; 3];
        let mut places = vec![at];
        for knot in 0..knots {
            let toward = match kind {
                Kind::Wander => direction(rng),
                // A hand goes back in the last third.
                Kind::Lift | Kind::Drag if 3 * knot >= 2 * knots => scaled(main, -1.0),
                Kind::Lift | Kind::Drag => {
                    unit(add(main, scaled(direction(rng), 0.3))).unwrap_or(main)
                }
                Kind::Shake => [0.0; 3],
            };
            at = add(at, scaled(toward, speed * KNOT_S * rng.random_range(0.4..1.0)));
            places.push(at);
        }
        let hz = SHAKE_HZ * rng.random_range(0.6..1.4);
        let swing = match kind {
            Kind::Shake => scaled(main, speed * SHAKE_S),
            _ => [0.0; 3],
        };
        Way { places, swing, hz }
    }

    /// Moves hands up that would come below the ground, deeper than they are at rest.
    fn keep_above(&self, moved: &mut [Vector]) {
        let Some(ground) = self.environment.ground else { return };
        let (normal, offset) = (wide(ground.normal), f64::from(ground.offset_m));
        for (hand, by) in moved.iter_mut().enumerate() {
            let own = self.rest.iter().zip(&self.of).filter(|(_, of)| **of as usize == hand);
            let heights = own.map(|(p, _)| dot(wide(*p), normal) - offset);
            let lowest = heights.fold(f64::INFINITY, f64::min);
            let deeper = lowest.min(0.0) - (lowest + dot(*by, normal));
            if deeper > 0.0 {
                *by = add(*by, scaled(normal, deeper));
            }
        }
    }
}

/// Displacement of each hand at a time [m].
fn common_and_own(common: &Way, own: &[Option<Way>], t: f64) -> Vec<Vector> {
    let own = own.iter().map(|way| way.as_ref().map_or([0.0; 3], |way| way.at(t)));
    own.map(|by| add(by, common.at(t))).collect()
}

/// A way: displacements at knots, smoothly joined, and a swing.
struct Way {
    /// Displacements [m], [`KNOT_S`] apart.
    places: Vec<Vector>,
    /// Amplitude [m].
    swing: Vector,
    hz: f64,
}

impl Way {
    /// Displacement at a time [m]: from knot to knot with a speed that begins and ends at zero.
    fn at(&self, t: f64) -> Vector {
        let knot = (t / KNOT_S).floor();
        let place = |i: usize| self.places[i.min(self.places.len() - 1)];
        let (from, to) = (place(knot as usize), place(knot as usize + 1));
        let x = (t / KNOT_S - knot).clamp(0.0, 1.0);
        let between = add(from, scaled(sub(to, from), x * x * (3.0 - 2.0 * x)));
        add(between, scaled(self.swing, (TAU * self.hz * t).sin()))
    }
}

/// A random direction.
fn direction(rng: &mut ChaCha8Rng) -> Vector {
    loop {
        let v: Vector = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        if (0.1..1.0).contains(&length(v))
            && let Some(v) = unit(v)
        {
            return v;
        }
    }
}

/// A vector turned about a unit axis (Rodrigues).
fn turned(v: Vector, axis: Vector, angle: f64) -> Vector {
    let (sin, cos) = angle.sin_cos();
    let along = scaled(axis, dot(axis, v) * (1.0 - cos));
    add(add(scaled(v, cos), scaled(cross(axis, v), sin)), along)
}

/// Speed of the hands of a recording [m/s]: faster than most of the time.
fn speed(capture: &Capture) -> Option<f64> {
    let mut speeds = Vec::new();
    for sequence in &capture.sequences {
        for frame in 1..sequence.frame_count {
            let rows = sequence.controls_at(frame - 1).iter().zip(sequence.controls_at(frame));
            let fastest = rows.map(|(a, b)| distance(wide(*a), wide(*b))).fold(0.0, f64::max);
            speeds.push(fastest * capture.fps);
        }
    }
    speeds.retain(|speed| speed.is_finite());
    speeds.sort_by(f64::total_cmp);
    speeds.get((FAST * speeds.len() as f64) as usize).copied()
}

#[cfg(test)]
mod tests;
