//! From a simulated body to what three depth cameras and a point tracker report
//! of it: half of the surface, noise that grows, tracks that drift or get lost.

use bendtwin_core::{Capture, Environment, Point, Sequence, capture::Object, geometry::IDENTITY};
use bendtwin_engine::Backend;
use bendtwin_graph::farthest_points;
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{
    MakeOptions,
    camera::Camera,
    hand::Hand,
    pose::{Pose, add, norm, scale, sub, unit},
    scene::Setup,
    simulate::{Specimen, simulate},
};
use crate::Error;

pub(super) const FPS: f64 = 30.0;
pub(super) const TRAIN_SHARE: f64 = 0.7;
/// Depth noise along the line of sight, at the start and added over 100 frames [m].
const DEPTH_NOISE_M: f32 = 0.000_8;
const NOISE_GROWTH_M: f32 = 0.000_8;
/// Random walk of every track a frame [m].
const WALK_M: f32 = 0.000_1;
/// Share of tracks that start to slide at some frame, and how fast [m a frame].
const DRIFTING: f64 = 0.06;
const DRIFT_M: f32 = 0.001_5;
/// Chance a frame that a track jumps to another spot, and how far [m].
const JUMP: f64 = 0.001;
const JUMP_M: f32 = 0.012;
/// Chance a frame that a track is lost permanently.
const LOSS: f64 = 0.001_5;
/// Noise of shape prior and hand points [m].
const PRIOR_NOISE_M: f32 = 0.001_5;
const HAND_NOISE_M: f32 = 0.000_5;
/// A motion is trusted within this of what its neighbours do [m].
const CONSISTENT_M: f32 = 0.006;
const NEIGHBOURS: usize = 8;

/// Simulates and observes.
pub(super) fn record(
    setup: &Setup,
    options: &MakeOptions,
    backend: &dyn Backend,
) -> Result<Capture, Error> {
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let body = &setup.body;
    let n = body.node_count();
    let Performance { poses, trajectory } = perform(setup, backend)?;
    let rows: Vec<&[Point]> = trajectory.chunks_exact(n.max(1)).collect();

    let cameras = cameras();
    let surface = body.surface();
    let seen: Vec<Vec<bool>> = rows
        .iter()
        .zip(&poses)
        .map(|(row, pose)| see(&cameras, &setup.hand, pose, &surface, row, &body.normals(row)))
        .collect();
    let at_start = seen.first().cloned().unwrap_or_default();
    let (mut front, mut back) = (Vec::new(), Vec::new());
    for (slot, seen) in at_start.iter().enumerate() {
        if *seen { front.push(slot) } else { back.push(slot) }
    }
    front.shuffle(&mut rng);
    front.truncate(setup.observed);
    back.shuffle(&mut rng);
    back.truncate(setup.completed);

    let tracks = Tracks { rows: &rows, surface: &surface, seen: &seen, slots: &front };
    let sequence = Sequence {
        name: "main".to_owned(),
        frame_count: rows.len(),
        train_frame_count: (rows.len() as f64 * TRAIN_SHARE).round() as usize,
        controls: hand_points(setup, &poses, &mut rng),
        truth_tracks: truth(setup, &surface, &rows),
        start_frames: 1,
        ..tracks.observe(&cameras, &mut rng)
    };
    let mut prior = |nodes: Vec<u32>| -> Vec<Point> {
        nodes.iter().map(|i| jitter(body.positions[*i as usize], PRIOR_NOISE_M, &mut rng)).collect()
    };
    let completed_surface = prior(back.iter().map(|slot| surface[*slot]).collect());
    let mut inner = body.within(|_| true);
    inner.retain(|i| !body.is_surface[*i as usize]);
    let inner = spread(&body.positions, &inner, setup.interior);
    Ok(Capture {
        name: setup.name.clone(),
        fps: FPS,
        environment: Environment::Z_UP,
        source_to_world: IDENTITY,
        object: Object {
            point_count: front.len(),
            colors: front.iter().map(|s| color(body.positions[surface[*s] as usize])).collect(),
            completed_surface,
            interior: prior(inner),
            ..Object::default()
        },
        sequences: vec![sequence],
        others: Vec::new(),
    })
}

/// Motion of hand and body.
pub(super) struct Performance {
    /// The hand's pose in each frame.
    pub(super) poses: Vec<Pose>,
    /// Positions of the body's nodes [m], shape [T, N, 3].
    pub(super) trajectory: Vec<Point>,
}

/// Moves the hand as the scene says, and the body as physics says.
pub(super) fn perform(setup: &Setup, backend: &dyn Backend) -> Result<Performance, Error> {
    let body = &setup.body;
    let poses: Vec<Pose> =
        (0..setup.frames).map(|f| (setup.motion)(f as f32 / FPS as f32)).collect();
    let hands = || [Some(&setup.hand), setup.second.as_ref()].into_iter().flatten();
    let held = body.within(|p| hands().any(|hand| hand.holds(p)));
    let path = poses.iter().flat_map(|pose| {
        held.iter().map(|h| {
            let p = body.positions[*h as usize];
            let holder = hands().find(|hand| hand.holds(p)).unwrap_or(&setup.hand);
            pose.carry(holder.grasp, p)
        })
    });
    let specimen = Specimen {
        rest: &body.positions,
        springs: &body.springs,
        material: &setup.material,
        held: &held,
        fps: FPS,
    };
    let trajectory =
        simulate(&specimen, vec![path.collect()], backend)?.into_iter().next().unwrap_or_default();
    Ok(Performance { poses, trajectory })
}

/// Three cameras around the table.
fn cameras() -> Vec<Camera> {
    let target = [0.15, 0.0, 0.2];
    let place = |degrees: f32| {
        let (s, c) = degrees.to_radians().sin_cos();
        Camera::looking_at(add(target, [0.85 * c, 0.85 * s, 0.4]), target)
    };
    [-90.0, 30.0, 150.0].map(place).to_vec()
}

fn see(
    cameras: &[Camera],
    hand: &Hand,
    pose: &Pose,
    surface: &[u32],
    positions: &[Point],
    normals: &[Point],
) -> Vec<bool> {
    let mut seen = vec![false; surface.len()];
    for camera in cameras {
        let by_camera = camera.sees(surface, positions, normals);
        for ((seen, node), in_view) in seen.iter_mut().zip(surface).zip(by_camera) {
            *seen |= in_view && !hand.hides(pose, camera.position, positions[*node as usize]);
        }
    }
    seen
}

struct Tracks<'a> {
    rows: &'a [&'a [Point]],
    /// Surface nodes, and whether each is seen in each frame.
    surface: &'a [u32],
    seen: &'a [Vec<bool>],
    /// Surface nodes that are tracked.
    slots: &'a [usize],
}

impl Tracks<'_> {
    /// Points, visibility and motion validity.
    fn observe(&self, cameras: &[Camera], rng: &mut ChaCha8Rng) -> Sequence {
        let (frames, points) = (self.rows.len(), self.slots.len());
        let mut out = Sequence {
            points: vec![[0.0; 3]; frames * points],
            visible: vec![false; frames * points],
            motion_valid: vec![false; frames * points],
            ..Sequence::default()
        };
        for (p, &slot) in self.slots.iter().enumerate() {
            let node = self.surface[slot] as usize;
            let drifts_from = rng.random_bool(DRIFTING).then(|| rng.random_range(0..frames.max(1)));
            let slide = scale(unit(normal(rng)), DRIFT_M);
            let (mut wander, mut lost) = ([0.0; 3], false);
            for frame in 0..frames {
                if frame > 0 {
                    wander = add(wander, scale(normal(rng), WALK_M));
                    lost |= rng.random_bool(LOSS);
                    if rng.random_bool(JUMP) {
                        wander = add(wander, scale(unit(normal(rng)), JUMP_M));
                    }
                }
                if drifts_from.is_some_and(|from| frame > from) {
                    wander = add(wander, slide);
                }
                let visible = self.seen[frame][slot] && !lost;
                let true_point = self.rows[frame][node];
                let sigma = DEPTH_NOISE_M + NOISE_GROWTH_M * frame as f32 / 100.0;
                // Drawn for hidden points too, so that one point's fate does not change another's
                // noise.
                let depth: f32 = StandardNormal.sample(rng);
                let camera = &cameras[p % cameras.len()];
                let ray = unit(sub(true_point, camera.position));
                let cell = frame * points + p;
                out.visible[cell] = visible;
                if visible {
                    out.points[cell] = add(add(true_point, wander), scale(ray, sigma * depth));
                }
            }
        }
        self.judge_motion(&mut out);
        out
    }

    /// Judges a motion: valid if neighbours at the start move in the same way.
    fn judge_motion(&self, out: &mut Sequence) {
        let points = self.slots.len();
        let start: Vec<Point> =
            self.slots.iter().map(|s| self.rows[0][self.surface[*s] as usize]).collect();
        let neighbours: Vec<Vec<usize>> = start
            .iter()
            .map(|p| {
                let mut near: Vec<usize> = (0..points).collect();
                near.sort_by(|a, b| norm(sub(start[*a], *p)).total_cmp(&norm(sub(start[*b], *p))));
                near.into_iter().skip(1).take(NEIGHBOURS).collect()
            })
            .collect();
        for frame in 1..self.rows.len() {
            let motion = |p: usize| {
                let (now, before) = (frame * points + p, (frame - 1) * points + p);
                let seen = out.visible[now] && out.visible[before];
                seen.then(|| sub(out.points[now], out.points[before]))
            };
            let motions: Vec<Option<Point>> = (0..points).map(motion).collect();
            for (p, own) in motions.iter().enumerate() {
                let Some(own) = own else { continue };
                let around: Vec<Point> = neighbours[p].iter().filter_map(|q| motions[*q]).collect();
                let typical: Point = std::array::from_fn(|axis| {
                    let mut along: Vec<f32> = around.iter().map(|m| m[axis]).collect();
                    along.sort_by(f32::total_cmp);
                    along.get(along.len() / 2).copied().unwrap_or(own[axis])
                });
                let allowed = CONSISTENT_M + 0.3 * norm(typical);
                out.motion_valid[frame * points + p] = norm(sub(*own, typical)) < allowed;
            }
        }
    }
}

fn hand_points(setup: &Setup, poses: &[Pose], rng: &mut ChaCha8Rng) -> Vec<Point> {
    let points = setup.hand.points(setup.controls);
    let mut out = Vec::with_capacity(points.len() * poses.len());
    for pose in poses {
        for p in &points {
            out.push(jitter(pose.carry(setup.hand.grasp, *p), HAND_NOISE_M, rng));
        }
    }
    out
}

/// Clean tracks of points spread over the surface, shape [T, K, 3].
fn truth(setup: &Setup, surface: &[u32], rows: &[&[Point]]) -> Vec<Point> {
    let nodes = spread(&setup.body.positions, surface, setup.truth);
    rows.iter().flat_map(|row| nodes.iter().map(|n| row[*n as usize])).collect()
}

/// `count` of the nodes, spread evenly.
pub(super) fn spread(positions: &[Point], nodes: &[u32], count: usize) -> Vec<u32> {
    let points: Vec<Point> = nodes.iter().map(|n| positions[*n as usize]).collect();
    let candidates: Vec<usize> = (0..points.len()).collect();
    let mut chosen = Vec::new();
    farthest_points(&points, &candidates, &mut chosen, count, 0);
    chosen.into_iter().map(|i| nodes[i]).collect()
}

fn jitter(p: Point, sigma: f32, rng: &mut ChaCha8Rng) -> Point {
    add(p, scale(normal(rng), sigma))
}

fn normal(rng: &mut ChaCha8Rng) -> Point {
    std::array::from_fn(|_| StandardNormal.sample(rng))
}

/// Stripes, so that pictures show how the body turns.
fn color(p: Point) -> Point {
    let stripe = 0.5 + 0.5 * (60.0 * p[0]).sin();
    [0.85, 0.35 + 0.4 * stripe, 0.2 + 0.3 * stripe]
}
