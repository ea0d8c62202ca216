//! Healthy captures of many kinds: rigs of one to four cameras, shapes, motions. A report of one may
//! have no warning that is not true.
//!
//! A third are staged from shapes in closed form ([`staged`]), which move as no simulation would; a
//! third are simulated and filmed, each object in four recordings; a third are tracked points, as
//! cameras and motion capture give them. Thresholds are chosen on those of [`Half::Tuning`] alone.

mod shapes;
mod staged;

use bendtwin_capture::raw::Recording;
use bendtwin_core::Capture;
use bendtwin_synth::{FilmOptions, MakeOptions, Scene, Substance, film, make};

/// Number of healthy captures.
pub const COUNT: usize = 60;

/// Where the seeds of the held half begin. Once a threshold was changed because of one of them, that half
/// shows nothing any more: it needs another number here.
const HELD_SEED: u64 = 7000;

/// Half of the healthy captures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// Thresholds may be chosen on them.
    Tuning,
    /// They show what the thresholds are worth.
    Held,
}

/// A healthy capture.
#[derive(Debug)]
pub enum Healthy {
    /// Images of cameras.
    Recording(Box<Recording>),
    /// Points.
    Points(Box<Capture>),
}

/// The half to which a capture belongs.
pub fn half(index: usize) -> Half {
    if index.is_multiple_of(2) { Half::Tuning } else { Half::Held }
}

/// A healthy capture below [`COUNT`], and its name.
pub fn healthy(index: usize) -> (String, Healthy) {
    let number = index / 3;
    let seed = match half(index) {
        Half::Tuning => number as u64,
        Half::Held => number as u64 + HELD_SEED,
    };
    match index % 3 {
        0 => {
            let (name, recording) = staged::recording(number, seed);
            (name, Healthy::Recording(Box::new(recording)))
        }
        1 => filmed(number, seed),
        _ => points(number, seed),
    }
}

const FILMED: [Scene; 5] = [Scene::Toy, Scene::Rope, Scene::Ring, Scene::Bar, Scene::ThickBar];

fn filmed(number: usize, seed: u64) -> (String, Healthy) {
    let scene = FILMED[number % FILMED.len()];
    let take = (number / FILMED.len()) as u32;
    let cameras = [3, 2, 4, 3, 2][number % 5];
    // A rope is as thick as a few pixels.
    let size = match scene {
        Scene::Rope => [212, 160],
        _ => [[112, 84], [128, 96], [112, 112], [96, 128]][number % 4],
    };
    let options = FilmOptions {
        frames: [36, 50, 44][number % 3],
        cameras,
        size,
        take,
        turn_deg: 37.0 * number as f32,
        tracks: number.is_multiple_of(2),
        material: Substance::ALL[number % 4],
        ..FilmOptions::tiny(100 + seed)
    };
    let name = format!("filmed {} {take}, {cameras} cameras", scene.name());
    let recording = film(scene, &options).expect("the scene is filmed");
    (name, Healthy::Recording(Box::new(recording)))
}

fn points(number: usize, seed: u64) -> (String, Healthy) {
    // Twelve cables, then what cameras see of bodies.
    let (scene, take) = match number.checked_sub(12) {
        None => (Scene::Cable, 0),
        Some(rest) => (FILMED[rest % FILMED.len()], rest as u32 % 4),
    };
    let options = MakeOptions {
        seed,
        take,
        frames: if scene == Scene::Cable { 80 } else { 0 },
        ..MakeOptions::tiny(0)
    };
    let capture = make(scene, &options).expect("the scene is simulated");
    (format!("points of {} {number}", scene.name()), Healthy::Points(Box::new(capture)))
}
