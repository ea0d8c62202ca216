//! Films a made scene: a raw recording as cameras, a segmenter and a point tracker would give it,
//! with the truth beside it.
//!
//! Body, hand and table are triangles with colours that stick to them. Images are computed when
//! they are requested, and each is always the same.

mod lens;
mod props;
mod tracker;

use std::sync::Arc;

use bendtwin_capture as capture;
use bendtwin_capture::raw::{
    Alignment, Camera, Distortion, Frames, Intrinsics, MeshFile, Recording, Source,
};
use bendtwin_core::{Environment, Point, geometry::IDENTITY};
use bendtwin_engine::Backend;
use bendtwin_mesh::{Mesh, Similarity, write_glb};

use self::{lens::Reader, props::Prop};
use super::{
    MakeOptions, Scene, Substance,
    hand::Hand,
    observe::{FPS, Performance, TRAIN_SHARE, perform, spread},
    pose::{Pose, add, scale, smoothstep, sub, unit},
    scene,
    sheet::Sheet,
    skin::Skin,
    take,
    texture::normal,
};
use crate::Error;

/// Options of filming a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmOptions {
    /// Seed of noise and lost tracks; the same seed gives the same recording.
    pub seed: u64,
    /// Frames, 4 to 1000; 0 takes the scene's own length.
    pub frames: usize,
    /// A coarse simulation, short if [`FilmOptions::frames`] is 0.
    pub tiny: bool,
    /// Cameras around the table, 1 to 8.
    pub cameras: usize,
    /// Columns and rows of an image.
    pub size: [usize; 2],
    /// `true` if a point tracker ran.
    pub tracks: bool,
    /// Recording of the object, as [`MakeOptions::take`] counts them.
    pub take: u32,
    /// Material of the body.
    pub material: Substance,
    /// Angle by which all cameras are turned around the table [degrees].
    pub turn_deg: f32,
    /// Mesh of the body that lies beside the recording.
    pub shape: Shape,
    /// A printed sheet on the table, a board for calibrating say, in the middle of what the cameras see.
    pub sheet: Option<Sheet>,
    /// Hands in the scene.
    pub hands: Hands,
    /// Colours of things.
    pub dyes: Dyes,
    /// `true` if a block stands on the table that has nothing to do with the scene.
    pub clutter: bool,
    /// Factor of the depth's noise.
    pub noise: f32,
}

/// Hands in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hands {
    /// The one that holds the body.
    One,
    /// A second one that holds the body elsewhere and moves with the first.
    Two,
    /// A second one that comes from outside while the body is moved, and touches it.
    Joining,
}

/// Colours of things: red, green and blue of each, 0..=1, and how much their patches differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dyes {
    /// The body.
    pub body: ([f32; 3], f32),
    /// Hands and forearms.
    pub hand: ([f32; 3], f32),
    /// The table.
    pub table: ([f32; 3], f32),
}

impl Default for Dyes {
    fn default() -> Self {
        Self {
            body: ([0.62, 0.42, 0.3], 0.42),
            hand: ([0.85, 0.62, 0.5], 0.12),
            table: ([0.5, 0.53, 0.56], 0.07),
        }
    }
}

/// The mesh that lies beside a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// No such images.
    Absent,
    /// The body in frame 0, in the world.
    Aligned,
    /// The body in another pose and unit, as a completion network gives it.
    Unaligned,
}

impl FilmOptions {
    /// Three cameras of 424 x 240 pixels and the scene at its full length.
    pub fn full(seed: u64) -> Self {
        Self {
            seed,
            frames: 0,
            tiny: false,
            cameras: 3,
            size: [424, 240],
            tracks: true,
            take: 0,
            material: Substance::Foam,
            turn_deg: 0.0,
            shape: Shape::Aligned,
            sheet: None,
            hands: Hands::One,
            dyes: Dyes::default(),
            clutter: false,
            noise: 1.0,
        }
    }

    /// Two cameras of 96 x 64 pixels and a few frames, for fast tests.
    pub fn tiny(seed: u64) -> Self {
        Self { tiny: true, cameras: 2, size: [96, 64], ..Self::full(seed) }
    }
}

/// Simulates and films a scene on the CPU.
///
/// # Errors
/// If the scene is not for cameras or the simulation fails.
pub fn film(scene: Scene, options: &FilmOptions) -> Result<Recording, Error> {
    film_with(scene, options, bendtwin_engine::cpu().as_ref())
}

/// Simulates a scene on a given backend and films it.
///
/// # Errors
/// If the scene is not for cameras or the simulation fails.
pub fn film_with(
    scene: Scene,
    options: &FilmOptions,
    backend: &dyn Backend,
) -> Result<Recording, Error> {
    let make = MakeOptions {
        seed: options.seed,
        frames: options.frames,
        tiny: options.tiny,
        take: options.take,
        material: options.material,
    };
    let mut setup = scene::setup(scene, &make).ok_or(Error::NotFilmed(scene.name()))?;
    take::vary(&mut setup, scene, options.take);
    let second = (options.hands != Hands::One).then(|| setup.other_hand(scene));
    if options.hands == Hands::Two {
        setup.second = second.clone();
    }
    let Performance { poses, trajectory } = perform(&setup, backend)?;
    let skin = Skin::of(&setup.body, setup.distance);
    let n = setup.body.node_count().max(1);
    let bodies: Vec<Vec<Point>> = trajectory.chunks_exact(n).map(|row| skin.posed(row)).collect();

    let vertices: Vec<u32> = (0..skin.rest.len() as u32).collect();
    let tracked = spread(&skin.rest, &vertices, setup.truth);
    let truth_tracks =
        bodies.iter().flat_map(|body| tracked.iter().map(|v| body[*v as usize])).collect();
    let frame_count = bodies.len();
    let cameras = around(options, frame_count);
    let mesh = shape(options.shape, &skin, bodies.first());
    let body = Prop { rest: skin.rest, triangles: skin.triangles };
    let actors = actors(options.hands, setup.hand.clone(), second, &poses, |hand| {
        let held = setup.body.within(|p| hand.holds(p));
        trajectory.chunks_exact(n).map(|row| mean(held.iter().map(|i| row[*i as usize]))).collect()
    });
    let stage = Stage {
        props: props::assemble(body, &actors, options.clutter),
        bodies,
        actors,
        cameras: cameras.clone(),
        options: options.clone(),
    };
    Ok(Recording {
        name: setup.name,
        fps: FPS,
        frame_count,
        train_frame_count: (frame_count as f64 * TRAIN_SHARE).round() as usize,
        environment: Environment::Z_UP,
        source_to_world: IDENTITY,
        cameras,
        mesh,
        truth_tracks,
        mass_kg: None,
        grippers: Vec::new(),
        notes: Vec::new(),
        sources: bendtwin_capture::Sources::default(),
        source: Arc::new(stage),
    })
}

/// Bodies in front of the cameras, and their motion.
#[derive(Debug)]
struct Stage {
    props: props::Props,
    /// Vertices of the body in each frame.
    bodies: Vec<Vec<Point>>,
    actors: Vec<Actor>,
    cameras: Vec<Camera>,
    options: FilmOptions,
}

/// A hand and its motion.
#[derive(Clone, Debug)]
struct Actor {
    hand: Hand,
    /// Pose in each frame, about its grasp.
    poses: Vec<Pose>,
}

/// Distance from which a joining hand comes [m], and when it begins to come and arrives, as shares of
/// the recording.
const COMES_FROM_M: f32 = 0.35;
const COMES: [f32; 2] = [0.2, 0.55];

/// The hands with their motions; `places` gives the place of a hand's grasp on the body in each frame.
fn actors(
    hands: Hands,
    first: Hand,
    second: Option<Hand>,
    poses: &[Pose],
    places: impl Fn(&Hand) -> Vec<Point>,
) -> Vec<Actor> {
    let mut actors = vec![Actor { hand: first, poses: poses.to_vec() }];
    if let Some(hand) = second {
        let poses = match hands {
            Hands::Joining => {
                let places = places(&hand);
                let [comes, arrives] = COMES.map(|share| share * places.len() as f32);
                let pose = |(frame, place): (usize, &Point)| {
                    let near = smoothstep((frame as f32 - comes) / (arrives - comes).max(1.0));
                    let away = scale(unit(hand.forearm), COMES_FROM_M * (1.0 - near));
                    Pose::new(0.0, 0.0, sub(add(*place, away), hand.grasp))
                };
                places.iter().enumerate().map(pose).collect()
            }
            _ => poses.to_vec(),
        };
        actors.push(Actor { hand, poses });
    }
    actors
}

/// Mean of points; the origin if there are none.
fn mean(points: impl Iterator<Item = Point>) -> Point {
    let (sum, count) = points.fold(([0.0; 3], 0), |(sum, n), p| (add(sum, p), n + 1));
    scale(sum, 1.0 / (count.max(1) as f32))
}

impl Source for Stage {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, capture::Error> {
        if camera >= self.cameras.len() {
            return Err(capture::Error::NoCamera(camera));
        }
        Ok(Box::new(Reader::new(self, camera)))
    }
}

/// Point that cameras look at [m].
const TARGET: Point = [0.15, 0.0, 0.2];
/// Offset of each camera from its even place: azimuth [degrees], distance as a share, height [m].
/// Real rigs are not symmetric, and in a symmetric one, exchanged calibrations would go unnoticed.
const OFFSETS: [[f32; 3]; 8] = [
    [0.0, 1.0, 0.0],
    [14.0, 0.92, 0.13],
    [-11.0, 1.06, -0.1],
    [6.0, 0.97, 0.05],
    [-8.0, 1.02, 0.1],
    [9.0, 0.95, -0.06],
    [-13.0, 1.04, 0.02],
    [4.0, 0.9, 0.08],
];

/// Cameras around the table, nearly evenly.
fn around(options: &FilmOptions, frame_count: usize) -> Vec<Camera> {
    let [width, height] = options.size.map(|n| n.clamp(16, 4096));
    // A wider view where the image is taller than usual, so that the scene always fits.
    let focal = 1.2 * (width as f64).min(height as f64 * 1.6);
    let describe = |(index, place): (usize, super::camera::Camera)| {
        let time = |frame: usize| {
            let jitter = normal(options.seed, [index as i64, frame as i64, 0, 9]);
            (frame as f64 + 0.01 * f64::from(jitter)) / FPS
        };
        Camera {
            name: format!("made{index}"),
            width,
            height,
            intrinsics: Intrinsics {
                fx: focal,
                fy: focal,
                cx: (width as f64 - 1.0) / 2.0,
                cy: (height as f64 - 1.0) / 2.0,
            },
            distortion: Distortion::None,
            poses: vec![place.pose()],
            times_s: (0..frame_count).map(time).collect(),
            fps: None,
        }
    };
    let count = options.cameras.clamp(1, OFFSETS.len());
    let places = OFFSETS.iter().take(count).enumerate().map(|(index, [turn, far, above])| {
        let degrees = 360.0 * index as f32 / count as f32 - 90.0 + turn + options.turn_deg;
        let (s, c) = degrees.to_radians().sin_cos();
        let [x, y, z] = TARGET;
        let out = 0.85 * far;
        super::camera::Camera::looking_at([x + out * c, y + out * s, z + 0.4 + above], TARGET)
    });
    places.enumerate().map(describe).collect()
}

/// The body in frame 0 as a file.
fn shape(shape: Shape, skin: &Skin, body: Option<&Vec<Point>>) -> Option<MeshFile> {
    let mesh = Mesh { vertices: body?.clone(), triangles: skin.triangles.clone() };
    let (mesh, to_world) = match shape {
        Shape::Absent => return None,
        Shape::Aligned => {
            (mesh, Some(Alignment { rotation: IDENTITY, scale: 1.0, translation: [0.0; 3] }))
        }
        Shape::Unaligned => {
            // Lying on another side, in another unit.
            let moved = Similarity {
                rotation: [[0.0, 0.0, -1.0], [0.8, 0.6, 0.0], [0.6, -0.8, 0.0]],
                scale: 4.2,
                translation: [0.3, 0.1, -0.2],
            };
            (mesh.moved(&moved), None)
        }
    };
    Some(MeshFile { name: "mesh.glb".to_owned(), bytes: write_glb(&mesh), to_world })
}

#[cfg(test)]
mod tests;
