//! A cable between two grippers, as a motion-capture system sees it: few markers,
//! all of them, in several recordings of which some are held out.

use std::f32::consts::TAU;

use bendtwin_core::{
    Capture, Environment, Point, Sequence,
    capture::{HeldPoint, Object},
    geometry::IDENTITY,
};
use bendtwin_engine::Backend;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{
    MakeOptions,
    pose::{Pose, smoothstep},
    simulate::{Material, Specimen, simulate},
};
use crate::Error;

const FPS: f64 = 100.0;
const LENGTH_M: f32 = 0.9;
const HEIGHT_M: f32 = 0.45;
/// Simulated nodes between two markers.
const FINE: usize = 6;
/// Frames before the recording, in which the cable comes to hang.
const LEAD_IN: usize = 80;
const MARKER_NOISE_M: f32 = 0.000_2;

/// Simulates and observes.
pub(super) fn record(options: &MakeOptions, backend: &dyn Backend) -> Result<Capture, Error> {
    let (markers, train, eval) = if options.tiny { (8, 2, 1) } else { (12, 6, 2) };
    let frames = options.frames_or(150, 30);
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);

    let nodes = (markers - 1) * FINE + 1;
    let rest: Vec<Point> = (0..nodes).map(|i| rest_point(i as f32 / (nodes - 1) as f32)).collect();
    let springs: Vec<[u32; 2]> = (1..nodes as u32).map(|i| [i - 1, i]).collect();
    let spacing = LENGTH_M / (nodes - 1) as f32;
    // Flexural rigidity per unit node mass over the spacing: bends under gravity over about 0.1 m.
    let bend_stiffness = 0.12 * 0.12 / (spacing * spacing);
    let material = Material {
        stiffness: vec![60.0 * 60.0 / spacing; springs.len()],
        dashpot: vec![20.0; springs.len()],
        triplets: (2..nodes as u32).map(|i| [i - 2, i - 1, i]).collect(),
        bend_stiffness,
        bend_damping: 0.000_5 * bend_stiffness,
        drag: 0.8,
        ground_restitution: 0.2,
        ground_friction: 0.4,
    };
    // Each gripper clamps two markers and all that is between them.
    let clamped = FINE + 1;
    let held: Vec<u32> = (0..clamped).chain(nodes - clamped..nodes).map(|i| i as u32).collect();
    let ends = [rest[0], rest[nodes - 1]];
    let paths = (0..train + eval).map(|_| {
        let grippers = [Gripper::random(&mut rng), Gripper::random(&mut rng)];
        let mut path = Vec::with_capacity((LEAD_IN + frames) * held.len());
        for frame in 0..LEAD_IN + frames {
            let poses = grippers.each_ref().map(|g| g.pose(frame as f32 / FPS as f32));
            path.extend(held.iter().enumerate().map(|(i, node)| {
                let end = usize::from(i >= clamped);
                poses[end].carry(ends[end], rest[*node as usize])
            }));
        }
        path
    });
    let paths: Vec<Vec<Point>> = paths.collect();
    let specimen =
        Specimen { rest: &rest, springs: &springs, material: &material, held: &held, fps: FPS };
    let trajectories = simulate(&specimen, paths, backend)?;

    let held_markers = [0, 1, markers - 2, markers - 1];
    let sequences = trajectories.iter().enumerate().map(|(index, trajectory)| {
        let (role, number) = if index < train { ("train", index) } else { ("eval", index - train) };
        let rows = trajectory.chunks_exact(nodes).skip(LEAD_IN);
        let mut points = Vec::with_capacity(frames * markers);
        for row in rows {
            points.extend((0..markers).map(|m| {
                row[m * FINE].map(|x| {
                    let noise: f32 = StandardNormal.sample(&mut rng);
                    x + MARKER_NOISE_M * noise
                })
            }));
        }
        let cells = points.len();
        let controls =
            points.chunks_exact(markers).flat_map(|row| held_markers.map(|m| row[m])).collect();
        Sequence {
            name: format!("{role} {number}"),
            frame_count: frames,
            train_frame_count: if index < train { frames } else { 0 },
            visible: vec![true; cells],
            motion_valid: (0..cells).map(|cell| cell >= markers).collect(),
            points,
            controls,
            truth_tracks: Vec::new(),
            start_frames: 2,
        }
    });
    let sequences = sequences.collect();
    let pin = |(control, point): (usize, usize)| HeldPoint {
        point: point as u32,
        control: control as u32,
    };
    Ok(Capture {
        name: "cable".to_owned(),
        fps: FPS,
        environment: Environment::Z_UP,
        source_to_world: IDENTITY,
        object: Object {
            point_count: markers,
            edges: (1..markers as u32).map(|i| [i - 1, i]).collect(),
            rest_points: (0..markers).map(|m| rest[m * FINE]).collect(),
            pins: held_markers.into_iter().enumerate().map(pin).collect(),
            ..Object::default()
        },
        sequences,
        others: Vec::new(),
    })
}

/// The undeformed cable is not straight: an arch between the grippers with the
/// wave of a cable that was coiled. `s` runs from 0 to 1.
fn rest_point(s: f32) -> Point {
    let arc = 2.2_f32;
    let radius = LENGTH_M / arc;
    let angle = arc * (s - 0.5);
    [
        radius * angle.sin(),
        0.012 * (TAU * 1.5 * s).sin(),
        HEIGHT_M + radius * (1.0 - angle.cos()) * -0.6,
    ]
}

/// Motion of one gripper: sums of slow sines that start from rest.
struct Gripper {
    /// Amplitude, frequency [Hz] and phase [rad] along x, y, z, yaw and pitch.
    waves: [[f32; 3]; 5],
}

impl Gripper {
    fn random(rng: &mut ChaCha8Rng) -> Self {
        let amplitudes = [0.05, 0.08, 0.08, 0.4, 0.4];
        Self {
            waves: amplitudes.map(|a| {
                [
                    a * rng.random_range(0.5..1.0),
                    rng.random_range(0.3..1.1),
                    rng.random_range(0.0..TAU),
                ]
            }),
        }
    }

    fn pose(&self, t: f32) -> Pose {
        let [x, y, z, yaw, pitch] =
            self.waves.map(|[a, hz, phase]| a * (TAU * hz * t + phase).sin() * smoothstep(t / 0.7));
        Pose::new(yaw, pitch, [x, y, z])
    }
}
