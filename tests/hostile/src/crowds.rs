//! Crowds: captures with very many points, frames or files that take few bytes, since they are alike, or that lie
//! where cells of a grid and halves of space cannot tell them apart. Nothing in them is wrong but their number:
//! reading them must take no longer than reading as many that lie as points of a body do.

use bendtwin_core::Point;

use crate::{
    Fault,
    archives::{self, Entry},
    arrays,
    samples::{self, FileMap},
};

/// Captures of any number of points.
pub struct Crowd {
    /// What crowds, and how.
    pub what: &'static str,
    /// The most of it that a capture may have, as far as the limits of readers and of archives allow.
    pub most: usize,
    /// Makes a capture with this number.
    pub make: fn(usize) -> Vec<u8>,
}

/// The crowds that readers are measured with.
pub const CROWDS: &[Crowd] = &[
    Crowd { what: "interior points of a body", most: INTERIOR, make: |n| interior(n, in_a_body) },
    Crowd {
        what: "interior points in one place",
        most: INTERIOR,
        make: |n| interior(n, one_place),
    },
    Crowd { what: "interior points on a line", most: INTERIOR, make: |n| interior(n, on_a_line) },
    Crowd {
        what: "interior points in two heaps",
        most: INTERIOR,
        make: |n| interior(n, two_heaps),
    },
    Crowd { what: "interior points at 1e30", most: INTERIOR, make: |n| interior(n, far_away) },
    Crowd { what: "interior points at denormals", most: INTERIOR, make: |n| interior(n, denormal) },
    Crowd { what: "tracked points of a body", most: TRACKED, make: |n| tracked(n, 1, in_a_body) },
    Crowd {
        what: "tracked points in one place",
        most: TRACKED,
        make: |n| tracked(n, 1, one_place),
    },
    Crowd { what: "tracked points on a line", most: TRACKED, make: |n| tracked(n, 1, on_a_line) },
    Crowd {
        what: "tracked points in two heaps",
        most: TRACKED,
        make: |n| tracked(n, 1, two_heaps),
    },
    Crowd {
        what: "points far from 10,000 control points",
        most: TRACKED,
        make: |n| tracked(n, 10_000, far_away),
    },
    Crowd { what: "frames", most: 200_000, make: frames },
    Crowd { what: "files", most: 60_000, make: files },
];

/// Captures with such crowds.
pub const IN_CAPTURES: &[Fault] = &[
    Fault { what: "a million points in one place", make: |_| interior(INTERIOR, one_place) },
    Fault { what: "tracks of many points in one place", make: |_| tracked(TRACKED, 1, one_place) },
    Fault { what: "points in two heaps", make: |_| interior(100_000, two_heaps) },
    Fault { what: "points on a line", make: |_| interior(100_000, on_a_line) },
    Fault {
        what: "points far from many control points",
        make: |_| tracked(50_000, 10_000, one_place),
    },
];

/// Most points of an interior.
const INTERIOR: usize = 1_000_000;
/// Most tracked points: an array that unpacks to more than 32 MiB has to be less alike.
const TRACKED: usize = 600_000;

fn in_a_body(i: usize) -> Point {
    // Fractions of multiples of irrational numbers are spread evenly.
    [0.754_877_7, 0.569_840_3, 0.430_159_7]
        .map(|step: f64| (0.3 * (i as f64 * step).fract()) as f32)
}

fn one_place(_: usize) -> Point {
    [0.1, 0.0, 0.02]
}

fn on_a_line(i: usize) -> Point {
    [0.1, 0.0, 3e-7 * i as f32]
}

fn two_heaps(i: usize) -> Point {
    let [x, y, z] = in_a_body(i).map(|x| 1e-3 * x);
    [if i.is_multiple_of(2) { x } else { x + 1e3 }, y, z]
}

fn far_away(i: usize) -> Point {
    [1e30, if i.is_multiple_of(2) { -1e30 } else { 1e30 }, i as f32]
}

fn denormal(i: usize) -> Point {
    in_a_body(i).map(|x| x * 1e-40)
}

/// A body of a few tracked points with `n` points inside.
fn interior(n: usize, place: fn(usize) -> Point) -> Vec<u8> {
    let mut files = samples::observation();
    // The edges of a cable leave other points out.
    files.remove("edges.npy");
    files.insert("interior.npy".to_owned(), points(&format!("({n}, 3)"), (0..n).map(place)));
    packed(&files)
}

/// A body of `n` tracked points, and control points in one place.
fn tracked(n: usize, controls: usize, place: fn(usize) -> Point) -> Vec<u8> {
    let mut files = samples::observation();
    files.retain(|name, _| name == "capture.json");
    let frames = samples::FRAMES;
    let all = (0..frames).flat_map(|_| (0..n).map(place));
    files.insert("object_points.npy".to_owned(), points(&format!("({frames}, {n}, 3)"), all));
    let held = std::iter::repeat_n([0.0; 3], frames * controls);
    let shape = format!("({frames}, {controls}, 3)");
    files.insert("control_points.npy".to_owned(), points(&shape, held));
    packed(&files)
}

/// A body of a few points over `n` frames.
fn frames(n: usize) -> Vec<u8> {
    let mut files = samples::observation();
    files.retain(|name, _| name == "capture.json");
    let point = |i: usize| [0.1 * (i % 6) as f32, 0.0, 1e-6 * (i / 6) as f32];
    let shape = format!("({n}, 6, 3)");
    files.insert("object_points.npy".to_owned(), points(&shape, (0..6 * n).map(point)));
    let held = (0..n).map(|frame| point(6 * frame));
    files.insert("control_points.npy".to_owned(), points(&format!("({n}, 1, 3)"), held));
    packed(&files)
}

/// A recording of cameras with `n` files that do not belong to it.
fn files(n: usize) -> Vec<u8> {
    let mut files = samples::raw_case();
    files.extend((0..n).map(|i| (format!("color/0/{}.txt", 1_000_000 + i), Vec::new())));
    archives::pack(&files)
}

fn points(shape: &str, of: impl Iterator<Item = Point>) -> Vec<u8> {
    let data: Vec<u8> = of.flatten().flat_map(f32::to_le_bytes).collect();
    arrays::with_data("<f4", shape, &data)
}

/// An archive in which files that are alike throughout take few bytes.
fn packed(files: &FileMap) -> Vec<u8> {
    let entries = files.iter().map(|(name, content)| Entry::deflated(name, content));
    archives::write(&entries.collect::<Vec<_>>())
}
