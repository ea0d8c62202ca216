//! Standard motions of an object in the air, without the ground: what a twin is asked about, and what
//! could be recorded next.

use std::{f64::consts::TAU, sync::Arc};

use bendtwin_core::{
    Point, Twin,
    geometry::{Vector, add, cross, distance, scaled, sub, unit, wide},
};
use bendtwin_engine::{
    Model, Motion, World,
    fidelity::Reduction,
    model::State,
    world::{Attachment, Grasp, IDENTITY, Pose, Region},
};

use crate::{Regions, regions::hand_centres, response::Scene};

/// Length of a motion [s].
const SECONDS: f64 = 1.0;
/// Fewest and most frames of a motion.
const FRAMES: [usize; 2] = [20, 60];
/// Amplitude of a shake [m].
const SHAKE_M: f64 = 0.04;
/// Shakes a second, sideways and up.
const SHAKE_HZ: [f64; 2] = [2.0, 3.0];
/// Distance of a push [m].
const PUSH_M: f64 = 0.05;
/// Time in which a hand reaches its target [s].
const MOVE_S: f64 = 0.5;
/// Share of the distance between two hands by which they come nearer, and by which they pull.
const BEND: f64 = 0.3;
const PULL: f64 = 0.06;

/// The hold of the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hold {
    /// The twin's own control points.
    Own,
    /// A region, with the twin's own hands open.
    Region(usize),
}

/// The action on the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Act {
    /// The object is held still and hangs.
    Hang,
    /// The hold shakes.
    Shake,
    /// A region is moved sideways.
    Push(usize),
    /// A second hand takes this region and comes nearer.
    Bend(usize),
    /// A second hand takes this region and pulls.
    Pull(usize),
}

/// A path of a hand: its displacement at a time [s] in [m].
type Path = Box<dyn Fn(f64) -> Vector>;

/// Number of frames of a standard motion at a frame rate.
pub(crate) fn frames_at(fps: f64) -> usize {
    ((fps * SECONDS).round() as usize).clamp(FRAMES[0], FRAMES[1])
}

/// A motion of a twin as a scene. `reduction` is its fast variant.
pub(crate) fn scene(
    twin: &Twin,
    regions: &Regions,
    reduction: Option<Reduction>,
    hold: Hold,
    act: Act,
) -> Scene {
    let mut model = Model::from(twin);
    model.environment.ground = None;
    let (fps, frames) = (twin.timing.fps, frames_at(twin.timing.fps));
    let axes = Axes::of(twin, regions, hold);
    let still: fn() -> Path = || Box::new(|_| [0.0; 3]);
    let held: Path = match act {
        Act::Shake => Box::new(move |t| axes.shake(t)),
        _ => still(),
    };
    let second: Option<(usize, Path)> = match act {
        Act::Hang | Act::Shake => None,
        Act::Push(region) => Some((region, Box::new(move |t| scaled(axes.side, PUSH_M * ramp(t))))),
        Act::Bend(region) => {
            let (way, lift) = axes.way(regions, region);
            let to = add(scaled(way, -BEND), lift);
            Some((region, Box::new(move |t| scaled(to, ramp(t)))))
        }
        Act::Pull(region) => {
            let (way, _) = axes.way(regions, region);
            Some((region, Box::new(move |t| scaled(way, PULL * ramp(t)))))
        }
    };
    let controls = twin.graph.control_count();
    let time = |frame: usize| frame as f64 / fps;
    let moved = |frame: usize| {
        let by = if hold == Hold::Own { held(time(frame)) } else { [0.0; 3] };
        twin.graph.control_rest.iter().map(move |p| add(wide(*p), by).map(|x| x as f32))
    };
    let positions: Vec<Point> = (0..=frames).flat_map(moved).collect();
    let mut hands: Vec<(Grasp, bool, Option<&Path>)> = Vec::new();
    let own = Region::Controls(Arc::new((0..controls as u32).collect()));
    if let Hold::Region(region) = hold {
        if controls > 0 {
            hands.push((grasp(0, own), false, None));
        }
        let nodes = Region::Nodes(Arc::new(regions.handful(twin, region)));
        hands.push((grasp(hands.len() as u32, nodes), true, Some(&held)));
    }
    if let Some((region, path)) = &second {
        let nodes = Region::Nodes(Arc::new(regions.handful(twin, *region)));
        hands.push((grasp(hands.len() as u32, nodes), true, Some(path)));
    }
    let pose = |frame: usize, path: Option<&Path>| {
        path.map_or(IDENTITY, |path| displaced(path(time(frame))))
    };
    let motion = Motion {
        poses: (0..=frames)
            .flat_map(|f| hands.iter().map(move |h| (f, h.2)))
            .map(|(f, path)| pose(f, path))
            .collect(),
        closed: (0..frames).flat_map(|_| hands.iter().map(|h| h.1)).collect(),
        rolls: Vec::new(),
    };
    let world = World {
        bodies: hands.len(),
        grasps: hands.into_iter().map(|h| h.0).collect(),
        ..World::default()
    };
    Scene {
        model,
        reduction,
        hands: twin.hands(),
        initial: Arc::new(State::rest(&twin.graph)),
        controls: Arc::new(positions),
        frames,
        world: Arc::new(world),
        motion: Arc::new(motion),
    }
}

/// A grasp by a body that holds exactly and never releases.
fn grasp(body: u32, region: Region) -> Grasp {
    Grasp { body, region, attachment: Attachment::Pin, max_force: f32::INFINITY }
}

fn displaced([x, y, z]: Vector) -> Pose {
    let mut pose = IDENTITY;
    for (row, by) in pose.iter_mut().zip([x, y, z]) {
        row[3] = by as f32;
    }
    pose
}

/// From 0 to 1 in the time of a movement, smoothly.
fn ramp(t: f64) -> f64 {
    let x = (t / MOVE_S).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Directions in which a hold moves.
#[derive(Clone, Copy)]
struct Axes {
    /// Middle of what holds the object [m].
    hold: Vector,
    up: Vector,
    /// Level, and across the way to the object's middle.
    side: Vector,
}

impl Axes {
    fn of(twin: &Twin, regions: &Regions, hold: Hold) -> Self {
        let gravity = wide(twin.environment.gravity);
        let up = unit(scaled(gravity, -1.0)).unwrap_or([0.0, 0.0, 1.0]);
        let center = |r: usize| regions.parts.get(r).map_or([0.0; 3], |p| p.center);
        let hands = hand_centres(twin);
        let hold = match hold {
            Hold::Region(region) => center(region),
            Hold::Own => hands.first().copied().unwrap_or_else(|| center(0)),
        };
        let parts = regions.parts.len();
        let whole = (0..parts).fold([0.0; 3], |s, r| add(s, scaled(center(r), 1.0 / parts as f64)));
        let side = unit(cross(up, sub(whole, hold)))
            .or_else(|| unit(cross(up, [1.0, 0.0, 0.0])))
            .unwrap_or([0.0, 1.0, 0.0]);
        Self { hold, up, side }
    }

    fn shake(&self, t: f64) -> Vector {
        let swing = |hz: f64| SHAKE_M * (TAU * hz * t).sin() * ramp(t);
        let [sideways, up] = SHAKE_HZ;
        add(scaled(self.side, swing(sideways)), scaled(self.up, 0.5 * swing(up)))
    }

    /// The way from the hold to a region, and a lift of a tenth of it.
    fn way(&self, regions: &Regions, region: usize) -> (Vector, Vector) {
        let to = regions.parts.get(region).map_or(self.hold, |p| p.center);
        (sub(to, self.hold), scaled(self.up, 0.1 * distance(to, self.hold)))
    }
}

#[cfg(test)]
mod tests;
