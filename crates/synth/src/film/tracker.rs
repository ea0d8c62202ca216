//! Tracks as a point tracker makes them of the film: points from the first frame's masks, followed
//! with errors.

use bendtwin_capture::raw::Tracks;
use bendtwin_core::Point;

use super::{Stage, lens::blend, props::Thing};
use crate::{
    raster::Hit,
    texture::{chance, normal},
};

/// Tracks of the object and of the hand at most.
const OBJECT: usize = 450;
const HAND: usize = 120;
/// Deviation of every position, and step of a random walk a frame [pixels].
const NOISE: f32 = 0.15;
const WALK: f32 = 0.04;
/// Share of tracks that start to slide at some frame, and how fast [pixels a frame].
const DRIFTING: f32 = 0.05;
const DRIFT: f32 = 0.4;
/// Chance a frame that a track is lost permanently, and that it is overlooked once.
const LOSS: f32 = 0.002;
const DROPOUT: f32 = 0.01;
/// Farther behind what is in its pixel a point is hidden [m].
const HIDDEN_M: f64 = 0.008;

/// A spot on a thing.
struct Spot {
    hit: Hit,
    /// Pixel of the query in the first frame, the same for every frame.
    pixel: [i64; 2],
}

pub(super) fn track(stage: &Stage, camera: usize) -> Tracks {
    let lens = &stage.cameras[camera];
    let views: Vec<_> = (0..stage.bodies.len()).filter_map(|f| stage.view(camera, f)).collect();
    let Some(first) = views.first() else { return Tracks::default() };
    let mut spots = Vec::new();
    for (thing, limit) in [(Thing::Body, OBJECT), (Thing::Hand, HAND)] {
        let shown: Vec<Spot> = (0..lens.width as i64 * lens.height as i64)
            .map(|i| [i % lens.width as i64, i / lens.width as i64])
            .filter_map(|pixel| Some(Spot { hit: first.raster.get(pixel[0], pixel[1])?, pixel }))
            .filter(|spot| stage.props.thing(spot.hit.triangle) == thing)
            .collect();
        let step = shown.len().div_ceil(limit).max(1);
        spots.extend(shown.into_iter().step_by(step));
    }

    let seed = stage.options.seed ^ (camera as u64) << 32;
    let mut tracks = Tracks { count: spots.len(), ..Tracks::default() };
    let mut wander = vec![[0.0_f32; 2]; spots.len()];
    let mut lost = vec![false; spots.len()];
    for (frame, view) in views.iter().enumerate() {
        for (number, spot) in spots.iter().enumerate() {
            let at = |kind: i64| [spot.pixel[0], spot.pixel[1], frame as i64, kind];
            let always = |kind: i64| [spot.pixel[0], spot.pixel[1], -1, kind];
            let slides_from = chance(seed, always(1)) * views.len() as f32 / DRIFTING;
            if frame > 0 {
                for (axis, w) in wander[number].iter_mut().enumerate() {
                    *w += WALK * normal(seed, at(2 + axis as i64));
                    if frame as f32 > slides_from {
                        *w += DRIFT * normal(seed, always(4 + axis as i64));
                    }
                }
                lost[number] |= chance(seed, at(6)) < LOSS;
            }
            let point: Point = blend(&spot.hit, stage.corners(spot.hit.triangle, &view.vertices));
            let Some((true_pixel, depth)) = lens.project(point, frame) else {
                tracks.points.push([0.0; 2]);
                tracks.visible.push(false);
                continue;
            };
            let pixel: [f32; 2] = std::array::from_fn(|axis| {
                true_pixel[axis] as f32
                    + wander[number][axis]
                    + NOISE * normal(seed, at(7 + axis as i64))
            });
            let [column, row] = true_pixel.map(|x| x.round() as i64);
            let in_front = view.raster.get(column, row);
            let is_seen = in_front.is_some_and(|hit| f64::from(hit.depth_m) > depth - HIDDEN_M);
            let is_reported = !lost[number] && chance(seed, at(9)) >= DROPOUT;
            tracks.points.push(pixel);
            tracks.visible.push(is_seen && is_reported);
        }
    }
    tracks
}
