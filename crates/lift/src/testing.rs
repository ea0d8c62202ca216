//! A synthetic recording with known truth: a ball that is turned and carried by a smaller one, seen
//! by cameras around it.

mod reader;

use std::sync::Arc;

use bendtwin_capture::raw::{Camera, Distortion, Intrinsics, Pose, Recording, Region};
use bendtwin_core::{Environment, Point};
use bendtwin_synth::analytic::{Bodies, Primitive};
use nalgebra::{Rotation3, Vector3};

use self::reader::SceneSource;

type Vec3 = Vector3<f64>;

pub(crate) const BALL_M: f64 = 0.08;
pub(crate) const HAND_M: f64 = 0.03;
const WIDTH: usize = 180;
const HEIGHT: usize = 140;
const FOCAL_PX: f64 = 200.0;

/// The scene of a synthetic recording, and its faults.
#[derive(Clone, Debug)]
pub(crate) struct TestScene {
    pub(crate) frames: usize,
    pub(crate) cameras: usize,
    pub(crate) distortion: Distortion,
    /// Frames that a camera lacks.
    pub(crate) missing: Vec<(usize, usize)>,
    /// Frames in which no track on the hand is visible.
    pub(crate) hand_hidden: std::ops::Range<usize>,
    /// Frames in which no mask shows the hand, nor any track.
    pub(crate) hand_unmasked: std::ops::Range<usize>,
    /// True if there is a hand.
    pub(crate) hand: bool,
    /// True if the recording brings 2D tracks.
    pub(crate) tracked: bool,
    /// True if the masks show anything.
    pub(crate) masks: bool,
    /// True if the cameras move.
    pub(crate) moving: bool,
    /// Tracks of the ball that slip from frame 5 on: every n-th, by this many pixels a frame.
    pub(crate) slipping: Option<(usize, f64)>,
}

impl Default for TestScene {
    fn default() -> Self {
        Self {
            frames: 12,
            cameras: 2,
            distortion: Distortion::None,
            missing: Vec::new(),
            hand_hidden: 0..0,
            hand_unmasked: 0..0,
            hand: true,
            tracked: true,
            masks: true,
            moving: false,
            slipping: None,
        }
    }
}

impl TestScene {
    pub(crate) fn recording(self) -> Recording {
        let cameras: Vec<Camera> = (0..self.cameras).map(|c| self.camera(c)).collect();
        let truth: Vec<Vec3> = sphere(40).into_iter().map(|p| p * BALL_M).collect();
        let truth_tracks =
            (0..self.frames).flat_map(|f| truth.iter().map(move |p| point(place(f, *p)))).collect();
        Recording {
            name: "ball".to_owned(),
            fps: 30.0,
            frame_count: self.frames,
            train_frame_count: self.frames * 7 / 10,
            environment: Environment::Z_UP,
            source_to_world: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            cameras: cameras.clone(),
            mesh: None,
            truth_tracks,
            mass_kg: None,
            grippers: Vec::new(),
            notes: Vec::new(),
            sources: bendtwin_capture::Sources::default(),
            source: Arc::new(SceneSource { scene: self, cameras }),
        }
    }

    fn camera(&self, c: usize) -> Camera {
        let count = if self.moving { self.frames } else { 1 };
        let pose = |f: usize| {
            let angle = 0.3 + 2.0 * c as f64 + 0.01 * f as f64;
            look_at(Vec3::new(0.5 * angle.cos(), 0.5 * angle.sin(), 0.5))
        };
        Camera {
            name: format!("camera{c}"),
            width: WIDTH,
            height: HEIGHT,
            intrinsics: Intrinsics { fx: FOCAL_PX, fy: FOCAL_PX, cx: 89.5, cy: 69.5 },
            distortion: self.distortion,
            poses: (0..count).map(pose).collect(),
            times_s: Vec::new(),
            fps: None,
        }
    }

    fn bodies(&self, frame: usize) -> Bodies<Region> {
        let sphere = |center: Vec3, radius_m| Primitive::Sphere { center: center.into(), radius_m };
        let ball = (Region::Object, sphere(place(frame, Vec3::zeros()), BALL_M));
        let hand = (Region::Manipulator, sphere(place(frame, hand_middle()), HAND_M));
        Bodies([Some(ball), self.hand.then_some(hand)].into_iter().flatten().collect())
    }
}

/// The place of a point of the ball's or hand's body in a frame: everything turns and moves as one.
pub(crate) fn place(frame: usize, p: Vec3) -> Vec3 {
    let f = frame as f64;
    let turn = Rotation3::from_axis_angle(&Vec3::z_axis(), 0.02 * f);
    turn * p + Vec3::new(0.002 * f, -0.001 * f, 0.2 + 0.003 * f)
}

/// Middle of the hand's ball on the body.
pub(crate) fn hand_middle() -> Vec3 {
    Vec3::new(0.0, 0.0, BALL_M + 0.8 * HAND_M)
}

/// Evenly spread unit vectors.
pub(crate) fn sphere(count: usize) -> Vec<Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / count as f64;
            let (r, a) = ((1.0 - z * z).sqrt(), golden * i as f64);
            Vec3::new(r * a.cos(), r * a.sin(), z)
        })
        .collect()
}

pub(crate) fn point(v: Vec3) -> Point {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// The pose of a camera at a place, directed at the start of the ball.
fn look_at(eye: Vec3) -> Pose {
    let z = (Vec3::new(0.0, 0.0, 0.2) - eye).normalize();
    let x = z.cross(&Vec3::z()).normalize();
    let y = z.cross(&x);
    let rotation = std::array::from_fn(|i| [x[i], y[i], z[i]]);
    Pose { rotation, translation: [eye.x, eye.y, eye.z] }
}
