//! Staged recordings: shapes in closed form before a rig of cameras that measure with noise.

use std::{f64::consts::TAU, sync::Arc};

use bendtwin_capture::{
    Error, Sources,
    raw::{
        Camera, ColorImage, DepthImage, Distortion, Frames, Intrinsics, Mask, Pose, Recording,
        Region, Source, Tracks,
    },
};
use bendtwin_core::{
    Environment,
    geometry::{IDENTITY, Vector, add, cross, distance, scaled, sub, unit},
};
use bendtwin_synth::analytic::{Bodies, Hit, Precision, Primitive, View};

use super::shapes::Shape;

/// What hands do, by the time since the start [s].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// Up and aside.
    Lift,
    /// Up, a long rest, then aside.
    Pause,
    /// Up and down the same way.
    Symmetric,
    /// Two rounds in a circle.
    Circle,
    /// Fast swings to and fro.
    Swing,
    /// So far aside that a camera loses it for a while.
    Leave,
    /// Two hands that pull apart and together.
    TwoHands,
}

impl Motion {
    const ALL: [Self; 7] = [
        Self::Lift,
        Self::Pause,
        Self::Symmetric,
        Self::Circle,
        Self::Swing,
        Self::Leave,
        Self::TwoHands,
    ];

    /// Shift of the hand [m]. Swings are slower before slow cameras: at 15 frames a second the object would
    /// move by 54 mm from frame to frame, of which the tracker confirms one motion in a hundred.
    fn shift(self, t: f64, fps: f64) -> Vector {
        let step = |from: f64, to: f64| {
            let s = ((t - from) / (to - from)).clamp(0.0, 1.0);
            s * s * (3.0 - 2.0 * s)
        };
        let lifted = [0.02 * step(0.1, 0.8), 0.0, 0.12 * step(0.1, 0.8)];
        let more = match self {
            Self::Lift => [0.1 * step(0.6, 1.5), 0.06 * step(0.7, 1.6), 0.04 * step(0.5, 1.5)],
            Self::Pause => [0.0, 0.14 * step(1.5, 2.2), 0.03 * step(1.6, 2.2)],
            Self::Symmetric => {
                let s = (0.5 * TAU * t / 1.8).sin();
                return [0.0, 0.05 * s * s, 0.16 * s * s];
            }
            Self::Circle => {
                let (s, c) = (TAU * 1.1 * (t - 0.6)).sin_cos();
                let on = step(0.5, 0.9);
                [0.06 * on * s, 0.06 * on * (1.0 - c), 0.02 * on * s]
            }
            Self::Swing => {
                let rate = 1.5 * (fps / 25.0).min(1.0);
                [0.0, 0.09 * step(0.5, 0.8) * (TAU * rate * (t - 0.5)).sin(), 0.0]
            }
            // Across the view of the first camera.
            Self::Leave => {
                let s = step(0.4, 1.2) - step(1.4, 2.2);
                [0.0, 0.42 * s, 0.0]
            }
            Self::TwoHands => {
                let s = (TAU * 0.8 * (t - 0.7)).sin() * step(0.7, 1.1);
                [0.02 * s, 0.05 * s, 0.03 * s]
            }
        };
        add(lifted, more)
    }
}

/// Part of the scene that a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Body {
    Object,
    Hand,
    Table,
}

#[derive(Debug)]
struct Stage {
    shape: Shape,
    motion: Motion,
    fps: f64,
    cameras: Vec<Camera>,
    /// Frames from one of a camera to its next.
    every: Vec<usize>,
    seed: u64,
}

/// A healthy recording and its name.
pub(super) fn recording(number: usize, seed: u64) -> (String, Recording) {
    let shape = Shape::ALL[number % Shape::ALL.len()];
    let motion = Motion::ALL[number % Motion::ALL.len()];
    let fps = [30.0, 15.0, 60.0, 30.0, 25.0][number % 5];
    let count = [3, 2, 4, 3, 1][number % 5];
    let count = if motion == Motion::Leave { count.max(2) } else { count };
    let cameras: Vec<Camera> =
        (0..count).map(|camera| place(number, seed, camera, count)).collect();
    // One of several cameras may be slower than the others.
    let is_slow = |camera: usize| number % 6 == 3 && camera == 1;
    let every = (0..count).map(|camera| if is_slow(camera) { 2 } else { 1 }).collect();
    let frame_count = (2.4 * fps) as usize;
    let stage = Stage { shape, motion, fps, every, seed: 1000 + seed, cameras: cameras.clone() };
    let name = format!("staged {shape:?}, {motion:?}, {count} cameras at {fps} fps");
    let recording = Recording {
        name: name.clone(),
        fps,
        frame_count,
        train_frame_count: frame_count * 7 / 10,
        environment: Environment::Z_UP,
        source_to_world: IDENTITY,
        cameras,
        mesh: None,
        truth_tracks: Vec::new(),
        mass_kg: None,
        grippers: Vec::new(),
        notes: Vec::new(),
        sources: Sources::default(),
        source: Arc::new(stage),
    };
    (name, recording)
}

/// A camera of a rig: by their seeds, rigs are turned, and their cameras stand at different heights and distances.
fn place(number: usize, seed: u64, camera: usize, count: usize) -> Camera {
    let varied = |key: i64| 2.0 * chance(seed, [camera as i64, 0, 0, key]) - 1.0;
    let turn = 360.0 * camera as f64 / count as f64 + 53.0 * number as f64 + 18.0 * varied(1);
    let (s, c) = turn.to_radians().sin_cos();
    let out = 0.72 * (1.0 + 0.15 * varied(2));
    let eye = [out * c, out * s, 0.45 + 0.25 * varied(3)];
    let [width, height] = [[112, 84], [128, 72], [84, 112], [96, 96]][(number + camera) % 4];
    // A rope or a cable is as thick as a few pixels.
    let is_thin = matches!(Shape::ALL[number % Shape::ALL.len()], Shape::Rope | Shape::Cable);
    let [width, height] = if is_thin { [2 * width, 2 * height] } else { [width, height] };
    let into = unit(sub([0.02, 0.02, 0.1], eye)).expect("the camera is elsewhere");
    let right = unit(cross(into, [0.0, 0.0, 1.0])).expect("no camera looks straight down");
    let down = cross(into, right);
    let focal = 1.05 * (width as f64).min(1.3 * height as f64) * (1.0 + 0.1 * varied(4));
    Camera {
        name: format!("stage{camera}"),
        width,
        height,
        intrinsics: Intrinsics {
            fx: focal,
            fy: focal,
            cx: 0.5 * (width as f64 - 1.0) + varied(5),
            cy: 0.5 * (height as f64 - 1.0) + varied(6),
        },
        distortion: Distortion::None,
        poses: vec![Pose {
            rotation: std::array::from_fn(|i| [right[i], down[i], into[i]]),
            translation: eye,
        }],
        times_s: Vec::new(),
        fps: None,
    }
}

impl Stage {
    fn bodies(&self, t: f64) -> Bodies<Body> {
        let [first, second] = self.shape.grasps();
        // What a hand does reaches the rest later, and the rest hangs lower.
        let from = |grasp: Vector, mirrored: f64, p: Vector| {
            let far = distance(grasp, p);
            let [x, y, z] = self.motion.shift(t - 0.35 * far, self.fps);
            let [x, y] = self.across([x, y]);
            let sag = 1.0 - (far / 0.6).min(0.8) * (z / 0.2).clamp(0.0, 1.0);
            [mirrored * x, mirrored * y, (z * sag).max(0.0)]
        };
        let two = self.motion == Motion::TwoHands;
        let shift = |p: Vector| {
            let one = from(first, 1.0, p);
            if !two {
                return one;
            }
            let (a, b) = (distance(first, p), distance(second, p));
            let share = b / (a + b).max(1e-9);
            add(scaled(one, share), scaled(from(second, -1.0, p), 1.0 - share))
        };
        let mut bodies: Vec<(Body, Primitive)> =
            self.shape.posed(shift).into_iter().map(|shape| (Body::Object, shape)).collect();
        let hands = [(first, -1.0), (second, 1.0)];
        for (grasp, side) in hands.into_iter().take(if two { 2 } else { 1 }) {
            let palm = add(add(grasp, shift(grasp)), [0.012 * side, 0.0, 0.012]);
            let arm = [0.5 * side, 0.25 * side, 0.8];
            for i in 0..8 {
                let center = add(palm, scaled(arm, 0.025 * f64::from(i)));
                let radius_m = if i == 0 { 0.03 } else { 0.022 };
                bodies.push((Body::Hand, Primitive::Sphere { center, radius_m }));
            }
        }
        bodies.push((Body::Table, Primitive::Ground));
        Bodies(bodies)
    }

    /// Turns what goes along y so that it crosses the view of the first camera.
    fn across(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Some(eye) = self.cameras.first().map(|c| c.poses[0].translation) else { return [x, y] };
        let (s, c) = eye[1].atan2(eye[0]).sin_cos();
        [c * x - s * y, s * x + c * y]
    }
}

impl Source for Stage {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        Ok(Box::new(Reader { stage: self, camera, drawn: None }))
    }
}

struct Reader<'a> {
    stage: &'a Stage,
    camera: usize,
    /// The frame that was drawn last and its view, which colour, depth and masks share.
    drawn: Option<(usize, Arc<View<Body>>)>,
}

impl Reader<'_> {
    fn view(&mut self, frame: usize) -> Option<Arc<View<Body>>> {
        let Self { stage, camera, .. } = *self;
        if !frame.is_multiple_of(stage.every[camera]) {
            return None;
        }
        if self.drawn.as_ref().is_none_or(|(drawn, _)| *drawn != frame) {
            let bodies = stage.bodies(frame as f64 / stage.fps);
            let view = bodies.view(&stage.cameras[camera], 0, Precision::Double);
            self.drawn = Some((frame, Arc::new(view)));
        }
        self.drawn.as_ref().map(|(_, view)| view.clone())
    }

    fn chance(&self, frame: usize, [column, row]: [usize; 2], key: i64) -> f64 {
        let place = [column as i64, row as i64, (1000 * self.camera + frame) as i64, key];
        chance(self.stage.seed, place)
    }
}

impl Frames for Reader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        let view = self.view(frame);
        Ok(view.map(|view| {
            view.image(|at, hit: Option<Hit<Body>>| {
                let grain = 6.0 * self.chance(frame, at, 1);
                let (base, patch_m, contrast) = match hit.map(|h| h.body) {
                    Some(Body::Object) => ([90.0, 70.0, 60.0], 0.02, 110.0),
                    Some(Body::Hand) => ([205.0, 160.0, 130.0], 0.03, 15.0),
                    Some(Body::Table) => ([120.0, 125.0, 130.0], 0.05, 20.0),
                    None => ([225.0, 225.0, 228.0], 1.0, 0.0),
                };
                let local = hit.map_or([0.0; 3], |h| h.local);
                let cell = local.map(|x| (x / patch_m).floor() as i64);
                std::array::from_fn(|channel| {
                    let key = [cell[0], cell[1], cell[2], 10 + channel as i64];
                    let dye = contrast * chance(7, key);
                    (base[channel] + dye + grain).clamp(0.0, 255.0) as u8
                })
            })
        }))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        let view = self.view(frame);
        Ok(view.map(|view| {
            view.image(|at, hit: Option<Hit<Body>>| {
                let Some(hit) = hit.filter(|_| self.chance(frame, at, 2) > 0.03) else {
                    return 0.0;
                };
                // Beyond what a depth camera measures.
                if hit.depth_m > 4.0 {
                    return 0.0;
                }
                let noise = self.chance(frame, at, 3) + self.chance(frame, at, 4) - 1.0;
                let measured = hit.depth_m + 0.003 * noise * hit.depth_m * hit.depth_m;
                ((1000.0 * measured).round() / 1000.0) as f32
            })
        }))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        let wanted = match region {
            Region::Object => Body::Object,
            Region::Manipulator => Body::Hand,
        };
        Ok(self.view(frame).map(|view| view.mask(|body| body == wanted)))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        Ok(None)
    }
}

/// A number from 0 to 1 that depends on everything and looks random.
fn chance(seed: u64, place: [i64; 4]) -> f64 {
    let mut x = place.iter().fold(seed ^ 0x9E37_79B9_7F4A_7C15, |h, s| {
        (h ^ *s as u64).wrapping_mul(0xBF58_476D_1CE4_E5B9).rotate_left(29)
    });
    x ^= x >> 31;
    x = x.wrapping_mul(0x94D0_49BB_1331_11EB);
    (x >> 11) as f64 / (1_u64 << 53) as f64
}
