//! A small recording that is computed, not stored: a textured ellipsoid that a ball carries over a
//! floor, seen by three cameras with a little noise. Tests change it in one way each.

use std::sync::{Arc, LazyLock};

use bendtwin_capture::{
    Error,
    raw::{
        Camera, ColorImage, DepthImage, Distortion, Frames, Intrinsics, Mask, Pose, Recording,
        Region, Source, Tracks,
    },
};
use bendtwin_core::Environment;

use crate::vector::{Vector, add, cross, dot, length, scaled, seen_at, sub, to_world, turn, unit};

pub(crate) const WIDTH: usize = 160;
pub(crate) const HEIGHT: usize = 120;
pub(crate) const FRAMES: usize = 36;
const AXES: Vector = [0.10, 0.07, 0.05];
const BALL_M: f64 = 0.035;
const NOISE_M: f64 = 0.001;

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
        standoff_m: 0.0,
        tracks: Some(false),
    }
}

fn cameras() -> Vec<Camera> {
    let azimuths_deg = [30.0, 145.0, 260.0];
    azimuths_deg.iter().enumerate().map(|(i, at)| camera(&format!("cam{i}"), *at)).collect()
}

/// The images of the scene without any fault, rendered once for all tests.
static HEALTHY: LazyLock<Arc<Footage>> = LazyLock::new(|| {
    let scene = healthy_scene();
    let film = |camera| {
        let mut frames = scene.frames(camera).unwrap();
        let images = |frame| Images {
            color: frames.color(frame).unwrap().unwrap(),
            depth: frames.depth(frame).unwrap().unwrap(),
            object: frames.mask(frame, Region::Object).unwrap().unwrap(),
            manipulator: frames.mask(frame, Region::Manipulator).unwrap().unwrap(),
        };
        let images = (0..FRAMES).map(images).collect();
        (images, frames.tracks().unwrap())
    };
    Arc::new(Footage((0..3).map(film).collect()))
});

/// Rendered images and tracks of each camera.
#[derive(Debug)]
struct Footage(Vec<(Vec<Images>, Option<Tracks>)>);

/// The images of one frame.
#[derive(Debug)]
struct Images {
    color: ColorImage,
    depth: DepthImage,
    object: Mask,
    manipulator: Mask,
}

impl Source for Footage {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        let (images, tracks) = &self.0[camera];
        Ok(Box::new(FootageReader { images, tracks }))
    }
}

struct FootageReader<'a> {
    images: &'a [Images],
    tracks: &'a Option<Tracks>,
}

impl Frames for FootageReader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        Ok(self.images.get(frame).map(|i| i.color.clone()))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        Ok(self.images.get(frame).map(|i| i.depth.clone()))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        Ok(self.images.get(frame).map(|i| match region {
            Region::Object => i.object.clone(),
            Region::Manipulator => i.manipulator.clone(),
        }))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        Ok(self.tracks.clone())
    }
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
    }
}

#[derive(Clone, Copy, PartialEq)]
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
    fn bodies(&self, moment: f64) -> Bodies {
        let (middle, turned) = self.object(moment);
        let ball = add(middle, [0.0, 0.0, AXES[2] + 0.6 * BALL_M + self.standoff_m]);
        Bodies { middle, turned, ball }
    }
}

/// Places of the bodies at one moment.
struct Bodies {
    /// Middle of the object.
    middle: Vector,
    /// Rotation of the object.
    turned: [[f64; 3]; 3],
    /// Middle of the ball.
    ball: Vector,
}

impl Bodies {
    /// The first thing on a ray, its depth along it in units of the direction, and the place on the
    /// thing.
    fn hit(&self, eye: Vector, ray: Vector) -> Option<(Body, f64, Vector)> {
        let Self { middle, turned, ball } = *self;
        let into = |v: Vector| -> Vector {
            let v = crate::vector::turn_back(&turned, v);
            std::array::from_fn(|a| v[a] / AXES[a])
        };
        let object = sphere(into(sub(eye, middle)), into(ray), 1.0);
        let ball = sphere(sub(eye, ball), ray, BALL_M);
        let floor = (ray[2] < -1e-9).then(|| -eye[2] / ray[2]);
        let all = [(Body::Object, object), (Body::Ball, ball), (Body::Floor, floor)];
        let (thing, t) = all
            .into_iter()
            .filter_map(|(thing, t)| Some((thing, t?)))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        let at = add(eye, scaled(ray, t));
        let local = if thing == Body::Object { into(sub(at, middle)) } else { at };
        Some((thing, t, local))
    }
}

fn sphere(eye: Vector, ray: Vector, radius: f64) -> Option<f64> {
    let (a, b, c) = (dot(ray, ray), dot(eye, ray), dot(eye, eye) - radius * radius);
    let root = b * b - a * c;
    (root > 0.0).then(|| (-b - root.sqrt()) / a).filter(|t| *t > 0.0)
}

/// A number from 0 to 1 that depends on everything and looks random.
fn pseudo_random(seed: [usize; 4]) -> f64 {
    let mut x = seed.iter().fold(0x9E37_79B9_7F4A_7C15_u64, |h, s| {
        (h ^ *s as u64).wrapping_mul(0xBF58_476D_1CE4_E5B9).rotate_left(29)
    });
    x ^= x >> 31;
    x = x.wrapping_mul(0x94D0_49BB_1331_11EB);
    (x >> 11) as f64 / (1_u64 << 53) as f64
}

impl Source for TestScene {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        Ok(Box::new(SceneReader { scene: self, camera, rendered: None }))
    }
}

type Hit = Option<(Body, f64, Vector)>;

struct SceneReader<'a> {
    scene: &'a TestScene,
    camera: usize,
    /// The frame that was rendered last: colour, depth and masks show the same.
    rendered: Option<(usize, Vec<Hit>)>,
}

impl SceneReader<'_> {
    fn moment(&self, frame: usize) -> Option<f64> {
        *self.scene.moments[self.camera].get(frame)?
    }

    fn image<P>(
        &mut self,
        frame: usize,
        pixel: impl Fn(Hit, usize, usize) -> P,
    ) -> Option<bendtwin_capture::raw::Image<P>> {
        let moment = self.moment(frame)?;
        if self.rendered.as_ref().is_none_or(|(f, _)| *f != frame) {
            let camera = &self.scene.cameras[self.camera];
            let pose = &camera.poses[0];
            let bodies = self.scene.bodies(moment);
            let hit = |at: usize| {
                let pixel = [(at % WIDTH) as f64, (at / WIDTH) as f64];
                let ray = turn(&pose.rotation, seen_at(camera, pixel, 1.0));
                bodies.hit(pose.translation, ray)
            };
            self.rendered = Some((frame, (0..WIDTH * HEIGHT).map(hit).collect()));
        }
        let (_, hits) = self.rendered.as_ref()?;
        let pixels = hits.iter().enumerate().map(|(at, hit)| pixel(*hit, at % WIDTH, at / WIDTH));
        Some(bendtwin_capture::raw::Image {
            width: WIDTH,
            height: HEIGHT,
            pixels: pixels.collect(),
        })
    }

    /// Noise belongs to the moment: a frame that is shown twice is the same twice.
    fn seed(&self, frame: usize) -> usize {
        self.moment(frame).map_or(0, |m| m.to_bits() as usize)
    }
}

impl Frames for SceneReader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        if self.scene.damaged.contains(&(self.camera, frame)) {
            let at = format!("color/{}/{frame}.png", self.camera);
            return Err(Error::Damaged { at, fault: "it ends early".to_owned() });
        }
        let (seed, camera) = (self.seed(frame), self.camera);
        Ok(self.image(frame, |hit, column, row| {
            let grain = (8.0 * pseudo_random([seed, camera, column, row])) as u8;
            match hit {
                Some((Body::Object, _, at)) => {
                    let cell = at.map(|x| (5.0 * (x + 2.0)) as usize);
                    let shade = |k| {
                        40 + (180.0 * pseudo_random([cell[0], cell[1], cell[2], k])) as u8 + grain
                    };
                    [shade(1), shade(2), shade(3)]
                }
                Some((Body::Ball, ..)) => [210, 160, 130 + grain],
                Some((Body::Floor, ..)) => [120 + grain, 124, 128],
                None => [235, 235, 230 + grain],
            }
        }))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        let (seed, scene, camera) = (self.seed(frame), self.scene, self.camera);
        Ok(self.image(frame, |hit, column, row| {
            if pseudo_random([seed, camera, column, 7000 + row]) < scene.holes {
                return 0.0;
            }
            let noise =
                NOISE_M * (2.0 * pseudo_random([seed, 50 + camera, column, row]) - 1.0) * 2.0;
            // The ray has depth 1, so its parameter is the depth.
            hit.map_or(0.0, |(_, t, _)| (t + noise) as f32 * scene.depth_factor[camera])
        }))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        let exchanged = self.scene.exchanged_masks.contains(&self.camera);
        let wanted = match (region, exchanged) {
            (Region::Object, false) | (Region::Manipulator, true) => Body::Object,
            _ => Body::Ball,
        };
        let empty =
            region == Region::Object && self.scene.empty_masks.contains(&(self.camera, frame));
        Ok(self.image(frame, |hit, _, _| !empty && hit.is_some_and(|(thing, ..)| thing == wanted)))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        let Some(transposed) = self.scene.tracks else { return Ok(None) };
        let camera = &self.scene.cameras[self.camera];
        let pose = &camera.poses[0];
        let start = self.scene.bodies(0.0);
        let mut spots = Vec::new();
        for row in (0..HEIGHT).step_by(3) {
            for column in (0..WIDTH).step_by(3) {
                let ray = turn(&pose.rotation, seen_at(camera, [column as f64, row as f64], 1.0));
                if let Some((Body::Object, _, local)) = start.hit(pose.translation, ray) {
                    spots.push(local);
                }
            }
        }
        let mut tracks = Tracks { count: spots.len(), ..Tracks::default() };
        for frame in 0..FRAMES {
            let moment = self.moment(frame).unwrap_or(frame as f64);
            let bodies = self.scene.bodies(moment);
            for spot in &spots {
                let at = add(
                    bodies.middle,
                    turn(&bodies.turned, std::array::from_fn(|a| spot[a] * AXES[a])),
                );
                let behind = ([-1.0; 2], -1.0);
                let (pixel, depth) = camera.project(at.map(|x| x as f32), 0).unwrap_or(behind);
                let ray = turn(&pose.rotation, seen_at(camera, pixel, 1.0));
                let hit = bodies.hit(pose.translation, ray);
                let seen = hit
                    .is_some_and(|(thing, t, _)| thing == Body::Object && (t - depth).abs() < 0.01);
                let [x, y] = pixel.map(|p| p as f32);
                tracks.points.push(if transposed { [y, x] } else { [x, y] });
                tracks.visible.push(seen);
            }
        }
        Ok(Some(tracks))
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
