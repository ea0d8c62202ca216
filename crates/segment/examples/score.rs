//! Compares masks from clicks with the true ones, on made recordings: one click for the object and one
//! for each hand, in the first camera's first frame.
//!
//! `cargo run --release -p bendtwin-segment --example score -- FOLDER [--set tune|report] [--only NAME]`
//! films the recordings into FOLDER unless they are there, and prints a table.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use bendtwin_capture::{
    Limits,
    raw::{self, Mask, MaskSet, Recording, Region},
};
use bendtwin_core::{
    CancelToken,
    settings::ingest::{Part, Stroke},
};
use bendtwin_segment::{Segmented, segment};
use bendtwin_synth::{Dyes, FilmOptions, Hands, Scene, Shape, film};

type Failure = Box<dyn std::error::Error>;

/// Frames of a recording.
const FRAMES: usize = 60;

/// A recording to make.
struct Take {
    name: String,
    scene: Scene,
    options: FilmOptions,
}

fn main() -> Result<(), Failure> {
    let mut folder = None;
    let (mut set, mut only) = ("report".to_owned(), None);
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--set" => set = args.next().ok_or("--set needs tune or report")?,
            "--only" => only = args.next(),
            _ => folder = Some(PathBuf::from(arg)),
        }
    }
    let folder = folder.ok_or("usage: score FOLDER [--set tune|report] [--only NAME]")?;
    std::fs::create_dir_all(&folder)?;
    println!(
        "| recording | IoU of object | IoU of hand | least of a camera | doubt | s a frame | findings |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut all = Vec::new();
    for take in takes(set == "tune") {
        if only.as_ref().is_some_and(|only| !take.name.contains(only.as_str())) {
            continue;
        }
        let path = folder.join(format!("{}.zip", take.name));
        if !path.exists() {
            let made = film(take.scene, &take.options)?;
            let unfinished = path.with_extension("unfinished");
            raw::write_bundle(&made, &unfinished)?;
            std::fs::rename(&unfinished, &path)?;
        }
        all.push(score(&take, &path)?);
    }
    let least = |pick: fn(&[f64; 2]) -> f64| all.iter().map(pick).fold(f64::INFINITY, f64::min);
    let mean = |pick: fn(&[f64; 2]) -> f64| all.iter().map(pick).sum::<f64>() / all.len() as f64;
    println!("| least | {:.3} | {:.3} | | | | |", least(|s| s[0]), least(|s| s[1]));
    println!("| mean | {:.3} | {:.3} | | | | |", mean(|s| s[0]), mean(|s| s[1]));
    Ok(())
}

/// The recordings that constants are tuned on, and those that are reported: other shapes, colours,
/// rigs and seeds.
fn takes(tune: bool) -> Vec<Take> {
    let base = |seed: u64| FilmOptions {
        frames: FRAMES,
        size: [848, 480],
        tracks: false,
        shape: Shape::Absent,
        ..FilmOptions::full(seed)
    };
    let dyes = |body: [f32; 3], contrast: f32, hand: [f32; 3], table: [f32; 3]| Dyes {
        body: (body, contrast),
        hand: (hand, 0.1),
        table: (table, 0.08),
    };
    let gloved = dyes([0.75, 0.35, 0.3], 0.2, [0.2, 0.3, 0.6], [0.75, 0.72, 0.65]);
    let dark = dyes([0.3, 0.45, 0.35], 0.25, [0.8, 0.6, 0.5], [0.25, 0.22, 0.2]);
    let wood = dyes([0.55, 0.55, 0.75], 0.3, [0.75, 0.55, 0.45], [0.6, 0.45, 0.3]);
    let list: Vec<(&str, Scene, FilmOptions)> = if tune {
        vec![
            ("toy", Scene::Toy, base(1)),
            ("ring_two", Scene::Ring, FilmOptions { hands: Hands::Two, ..base(2) }),
            ("rope_joining", Scene::Rope, FilmOptions { hands: Hands::Joining, ..base(3) }),
            ("toy_wood", Scene::Toy, FilmOptions { dyes: wood, take: 1, noise: 2.0, ..base(4) }),
            ("bar_dark", Scene::Bar, FilmOptions { dyes: dark, clutter: true, ..base(5) }),
            ("ring_gloved", Scene::Ring, FilmOptions { dyes: gloved, take: 2, ..base(6) }),
        ]
    } else {
        vec![
            ("rope", Scene::Rope, base(11)),
            ("toy_other", Scene::Toy, FilmOptions { take: 2, ..base(12) }),
            ("toy_two", Scene::Toy, FilmOptions { hands: Hands::Two, dyes: gloved, ..base(13) }),
            ("rope_two", Scene::Rope, FilmOptions { hands: Hands::Two, clutter: true, ..base(14) }),
            ("thick_bar", Scene::ThickBar, FilmOptions { dyes: wood, take: 3, ..base(15) }),
            ("ring_joining", Scene::Ring, FilmOptions { hands: Hands::Joining, ..base(16) }),
            ("ring_noisy", Scene::Ring, FilmOptions { dyes: dark, noise: 2.0, ..base(17) }),
            (
                "bar_four",
                Scene::Bar,
                FilmOptions { cameras: 4, size: [640, 480], take: 2, ..base(18) },
            ),
        ]
    };
    let take = |(name, scene, options): (&str, Scene, FilmOptions)| Take {
        name: format!("{name}_{FRAMES}"),
        scene,
        options,
    };
    list.into_iter().map(take).collect()
}

fn score(take: &Take, path: &Path) -> Result<[f64; 2], Failure> {
    let recording = raw::open(path, &Limits::default())?;
    let strokes = clicks(&recording, if take.options.hands == Hands::Two { 2 } else { 1 })?;
    let empty = MaskSet::empty(&recording);
    let bare = recording.clone().with_masks(std::sync::Arc::new(empty));
    let started = Instant::now();
    let made = segment(&bare, &strokes, &mut |_| {}, &CancelToken::default())?;
    let seconds = started.elapsed().as_secs_f64() / recording.frame_count as f64;
    let mut pooled = [[0_u64; 2]; 2];
    let mut least = f64::INFINITY;
    for camera in 0..recording.cameras.len() {
        let mut frames = recording.source.frames(camera)?;
        let mut of_camera = [[0_u64; 2]; 2];
        for frame in 0..recording.frame_count {
            let mut line = Vec::new();
            for (counts, region) in of_camera.iter_mut().zip([Region::Object, Region::Manipulator])
            {
                let (Some(truth), Some(mask)) =
                    (frames.mask(frame, region)?, made.masks.mask(camera, frame, region))
                else {
                    continue;
                };
                let now = overlap(&truth, &mask);
                line.push(now[0] as f64 / now[1].max(1) as f64);
                (0..2).for_each(|k| counts[k] += now[k]);
            }
            if std::env::var_os("EACH").is_some() && frame % 6 == 0 {
                eprintln!(
                    "  camera {camera} frame {frame}: {line:.3?} doubt {:?}",
                    made.doubt[camera][frame]
                );
            }
        }
        for (all, counts) in pooled.iter_mut().zip(of_camera) {
            least = least.min(counts[0] as f64 / counts[1].max(1) as f64);
            (0..2).for_each(|k| all[k] += counts[k]);
        }
    }
    let [object, hand] = pooled.map(|[both, any]| both as f64 / any.max(1) as f64);
    let Segmented { doubt, findings, .. } = &made;
    let known: Vec<f32> = doubt.iter().flatten().flatten().copied().collect();
    let doubt = known.iter().sum::<f32>() / known.len().max(1) as f32;
    let codes: Vec<&str> = findings.iter().map(|f| f.code.as_str()).collect();
    let name = &take.name;
    println!(
        "| {name} | {object:.3} | {hand:.3} | {least:.3} | {doubt:.3} | {seconds:.2} | {} |",
        codes.join(", ")
    );
    if let Some(folder) = std::env::var_os("DRAW") {
        draw(&recording, &made, &PathBuf::from(folder).join(name))?;
    }
    Ok([object, hand])
}

/// Pixels in both masks and in any.
fn overlap(a: &Mask, b: &Mask) -> [u64; 2] {
    let both = a.pixels.iter().zip(&b.pixels);
    both.fold([0, 0], |[both, any], (a, b)| [both + u64::from(*a && *b), any + u64::from(*a || *b)])
}

/// A click in the middle of the object, and of this number of hands.
fn clicks(recording: &Recording, hands: usize) -> Result<Vec<Stroke>, Failure> {
    let mut strokes = Vec::new();
    for (part, region, count) in
        [(Part::Object, Region::Object, 1), (Part::Hand, Region::Manipulator, hands)]
    {
        // Another camera where the first does not see both hands apart.
        for camera in 0..recording.cameras.len() {
            let mask = recording.source.frames(camera)?.mask(0, region)?.ok_or("no truth")?;
            let middles = middles(&mask, count);
            if middles.len() == count {
                strokes.extend(
                    middles.iter().map(|[x, y]| Stroke::click(part, camera as u32, *x, *y)),
                );
                break;
            }
        }
    }
    Ok(strokes)
}

/// The innermost pixels of the largest parts of a mask.
fn middles(mask: &Mask, count: usize) -> Vec<[f64; 2]> {
    let (width, height) = (mask.width, mask.height);
    let mut inset = vec![0_u32; mask.pixels.len()];
    // Distance to the rim by steps, there and back.
    let near = |inset: &[u32], x: usize, y: usize, dx: isize, dy: isize| {
        let (x, y) = (x.checked_add_signed(dx), y.checked_add_signed(dy));
        match (x, y) {
            (Some(x), Some(y)) if x < width && y < height => inset[y * width + x],
            _ => 0,
        }
    };
    for back in [false, true] {
        for k in 0..inset.len() {
            let at = if back { inset.len() - 1 - k } else { k };
            if !mask.pixels[at] {
                continue;
            }
            let (x, y, s) = (at % width, at / width, if back { 1 } else { -1 });
            let beside = near(&inset, x, y, s, 0).min(near(&inset, x, y, 0, s)) + 1;
            inset[at] = if back { inset[at].min(beside) } else { beside };
        }
    }
    let mut seen = vec![false; inset.len()];
    let mut parts: Vec<(usize, usize)> = Vec::new();
    for start in 0..inset.len() {
        if !mask.pixels[start] || seen[start] {
            continue;
        }
        seen[start] = true;
        let (mut queue, mut size, mut best) = (vec![start], 0, start);
        while let Some(at) = queue.pop() {
            size += 1;
            if inset[at] > inset[best] {
                best = at;
            }
            let (x, y) = (at % width, at / width);
            for row in y.saturating_sub(2)..(y + 3).min(height) {
                for column in x.saturating_sub(2)..(x + 3).min(width) {
                    let other = row * width + column;
                    if mask.pixels[other] && !std::mem::replace(&mut seen[other], true) {
                        queue.push(other);
                    }
                }
            }
        }
        parts.push((size, best));
    }
    parts.sort_unstable_by(|a, b| b.cmp(a));
    let largest = parts.first().map_or(0, |(size, _)| *size);
    let parts = parts.into_iter().take(count).filter(|(size, _)| 10 * size > largest);
    parts.map(|(_, at)| [(at % width) as f64, (at / width) as f64]).collect()
}

/// Draws every sixth frame: object green, hand blue; missing red, too much yellow.
fn draw(recording: &Recording, made: &Segmented, folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    for camera in 0..recording.cameras.len() {
        let mut frames = recording.source.frames(camera)?;
        for frame in (0..recording.frame_count).step_by(12) {
            let Some(mut color) = frames.color(frame)? else { continue };
            let masks = [Region::Object, Region::Manipulator]
                .map(|region| (frames.mask(frame, region), made.masks.mask(camera, frame, region)));
            for ((truth, mask), tint) in masks.into_iter().zip([1, 2]) {
                let (Some(truth), Some(mask)) = (truth?, mask) else { continue };
                for (at, pixel) in color.pixels.iter_mut().enumerate() {
                    match (truth.pixels[at], mask.pixels[at]) {
                        (true, true) => pixel[tint] = pixel[tint].saturating_add(90),
                        (true, false) => *pixel = [255, 0, 0],
                        (false, true) => *pixel = [255, 255, 0],
                        (false, false) => {}
                    }
                }
            }
            std::fs::write(folder.join(format!("{camera}_{frame}.png")), color.encode()?)?;
        }
    }
    Ok(())
}
