//! A synthetic recording with known truth: a ball that is turned and carried by a smaller one, seen
//! by cameras around it.

use std::sync::Arc;

use bendtwin_capture::{
    Error,
    raw::{
        Camera, ColorImage, DepthImage, Distortion, Frames, Image, Intrinsics, Mask, Pose,
        Recording, Region, Source, Tracks,
    },
};
use bendtwin_core::{Environment, Point};
use nalgebra::{Rotation3, Vector3};

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
    /// True if there is a hand.
    pub(crate) hand: bool,
    /// True if the recording brings 2D tracks.
    pub(crate) tracked: bool,
    /// True if the masks show anything.
    pub(crate) masks: bool,
    /// True if the cameras move.
    pub(crate) moving: bool,
    /// Tracks of the ball that slip from frame 5 on: every n-th, by so many pixels a frame.
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
        }
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

/// The pose of a camera at a place that looks at where the ball starts.
fn look_at(eye: Vec3) -> Pose {
    let z = (Vec3::new(0.0, 0.0, 0.2) - eye).normalize();
    let x = z.cross(&Vec3::z()).normalize();
    let y = z.cross(&x);
    let rotation = std::array::from_fn(|i| [x[i], y[i], z[i]]);
    Pose { rotation, translation: [eye.x, eye.y, eye.z] }
}

#[derive(Debug)]
struct SceneSource {
    scene: TestScene,
    cameras: Vec<Camera>,
}

impl Source for SceneSource {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        Ok(Box::new(SceneReader { source: self, camera, index: camera }))
    }
}

struct SceneReader<'a> {
    source: &'a SceneSource,
    camera: usize,
    index: usize,
}

impl SceneReader<'_> {
    fn camera(&self) -> &Camera {
        &self.source.cameras[self.camera]
    }

    /// The region that a ray through a pixel hits first, and its depth.
    fn hit(&self, frame: usize, pixel: [f64; 2]) -> Option<(Region, f64)> {
        let camera = self.camera();
        let eye = Vec3::from(camera.pose(frame).translation);
        let at_1 = camera.unproject(pixel, 1.0, frame);
        let ray = Vec3::from(at_1.map(f64::from)) - eye;
        let ball = (Region::Object, place(frame, Vec3::zeros()), BALL_M);
        let hand = (Region::Manipulator, place(frame, hand_middle()), HAND_M);
        let bodies = [Some(ball), self.source.scene.hand.then_some(hand)];
        let hits = bodies.into_iter().flatten().filter_map(|(region, middle, radius)| {
            let m = middle - eye;
            let (a, b) = (ray.norm_squared(), ray.dot(&m));
            let root = b * b - a * (m.norm_squared() - radius * radius);
            (root >= 0.0).then(|| (region, (b - root.sqrt()) / a))
        });
        hits.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn image<P: Copy>(&self, frame: usize, pixel: impl Fn(Option<(Region, f64)>) -> P) -> Image<P> {
        let (w, h) = (self.camera().width, self.camera().height);
        let at = |i: usize| pixel(self.hit(frame, [(i % w) as f64, (i / w) as f64]));
        Image { width: w, height: h, pixels: (0..w * h).map(at).collect() }
    }

    /// A pattern that is fixed to the bodies.
    fn textured(&self, frame: usize) -> ColorImage {
        let (w, h) = (self.camera().width, self.camera().height);
        let origin = place(frame, Vec3::zeros());
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()].map(|a| place(frame, a) - origin);
        let pixel = |i: usize| {
            let at = [(i % w) as f64, (i / w) as f64];
            let Some((_, depth)) = self.hit(frame, at) else { return [0; 3] };
            let world = Vec3::from(self.camera().unproject(at, depth, frame).map(f64::from));
            let [x, y, z] = axes.map(|a| 300.0 * a.dot(&(world - origin)));
            let waves =
                [(x + 0.7 * y).sin() * (z - x).sin(), (y * 0.8 - z).sin(), (x * 0.6 + z).cos()];
            waves.map(|v| (128.0 + 100.0 * v) as u8)
        };
        Image { width: w, height: h, pixels: (0..w * h).map(pixel).collect() }
    }

    fn is_missing(&self, frame: usize) -> bool {
        self.source.scene.missing.contains(&(self.index, frame))
    }
}

impl Frames for SceneReader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        let image = self.image(frame, |hit| match hit {
            Some((Region::Object, _)) => [200, 100, 50],
            Some(_) => [50, 50, 50],
            None => [0; 3],
        });
        // Recordings without tracks need a texture to follow.
        let image = if self.source.scene.tracked { image } else { self.textured(frame) };
        Ok((!self.is_missing(frame)).then_some(image))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        // To the millimetre, as cameras give it; a wall 1.5 m away behind all.
        let image =
            self.image(frame, |hit| (hit.map_or(1.5, |(_, z)| z) * 1e3).round() as f32 / 1e3);
        Ok((!self.is_missing(frame)).then_some(image))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        let shown = self.source.scene.masks;
        let image = self.image(frame, |hit| shown && hit.is_some_and(|(r, _)| r == region));
        let there = region == Region::Object || self.source.scene.hand;
        Ok((there && !self.is_missing(frame)).then_some(image))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        let scene = &self.source.scene;
        if !scene.tracked {
            return Ok(None);
        }
        let ball = sphere(900).into_iter().map(|p| (Region::Object, p * BALL_M));
        let hand =
            sphere(120).into_iter().map(|p| (Region::Manipulator, hand_middle() + p * HAND_M));
        let all: Vec<(Region, Vec3)> =
            ball.chain(hand.take(if scene.hand { 120 } else { 0 })).collect();
        let mut tracks = Tracks { count: all.len(), ..Tracks::default() };
        for frame in 0..scene.frames {
            for (i, (region, p)) in all.iter().enumerate() {
                let world = place(frame, *p);
                let Some((mut pixel, z)) = self.camera().project(point(world), frame) else {
                    tracks.points.push([f32::NAN; 2]);
                    tracks.visible.push(false);
                    continue;
                };
                let hit = self.hit(frame, pixel);
                let mut visible = hit.is_some_and(|(r, d)| r == *region && (d - z).abs() < 2e-3);
                if *region == Region::Manipulator && scene.hand_hidden.contains(&frame) {
                    visible = false;
                }
                if let Some((_, speed)) =
                    scene.slipping.filter(|(n, _)| i % n == 0 && *region == Region::Object)
                {
                    pixel[0] += speed * frame.saturating_sub(4) as f64;
                }
                tracks.points.push(pixel.map(|x| x as f32));
                tracks.visible.push(visible);
            }
        }
        Ok(Some(tracks))
    }
}
