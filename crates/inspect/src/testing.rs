//! A small recording that is computed, not stored: a textured ellipsoid that a ball carries over a
//! floor, seen by three cameras with a little noise. Tests change it in one way each.

mod footage;
mod reader;

use std::sync::Arc;

use bendtwin_capture::raw::{Camera, Distortion, Intrinsics, Pose, Recording};
use bendtwin_core::Environment;
use bendtwin_synth::analytic::{Bodies, Primitive};

use self::footage::HEALTHY;
use crate::vector::{Vector, add, cross, length, sub, to_world, turn, unit};

pub(crate) const WIDTH: usize = 160;
pub(crate) const HEIGHT: usize = 120;
pub(crate) const FRAMES: usize = 36;
const AXES: Vector = [0.10, 0.07, 0.05];
const BALL_M: f64 = 0.035;

/// The filmed scene and the faults of its recording.
#[derive(Clone, Debug)]
pub(crate) struct TestScene {
    /// The cameras with their true poses.
    pub(crate) cameras: Vec<Camera>,
    /// The moment [frames] that a camera shows in a frame; `None`: it was dropped. Shape
    /// [camera][T].
    pub(crate) moments: Vec<Vec<Option<f64>>>,
    /// Factor that each camera's depth is multiplied by.
    pub(crate) depth_factor: Vec<f32>,
    /// Cameras whose masks are exchanged.
    pub(crate) exchanged_masks: Vec<usize>,
    /// Camera and frame of empty object masks.
    pub(crate) empty_masks: Vec<(usize, usize)>,
    /// Camera and frame of files that cannot be decoded.
    pub(crate) damaged: Vec<(usize, usize)>,
    /// Share of the pixels that have no depth.
    pub(crate) holes: f64,
    /// Travel of the object as a share of its default.
    pub(crate) travel: f64,
    /// True if nobody masked the ball.
    pub(crate) hidden_hand: bool,
    /// Distance between ball and object [m].
    pub(crate) standoff_m: f64,
    /// `None`: no tracks; true: tracks as row and column.
    pub(crate) tracks: Option<bool>,
}

/// A recording without any fault.
pub(crate) fn healthy() -> (TestScene, Recording) {
    let scene = healthy_scene();
    let recording = Recording {
        name: "ellipsoid".to_owned(),
        fps: 30.0,
        frame_count: FRAMES,
        train_frame_count: 25,
        environment: Environment::Z_UP,
        source_to_world: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        cameras: cameras(),
        mesh: None,
        truth_tracks: Vec::new(),
        mass_kg: None,
        grippers: Vec::new(),
        notes: Vec::new(),
        sources: bendtwin_capture::Sources::default(),
        source: HEALTHY.clone(),
    };
    (scene, recording)
}

/// The scene without any fault.
fn healthy_scene() -> TestScene {
    TestScene {
        moments: vec![(0..FRAMES).map(|f| Some(f as f64)).collect(); 3],
        cameras: cameras(),
        depth_factor: vec![1.0; 3],
        exchanged_masks: Vec::new(),
        empty_masks: Vec::new(),
        damaged: Vec::new(),
        holes: 0.02,
        travel: 1.0,
        hidden_hand: false,
        standoff_m: 0.0,
        tracks: Some(false),
    }
}

fn cameras() -> Vec<Camera> {
    let azimuths_deg = [30.0, 145.0, 260.0];
    azimuths_deg.iter().enumerate().map(|(i, at)| camera(&format!("cam{i}"), *at)).collect()
}

/// The recording of a scene, with cameras as `recording` declares them.
pub(crate) fn filmed(scene: TestScene, mut recording: Recording) -> Recording {
    recording.source = Arc::new(scene);
    recording
}

fn camera(name: &str, azimuth_deg: f64) -> Camera {
    let azimuth = azimuth_deg.to_radians();
    let eye = [0.62 * azimuth.cos(), 0.62 * azimuth.sin(), 0.5];
    let into = unit(sub([0.05, 0.02, 0.1], eye)).unwrap();
    let right = unit(cross(into, [0.0, 0.0, 1.0])).unwrap();
    let down = cross(into, right);
    Camera {
        name: name.to_owned(),
        width: WIDTH,
        height: HEIGHT,
        intrinsics: Intrinsics { fx: 150.0, fy: 150.0, cx: 79.5, cy: 59.5 },
        distortion: Distortion::None,
        poses: vec![Pose {
            rotation: std::array::from_fn(|i| [right[i], down[i], into[i]]),
            translation: eye,
        }],
        times_s: Vec::new(),
        fps: None,
    }
}

/// Bodies of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Body {
    Object,
    Ball,
    Floor,
}

impl TestScene {
    /// Middle of the object and its yaw at a moment.
    fn object(&self, moment: f64) -> (Vector, [[f64; 3]; 3]) {
        let s = ((moment - 3.0) / 24.0).clamp(0.0, 1.0);
        let s = self.travel * (s * s * (3.0 - 2.0 * s));
        let (sin, cos) = (0.5 * s).sin_cos();
        let turned = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
        ([0.15 * s, 0.06 * s, AXES[2] + 0.1 * s], turned)
    }

    /// The bodies as they lie at a moment.
    fn bodies(&self, moment: f64) -> Bodies<Body> {
        let (center, rotation) = self.object(moment);
        let above = add(center, [0.0, 0.0, AXES[2] + 0.6 * BALL_M + self.standoff_m]);
        Bodies(vec![
            (Body::Object, Primitive::Ellipsoid { center, rotation, half_axes_m: AXES }),
            (Body::Ball, Primitive::Sphere { center: above, radius_m: BALL_M }),
            (Body::Floor, Primitive::Ground),
        ])
    }
}

/// A pose turned about the world's vertical through the camera and shifted.
pub(crate) fn disturbed(pose: &Pose, degrees: f64, shift: Vector) -> Pose {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let turn_z = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
    let columns: [Vector; 3] =
        std::array::from_fn(|j| turn(&turn_z, pose.rotation.map(|row| row[j])));
    Pose {
        rotation: std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i])),
        translation: add(pose.translation, shift),
    }
}

#[test]
fn the_cameras_look_at_the_object() {
    let (scene, recording) = healthy();
    for camera in &recording.cameras {
        let ahead = to_world(&camera.poses[0], [0.0, 0.0, 0.7]);
        assert!(length(sub(ahead, scene.object(18.0).0)) < 0.12, "{ahead:?}");
    }
}
