//! A textured square that moves in front of cameras, of which it is known exactly where each of its
//! points appears.

use std::sync::Arc;

use bendtwin_capture::{
    Error,
    raw::{
        Camera, ColorImage, DepthImage, Distortion, Frames, Image, Intrinsics, Mask, Pose,
        Recording, Region, Source, Tracks,
    },
};
use bendtwin_core::{
    Environment,
    geometry::{add, scaled, turn},
};
use bendtwin_synth::analytic::{Bodies, Hit, Precision, Primitive, Ray};
use nalgebra::{Rotation3, Vector3};

pub(crate) const WIDTH: usize = 120;
pub(crate) const HEIGHT: usize = 100;
const FOCAL: f64 = 150.0;
/// Half the square's side [m].
const HALF: f64 = 0.09;
/// Radius of the ball [m].
const BALL_M: f64 = 0.03;
/// Depth of the hand that covers columns [m].
const HAND_M: f64 = 0.3;

/// The scene and its recording.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) frames: usize,
    /// Translation of the square per frame [m]; it starts half a metre in front of the first
    /// camera.
    pub(crate) velocity: [f64; 3],
    /// Rotation of the square per frame, axis times angle.
    pub(crate) spin: [f64; 3],
    /// Contrast of the texture, 0 to 1.
    pub(crate) contrast: f64,
    /// Gain and offset of brightness in the last frame; it changes evenly.
    pub(crate) light: [f64; 2],
    /// Columns that a hand in front covers in each frame.
    pub(crate) hand: fn(usize) -> std::ops::Range<usize>,
    /// A plain ball in front, as a second manipulator: its centre in the first frame, and its
    /// motion per frame [m].
    pub(crate) ball: Option<[[f64; 3]; 2]>,
    /// Amplitude of a pattern of 8 x 8 pixels that lies over the hand and the ball and stays where
    /// it is in the image, as what JPEG leaves of a plain surface does [grey levels of 255].
    pub(crate) blocks: f64,
    /// Frames that are missing.
    pub(crate) missing: Vec<usize>,
    /// Places of further cameras, relative to the first one [m].
    pub(crate) others: Vec<[f64; 3]>,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            frames: 8,
            velocity: [0.0; 3],
            spin: [0.0; 3],
            contrast: 1.0,
            light: [1.0, 0.0],
            hand: |_| 0..0,
            ball: None,
            blocks: 0.0,
            missing: Vec::new(),
            others: Vec::new(),
        }
    }
}

impl Scene {
    pub(crate) fn recording(&self) -> Recording {
        let places = [[0.0; 3]].into_iter().chain(self.others.iter().copied());
        let cameras = places.enumerate().map(|(i, at)| camera(i, at)).collect();
        Recording {
            name: "square".to_owned(),
            fps: 30.0,
            frame_count: self.frames,
            train_frame_count: self.frames,
            environment: Environment::Z_UP,
            source_to_world: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            cameras,
            mesh: None,
            truth_tracks: Vec::new(),
            mass_kg: None,
            grippers: Vec::new(),
            notes: Vec::new(),
            sources: bendtwin_capture::Sources::default(),
            source: Arc::new(self.clone()),
        }
    }

    /// The pixel at which the point that a camera sees at a pixel of the first frame appears later.
    pub(crate) fn moved(&self, camera: &Camera, at: [f64; 2], frame: usize) -> [f64; 2] {
        let square = self.square(0);
        let ray = ray(camera, at);
        let [x, y, _] = square.local(ray.at(square.depth_m(&ray).unwrap()));
        let (rotation, center) = self.place(frame);
        let p = add(turn(&rotation, [x, y, 0.0]), center);
        camera.project(p.map(|v| v as f32), 0).unwrap().0
    }

    /// Rotation and centre of the square.
    fn place(&self, frame: usize) -> ([[f64; 3]; 3], [f64; 3]) {
        let t = frame as f64;
        let rotation = Rotation3::new(Vector3::from(self.spin) * t);
        let rows = std::array::from_fn(|i| std::array::from_fn(|j| rotation[(i, j)]));
        (rows, add([0.0, 0.0, 0.5], scaled(self.velocity, t)))
    }

    fn square(&self, frame: usize) -> Primitive {
        let (rotation, center) = self.place(frame);
        Primitive::Rectangle { center, rotation, half_sides_m: [HALF; 2] }
    }

    fn ball(&self, frame: usize) -> Option<Primitive> {
        let [first, velocity] = self.ball?;
        let center = add(first, scaled(velocity, frame as f64));
        Some(Primitive::Sphere { center, radius_m: BALL_M })
    }

    /// Depth of the ball at a pixel.
    pub(crate) fn hit_ball(&self, camera: &Camera, at: [f64; 2], frame: usize) -> Option<f64> {
        self.ball(frame)?.depth_m(&ray(camera, at))
    }

    fn bodies(&self, frame: usize) -> Bodies<Region> {
        let ball = self.ball(frame).map(|ball| (Region::Manipulator, ball));
        Bodies(ball.into_iter().chain([(Region::Object, self.square(frame))]).collect())
    }

    fn color_at(&self, [x, y]: [f64; 2], frame: usize) -> [u8; 3] {
        let share = frame as f64 / (self.frames.max(2) - 1) as f64;
        let gain = 1.0 + (self.light[0] - 1.0) * share;
        [0.0, 1.0, 2.0].map(|c| {
            // Waves of 24, 21 and 13 pixels at half a metre.
            let wave = (75.0 * x + 20.0 * y + 2.1 * c).sin()
                + (80.0 * y - 40.0 * x + 1.7 * c).sin()
                + (110.0 * x + 90.0 * y + 3.0 * c).sin();
            let v = gain * (0.5 + 0.14 * self.contrast * wave) + self.light[1] * share;
            (255.0 * v).round().clamp(0.0, 255.0) as u8
        })
    }
}

impl Scene {
    fn hand_color(&self, [column, row]: [usize; 2]) -> [u8; 3] {
        // Each block has separate cosines, with the phases that JPEG's have.
        let wave =
            |at: usize, k: usize| ((at % 8) as f64 + 0.5) * k as f64 * std::f64::consts::PI / 8.0;
        let block = column / 8 * 3 + row / 8 * 5;
        let [across, down] = [block % 4, block / 4 % 4];
        let pattern = wave(column, across).cos() * wave(row, down).cos();
        [200.0, 150.0, 120.0].map(|plain| (plain + self.blocks * pattern).round() as u8)
    }
}

impl Source for Scene {
    fn frames(&self, camera_idx: usize) -> Result<Box<dyn Frames + '_>, Error> {
        let camera = self.recording().cameras[camera_idx].clone();
        Ok(Box::new(Reader { scene: self, camera }))
    }
}

struct Reader<'a> {
    scene: &'a Scene,
    camera: Camera,
}

impl Reader<'_> {
    fn draw<P: Copy>(
        &self,
        frame: usize,
        background: P,
        hand: impl Fn([usize; 2], f64) -> P,
        square: impl Fn([f64; 2], f64) -> P,
    ) -> Option<Image<P>> {
        if self.scene.missing.contains(&frame) {
            return None;
        }
        let covered = (self.scene.hand)(frame);
        let view = self.scene.bodies(frame).view(&self.camera, 0, Precision::Single);
        Some(view.image(|pixel, hit| match hit {
            _ if covered.contains(&pixel[0]) => hand(pixel, HAND_M),
            Some(Hit { body: Region::Object, depth_m, local: [x, y, _] }) => {
                square([x, y], depth_m)
            }
            Some(ball) => hand(pixel, ball.depth_m),
            None => background,
        }))
    }
}

impl Frames for Reader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        let hand = |pixel, _| self.scene.hand_color(pixel);
        Ok(self.draw(frame, [250; 3], hand, |on, _| self.scene.color_at(on, frame)))
    }
    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        Ok(self.draw(frame, 0.0, |_, depth| depth as f32, |_, depth| depth as f32))
    }
    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        let object = region == Region::Object;
        Ok(self.draw(frame, false, |_, _| !object, |_, _| object))
    }
    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        Ok(None)
    }
}

fn ray(camera: &Camera, at: [f64; 2]) -> Ray {
    Ray::through(camera, at, 0, Precision::Single)
}

fn camera(number: usize, translation: [f64; 3]) -> Camera {
    Camera {
        name: format!("camera {number}"),
        width: WIDTH,
        height: HEIGHT,
        intrinsics: Intrinsics {
            fx: FOCAL,
            fy: FOCAL,
            cx: (WIDTH / 2) as f64,
            cy: (HEIGHT / 2) as f64,
        },
        distortion: Distortion::None,
        poses: vec![Pose {
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            translation,
        }],
        times_s: Vec::new(),
        fps: None,
    }
}
