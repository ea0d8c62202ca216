//! Measures the built-in tracker on a recording with clean tracks, and beside the tracks that came
//! with it.
//!
//! ```text
//! cargo run --release -p bendtwin-flow --example score_tracks -- CASE ['{"window_px": 13}']
//! ```
//!
//! A track's error in a frame: the track is lifted through that frame's measured depth.
//! Of the clean tracks the one nearest to it in the first frame is taken, if it lies within 10 mm
//! (in the last columns within 20 mm). The rigid motion of that clean track and its six nearest
//! then gives the place of the tracked point: `clean(t) + rotation · (tracked(0) -
//! clean(0))`. *Plain* errors leave the rotation out.

use std::{error::Error, path::Path, time::Instant};

use bendtwin_capture::{
    Limits,
    raw::{self, Camera, DepthImage, Recording, Region, Tracks},
};
use bendtwin_core::Point;
use bendtwin_flow::{CameraTracks, FlowSettings, track};
use nalgebra::{Matrix3, Vector3};

/// Tracks of a camera, and the region that each lies on.
type Followed = (Tracks, Vec<Region>);

/// Frames that are shown.
const EVERY: usize = 10;
/// Largest distance of a clean track in the first frame [m].
const NEAR_M: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let case = arguments.next().ok_or("give the folder or archive of a raw recording")?;
    let recording = raw::open(Path::new(&case), &Limits::default())?;
    let settings: FlowSettings = match arguments.next() {
        Some(json) => serde_json::from_str(&json)?,
        None => FlowSettings::default(),
    };
    let started = Instant::now();
    let found = track(&recording, &settings, &mut |_, _| {}, &Default::default())?;
    println!(
        "{} cameras, {} frames, tracked in {:.1} s",
        recording.cameras.len(),
        recording.frame_count,
        started.elapsed().as_secs_f64()
    );
    for camera in &found {
        let q = &camera.quality;
        println!(
            "{}\n  seeded {} + {}, texture {:.1?} and {:.1?} grey levels/px, there and back {:.3?} px, deviation {:.2?} mm",
            q.summary,
            q.object_points,
            q.manipulator_points,
            q.object_texture.unwrap_or(0.0),
            q.manipulator_texture.unwrap_or(0.0),
            q.forward_backward_px.unwrap_or(0.0),
            1e3 * q.deviation_m.unwrap_or(0.0),
        );
    }
    let truth = Truth::new(&recording);
    let tracks: Vec<_> = found.iter().map(|c| (c.tracks.clone(), c.regions.clone())).collect();
    truth.print(
        "built-in tracker, object",
        &lift(&recording, &tracks, Region::Object)?,
        &recording,
    );
    let supplied = supplied(&recording)?;
    if !supplied.is_empty() {
        let lifted = lift(&recording, &supplied, Region::Object)?;
        truth.print("supplied tracks, object", &lifted, &recording);
        let ours = lift(&recording, &tracks, Region::Manipulator)?;
        let theirs = lift(&recording, &supplied, Region::Manipulator)?;
        manipulator(&ours, &theirs, recording.frame_count);
    }
    beside(&recording, &found)
}

/// The tracks that came with the recording, each on what it lies on in the first frame.
fn supplied(recording: &Recording) -> Result<Vec<Followed>, Box<dyn Error>> {
    let mut all = Vec::new();
    for c in 0..recording.cameras.len() {
        let mut frames = recording.source.frames(c)?;
        let Some(tracks) = frames.tracks()? else { continue };
        let hand = frames.mask(0, Region::Manipulator)?;
        let on_hand = |[x, y]: [f32; 2]| {
            hand.as_ref().and_then(|m| m.get(x.round() as usize, y.round() as usize)) == Some(true)
        };
        let region = |&at| if on_hand(at) { Region::Manipulator } else { Region::Object };
        let regions = tracks.points[..tracks.count].iter().map(region).collect();
        all.push((tracks, regions));
    }
    Ok(all)
}

/// Tracks in space, shape [N][T]; `None` where unseen.
fn lift(
    recording: &Recording,
    found: &[Followed],
    region: Region,
) -> Result<Vec<Vec<Option<Point>>>, Box<dyn Error>> {
    let mut all = Vec::new();
    for (c, (camera, (tracks, regions))) in recording.cameras.iter().zip(found).enumerate() {
        let mut frames = recording.source.frames(c)?;
        let mine: Vec<usize> = (0..tracks.count).filter(|&i| regions[i] == region).collect();
        let mut lifted = vec![Vec::new(); mine.len()];
        for frame in 0..recording.frame_count {
            let depth = frames.depth(frame)?;
            for (track, &i) in lifted.iter_mut().zip(&mine) {
                let k = frame * tracks.count + i;
                let at = tracks.visible[k].then_some(tracks.points[k]);
                track.push(at.zip(depth.as_ref()).and_then(|(at, d)| point(camera, d, at, frame)));
            }
        }
        all.extend(lifted);
    }
    Ok(all)
}

/// Through depth as measured: the mean, by bilinear weights, of those of the four pixels that are
/// on the nearest one's surface.
fn point(camera: &Camera, depth: &DepthImage, [x, y]: [f32; 2], frame: usize) -> Option<Point> {
    let here = depth.get(x.round() as usize, y.round() as usize).filter(|&d| d > 0.0)?;
    let (mut sum, mut weights) = (0.0, 0.0);
    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        let (column, row) = (x.floor() + dx, y.floor() + dy);
        let weight = (1.0 - (x - column).abs()) * (1.0 - (y - row).abs());
        match depth.get(column as usize, row as usize) {
            Some(d) if d > 0.0 && (d - here).abs() < 0.02 => {
                sum += weight * d;
                weights += weight;
            }
            _ => {}
        }
    }
    let depth = if weights > 0.0 { sum / weights } else { here };
    Some(camera.unproject([f64::from(x), f64::from(y)], f64::from(depth), frame))
}

struct Truth {
    /// Shape [K][T].
    clean: Vec<Vec<Vector3<f64>>>,
    /// Each clean track and its nearest ones.
    nearest: Vec<Vec<usize>>,
}

impl Truth {
    fn new(recording: &Recording) -> Self {
        let count = recording.truth_tracks.len() / recording.frame_count;
        let clean: Vec<Vec<_>> = (0..count)
            .map(|k| {
                let of = |t: usize| vector(recording.truth_tracks[t * count + k]);
                (0..recording.frame_count).map(of).collect()
            })
            .collect();
        let nearest = (0..count)
            .map(|k| {
                let mut others: Vec<usize> = (0..count).collect();
                let far = |j: usize| (clean[j][0] - clean[k][0]).norm();
                others.sort_by(|&a, &b| far(a).total_cmp(&far(b)));
                others.truncate(7);
                others
            })
            .collect();
        Self { clean, nearest }
    }

    fn print(&self, title: &str, lifted: &[Vec<Option<Point>>], recording: &Recording) {
        println!("{title}");
        println!(
            "  frame  tracked since frame 0  within 10 mm: median   90 %  under 5 mm  plain  within 20 mm: median"
        );
        for frame in 0..recording.frame_count {
            if frame % EVERY == 0 || frame + 1 == recording.frame_count {
                self.print_frame(lifted, frame);
            }
        }
    }

    fn print_frame(&self, lifted: &[Vec<Option<Point>>], frame: usize) {
        let both: Vec<_> = lifted
            .iter()
            .filter_map(|t| t[0].zip(t[frame]))
            .map(|(a, b)| (vector(a), vector(b)))
            .collect();
        let of = |limit: f64, turning: bool| -> Vec<f64> {
            let error = |(first, now): &(_, _)| self.error_mm(first, now, frame, limit, turning);
            let mut errors: Vec<f64> = both.iter().filter_map(error).collect();
            errors.sort_by(f64::total_cmp);
            errors
        };
        let (errors, wider, plain) = (of(NEAR_M, true), of(2.0 * NEAR_M, true), of(NEAR_M, false));
        if errors.is_empty() {
            println!("  {frame:5}  {:21}  no clean track near", both.len());
            return;
        }
        let median = |sorted: &[f64]| sorted[sorted.len() / 2];
        let within = errors.iter().filter(|&&e| e < 5.0).count() as f64 / errors.len() as f64;
        println!(
            "  {frame:5}  {:21}  {:12}  {:6.2}  {:5.2}  {:8.0} %  {:5.2}  {:12}  {:6.2}",
            both.len(),
            errors.len(),
            median(&errors),
            errors[errors.len() * 9 / 10],
            100.0 * within,
            median(&plain),
            wider.len(),
            median(&wider),
        );
    }

    /// Distance of a point that was at `first` from where the nearest clean track puts it [mm];
    /// `None` if that one is farther away than `limit`, or unknown.
    fn error_mm(
        &self,
        first: &Vector3<f64>,
        now: &Vector3<f64>,
        frame: usize,
        limit: f64,
        turning: bool,
    ) -> Option<f64> {
        let (distance, k) = (0..self.clean.len())
            .map(|k| ((self.clean[k][0] - first).norm(), k))
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        let there = self.clean[k][frame];
        let offset = first - self.clean[k][0];
        let turn = if turning { self.rotation(k, frame) } else { Matrix3::identity() };
        let error = (now - there - turn * offset).norm() * 1e3;
        (distance < limit && error.is_finite()).then_some(error)
    }

    /// Rotation of the surroundings of a clean track since the first frame.
    fn rotation(&self, k: usize, frame: usize) -> Matrix3<f64> {
        let mut covariance = Matrix3::identity() * 1e-9;
        for &j in &self.nearest[k] {
            let before = self.clean[j][0] - self.clean[k][0];
            let after = self.clean[j][frame] - self.clean[k][frame];
            covariance +=
                after * before.transpose() * (-0.5 * (before.norm() / 0.03).powi(2)).exp();
        }
        let svd = covariance.svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
        let mut sign = Matrix3::identity();
        sign[(2, 2)] = (u * v_t).determinant().signum();
        u * sign * v_t
    }
}

/// Prints by how much the motion of the manipulator's points since the first frame differs from
/// that of the supplied ones nearest to them.
fn manipulator(ours: &[Vec<Option<Point>>], theirs: &[Vec<Option<Point>>], frames: usize) {
    println!("manipulator: tracked since frame 0, mm from supplied tracks: median  90 %");
    let moved = |track: &Vec<Option<Point>>, frame: usize| {
        let (first, now) = track[0].zip(track[frame])?;
        Some((vector(first), vector(now) - vector(first)))
    };
    for frame in (0..frames).step_by(EVERY) {
        let mut apart: Vec<f64> = ours
            .iter()
            .filter_map(|track| moved(track, frame))
            .filter_map(|(first, motion)| {
                let others = theirs.iter().filter_map(|other| moved(other, frame));
                others
                    .map(|(there, other)| ((there - first).norm(), (other - motion).norm() * 1e3))
                    .filter(|(far, _)| *far < NEAR_M)
                    .min_by(|a, b| a.0.total_cmp(&b.0))
            })
            .map(|(_, apart)| apart)
            .collect();
        apart.sort_by(f64::total_cmp);
        let count = ours.iter().filter(|track| moved(track, frame).is_some()).count();
        if let (Some(median), Some(ninth)) =
            (apart.get(apart.len() / 2), apart.get(apart.len() * 9 / 10))
        {
            println!("  {frame:5}  {count:21}  {median:31.2}  {ninth:5.2}");
        }
    }
}

/// Pixel differences to the supplied tracks that start within two pixels, less the difference at
/// the start.
fn beside(recording: &Recording, found: &[CameraTracks]) -> Result<(), Box<dyn Error>> {
    for (c, found) in found.iter().enumerate() {
        let Some(supplied) = recording.source.frames(c)?.tracks()? else { continue };
        print!(
            "{}: px from supplied tracks, median (pairs), supplied visible:",
            recording.cameras[c].name
        );
        for frame in (EVERY..recording.frame_count).step_by(EVERY) {
            let mut misses: Vec<f64> = (0..found.tracks.count)
                .filter_map(|i| miss(&found.tracks, &supplied, i, frame))
                .collect();
            misses.sort_by(f64::total_cmp);
            let visible = (0..supplied.count)
                .filter(|i| supplied.visible[*i] && supplied.visible[frame * supplied.count + i])
                .count();
            match misses.get(misses.len() / 2) {
                Some(m) => print!("  {frame}: {m:.2} ({}) {visible}", misses.len()),
                None => print!("  {frame}: - {visible}"),
            }
        }
        println!();
    }
    Ok(())
}

fn miss(ours: &Tracks, theirs: &Tracks, i: usize, frame: usize) -> Option<f64> {
    let seen = |t: &Tracks, i: usize, frame: usize| {
        t.visible[frame * t.count + i].then(|| t.points[frame * t.count + i])
    };
    let (first, now) = (seen(ours, i, 0)?, seen(ours, i, frame)?);
    let apart = |a: [f32; 2], b: [f32; 2]| f64::from((a[0] - b[0]).hypot(a[1] - b[1]));
    let (distance, j) = (0..theirs.count)
        .filter_map(|j| Some((apart(seen(theirs, j, 0)?, first), j)))
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let other = seen(theirs, j, frame)?;
    let start = theirs.points[j];
    let moved = |a: [f32; 2], b: [f32; 2]| [b[0] - a[0], b[1] - a[1]];
    (distance < 2.0).then(|| apart(moved(first, now), moved(start, other)))
}

fn vector(p: Point) -> Vector3<f64> {
    Vector3::from(p.map(f64::from))
}
