//! A tracking step: all tracks from their cameras' last views into a new frame.

use bendtwin_capture::raw::Region;
use bendtwin_core::Point;
use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::{
    FlowSettings,
    appearance::{Appearance, PosedView},
    matching::follow::{FlowMatch, follow},
    motion::{Motion, distance},
    multi_view::{CrossChecks, contradicts},
    track::Track,
};

/// The update of a track in a frame.
#[derive(Clone, Debug)]
pub(crate) enum TrackUpdate {
    /// The camera has no such frame.
    Unknown,
    /// Not found, or not accepted.
    Hidden {
        /// Expected place by the motion of the neighbours, if that is known.
        at: Option<[f64; 2]>,
    },
    /// Found.
    Seen(Box<Sighting>),
}

/// The place at which a track was found.
#[derive(Clone, Debug)]
pub(crate) struct Sighting {
    pub(crate) at: [f64; 2],
    pub(crate) point: Point,
    /// Rotation of its surroundings since seeding.
    pub(crate) rotation: Matrix3<f64>,
    /// Present appearance, if the known ones no longer match.
    pub(crate) renewed: Option<Appearance>,
    /// Distance to its start after tracking there and back [px], if it was followed from the frame
    /// before.
    pub(crate) forward_backward_px: Option<f64>,
    /// Distance to where its neighbours put it [m], if they do.
    pub(crate) deviation_m: Option<f64>,
}

/// Least distance from the outline of its region at which a point is accepted [px].
const MIN_INSET_PX: u8 = 2;

impl Track {
    /// Takes over a sighting.
    pub(crate) fn apply(&mut self, sighting: Sighting) {
        self.velocity = if self.seen {
            [0, 1, 2].map(|i| f64::from(sighting.point[i] - self.point[i]))
        } else {
            [0.0; 3]
        };
        self.seen = true;
        self.at = sighting.at;
        self.point = sighting.point;
        self.rotation = sighting.rotation;
        if sighting.renewed.is_some() {
            self.recent = sighting.renewed;
        }
    }
}

/// Follows all tracks from their cameras' last views into the views of a new frame.
pub(crate) fn follow_all(
    tracks: &[Track],
    before: &[Option<PosedView<'_>>],
    now: &[Option<PosedView<'_>>],
    cross_checks: &CrossChecks,
    settings: &FlowSettings,
) -> Vec<TrackUpdate> {
    let jump = settings.depth_jump_m as f32;
    let step = Step { tracks, before, now, cross_checks, settings, jump };
    let hits: Vec<Option<(FlowMatch, Point)>> = tracks.par_iter().map(|t| step.flow(t)).collect();
    let places: Vec<Option<Point>> = hits.iter().map(|h| h.map(|(_, point)| point)).collect();
    let refined: Vec<Option<Sighting>> =
        tracks.par_iter().zip(&hits).map(|(t, hit)| step.refine(t, *hit, &places)).collect();
    let places: Vec<Option<Point>> = refined.iter().map(|s| s.as_ref().map(|s| s.point)).collect();
    tracks.par_iter().zip(refined).map(|(t, s)| step.check(t, s, &places)).collect()
}

struct Step<'a> {
    tracks: &'a [Track],
    before: &'a [Option<PosedView<'a>>],
    now: &'a [Option<PosedView<'a>>],
    cross_checks: &'a CrossChecks,
    settings: &'a FlowSettings,
    jump: f32,
}

impl Step<'_> {
    /// Optical flow: the place that a track's pixels moved to since the last frame.
    fn flow(&self, track: &Track) -> Option<(FlowMatch, Point)> {
        if !track.seen {
            return None;
        }
        let (before, now) = (self.before[track.camera]?, self.now[track.camera]?);
        let velocity = self.velocity(track);
        let ahead = [0, 1, 2].map(|i| track.point[i] + velocity[i] as f32);
        let (ahead, _) = now.camera.project(ahead, now.frame)?;
        let hit = follow(
            before.view.layer(track.region)?,
            now.view.layer(track.region)?,
            track.at,
            &[ahead, track.at],
            self.settings,
        )?;
        let point = now.lift(hit.at, track.region, self.jump)?;
        Some((hit, point))
    }

    /// Median of a track's and its neighbours' velocities, coordinate by coordinate.
    fn velocity(&self, track: &Track) -> [f64; 3] {
        let mut known: Vec<[f64; 3]> = track
            .neighbours
            .iter()
            .map(|&j| &self.tracks[j as usize])
            .chain([track])
            .filter(|t| t.seen)
            .map(|t| t.velocity)
            .collect();
        let middle = known.len() / 2;
        [0, 1, 2].map(|i| {
            known.sort_by(|a, b| a[i].total_cmp(&b[i]));
            known.get(middle).map_or(0.0, |v| v[i])
        })
    }

    /// Matches a track's appearance where flow and neighbours say that it is, or should reappear.
    fn refine(
        &self,
        track: &Track,
        hit: Option<(FlowMatch, Point)>,
        places: &[Option<Point>],
    ) -> Option<Sighting> {
        let now = self.now[track.camera]?;
        let motion = track.motion(self.tracks, places, self.settings);
        let expected = motion.as_ref().map(|m| m.apply(track.seed_point));
        let rotation = motion.as_ref().map_or(track.rotation, |m| m.rotation);
        if expected.is_none() && self.tracks.len() > 1 {
            // No neighbour is seen, or they contradict each other: it would be a guess.
            return None;
        }
        let near = |point: Point| {
            expected.is_none_or(|e| distance(point, e) < 1.5 * self.settings.max_deviation_m)
        };
        let hit = hit.filter(|(_, point)| near(*point));
        let (start, point) = match (hit, expected) {
            (Some((hit, point)), _) => (hit.at, point),
            (None, Some(expected)) => (self.reappearing(track, expected)?, expected),
            (None, None) => return None,
        };
        let good = |appearance: &Appearance| {
            appearance
                .find(now, track.region, start, point, &rotation)
                .filter(|a| f64::from(a.correlation) >= self.settings.min_correlation)
        };
        let known = good(&track.first).or_else(|| track.recent.as_ref().and_then(&good));
        let (at, renewed) = match (known, hit) {
            (Some(found), _) => (found.at, None),
            // Followed as its neighbours were, but too changed to be recognised: from now on by
            // its current look.
            (None, Some((hit, _))) if expected.is_some() => {
                let window = self.settings.window_px;
                let renewed =
                    Appearance::new(now, hit.at, track.region, rotation, window, self.jump)?;
                (hit.at, Some(renewed))
            }
            (None, _) => return None,
        };
        let point = now.lift(at, track.region, self.jump)?;
        near(point).then_some(Sighting {
            at,
            point,
            rotation,
            renewed,
            forward_backward_px: hit.map(|(hit, _)| hit.forward_backward_px),
            deviation_m: None,
        })
    }

    /// The place at which a hidden point should be seen again; `None` if it is still behind
    /// something.
    fn reappearing(&self, track: &Track, expected: Point) -> Option<[f64; 2]> {
        let now = self.now[track.camera]?;
        let (at, depth) = now.camera.project(expected, now.frame)?;
        let seen = now.view.depth(at, track.region, self.jump)?;
        ((f64::from(seen) - depth).abs() < 1.5 * self.settings.max_deviation_m).then_some(at)
    }

    /// Accepts a sighting or not, now that all are known.
    fn check(
        &self,
        track: &Track,
        sighting: Option<Sighting>,
        places: &[Option<Point>],
    ) -> TrackUpdate {
        let Some(now) = self.now[track.camera] else { return TrackUpdate::Unknown };
        let motion = track.motion(self.tracks, places, self.settings);
        let expected = motion.as_ref().map(|m| m.apply(track.seed_point));
        let accepted = sighting.and_then(|s| self.accepted(track, s, motion.as_ref()));
        match accepted {
            Some(sighting) => TrackUpdate::Seen(Box::new(sighting)),
            None => {
                let at = expected.and_then(|e| now.camera.project(e, now.frame));
                TrackUpdate::Hidden { at: at.map(|(at, _)| at) }
            }
        }
    }

    fn accepted(
        &self,
        track: &Track,
        sighting: Sighting,
        motion: Option<&Motion>,
    ) -> Option<Sighting> {
        let now = self.now[track.camera]?;
        let deviation = motion.map(|m| distance(m.apply(track.seed_point), sighting.point));
        let inside = now.view.inset(sighting.at, track.region) >= MIN_INSET_PX
            && now.view.is_smooth(sighting.at, track.region, self.jump);
        let agrees = deviation.is_none_or(|d| d < self.settings.max_deviation_m);
        let seen_through = self.settings.multi_view
            && track.region == Region::Object
            && self.cross_checks.partners(track.camera).filter_map(|other| self.now[other]).any(
                |other| contradicts(other, sighting.point, self.settings.multi_view_tolerance_m),
            );
        (inside && agrees && !seen_through)
            .then_some(Sighting { deviation_m: deviation, ..sighting })
    }
}
