//! The tracker, frame after frame: reads all cameras side by side, follows all points, logs what it
//! finds.

use bendtwin_capture::raw::{Camera, Frames, Recording, Region};
use bendtwin_core::CancelToken;
use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::{
    CameraTracks, Error, FlowSettings, Guide,
    appearance::{Appearance, PosedView},
    frame::{TrackUpdate, follow_all},
    multi_view::CrossChecks,
    outcome::CameraLog,
    seed::{Seed, seeds},
    shape_tracking::ShapeTracker,
    track::{Track, join},
    view::View,
};

/// Tracks the points of all cameras of a recording; element `c` belongs to camera `c`. `progress`
/// is called after each frame with the number of frames that are done and of all frames. Two frames
/// of each camera are in memory at a time.
///
/// Points are seeded in the first frame that a camera has. The manipulator's points are followed by
/// their texture, or, where it has none, by its shape.
///
/// # Errors
/// If settings are out of range, frames are damaged or of another size than their camera, or
/// `cancel` was called.
pub fn track(
    recording: &Recording,
    settings: &FlowSettings,
    progress: &mut dyn FnMut(usize, usize),
    cancel: &CancelToken,
) -> Result<Vec<CameraTracks>, Error> {
    settings.validate().map_err(Error::Settings)?;
    let settings = affordable(settings, recording.cameras.len(), recording.frame_count);
    let mut readers = (0..recording.cameras.len())
        .map(|c| recording.source.frames(c))
        .collect::<Result<Vec<_>, _>>()?;
    let mut state = State::new(recording, &settings);
    for frame in 0..recording.frame_count {
        if cancel.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let views = read(&mut readers, recording, frame, &settings)?;
        state.advance(frame, views);
        progress(frame + 1, recording.frame_count);
    }
    Ok(state.finish())
}

/// The settings with no more points than a usual machine can follow in this number of cameras and
/// keep over this number of frames.
fn affordable(settings: &FlowSettings, cameras: usize, frames: usize) -> FlowSettings {
    /// Points in all cameras together; each keeps about 25 kB.
    const MAX_POINTS: usize = 6_000;
    /// Points times frames; each keeps about 25 bytes.
    const MAX_POINT_FRAMES: usize = 20_000_000;
    let most = MAX_POINTS.min(MAX_POINT_FRAMES / frames.max(1)) / cameras.max(1);
    let manipulator = settings.max_manipulator_points.min(most / 4);
    FlowSettings {
        max_object_points: settings.max_object_points.min(most - manipulator),
        max_manipulator_points: manipulator,
        ..settings.clone()
    }
}

fn read(
    readers: &mut [Box<dyn Frames + '_>],
    recording: &Recording,
    frame: usize,
    settings: &FlowSettings,
) -> Result<Vec<Option<View>>, Error> {
    readers
        .par_iter_mut()
        .zip(&recording.cameras)
        .map(|(reader, camera)| View::read(reader.as_mut(), camera, frame, settings))
        .collect()
}

/// The tracker's state after some frames.
struct State<'a> {
    recording: &'a Recording,
    settings: &'a FlowSettings,
    /// Each camera's last view, and its frame.
    views: Vec<Option<(usize, View)>>,
    tracks: Vec<Track>,
    shape_tracker: ShapeTracker,
    cross_checks: CrossChecks,
    logs: Vec<CameraLog>,
}

/// Least textured points in all cameras by which a manipulator's motion can be known.
const MIN_TEXTURED_POINTS: usize = 30;
/// Texture from which a point of a manipulator is textured [grey levels of 255 per px]. JPEG images of
/// quality 80 show a plain hand with 4.6 to 5.3, which does not move with it.
const MIN_MANIPULATOR_TEXTURE: f32 = 8.0;

impl<'a> State<'a> {
    fn new(recording: &'a Recording, settings: &'a FlowSettings) -> Self {
        let cameras = recording.cameras.len();
        Self {
            recording,
            settings,
            views: (0..cameras).map(|_| None).collect(),
            tracks: Vec::new(),
            shape_tracker: ShapeTracker::default(),
            cross_checks: CrossChecks::new(cameras),
            logs: vec![CameraLog::default(); cameras],
        }
    }

    fn advance(&mut self, frame: usize, views: Vec<Option<View>>) {
        let cameras = &self.recording.cameras;
        let before = last(cameras, &self.views);
        let now: Vec<_> = views
            .iter()
            .zip(cameras)
            .map(|(view, camera)| view.as_ref().map(|view| PosedView { view, camera, frame }))
            .collect();
        let found = follow_all(&self.tracks, &before, &now, &self.cross_checks, self.settings);
        self.shape_tracker.advance(&now, self.settings);
        for (track, found) in self.tracks.iter_mut().zip(found) {
            let log = &mut self.logs[track.camera];
            match found {
                TrackUpdate::Unknown => log.push(track.at, false),
                TrackUpdate::Hidden { at } => {
                    track.seen = false;
                    log.push(at.unwrap_or(track.at), false);
                }
                TrackUpdate::Seen(sighting) => {
                    log.forward_backward.extend(sighting.forward_backward_px);
                    log.deviations.extend(sighting.deviation_m);
                    log.push(sighting.at, true);
                    track.apply(*sighting);
                }
            }
        }
        for point in &self.shape_tracker.points {
            self.logs[point.camera].push(point.at, point.seen && now[point.camera].is_some());
        }
        let fresh: Vec<(usize, PosedView<'_>)> = now
            .iter()
            .enumerate()
            .filter(|(camera, _)| self.views[*camera].is_none())
            .filter_map(|(camera, posed)| Some((camera, (*posed)?)))
            .collect();
        let first = self.tracks.len();
        self.seed(&fresh);
        for (camera, _) in fresh {
            let tolerance_m = self.settings.multi_view_tolerance_m;
            self.cross_checks.screen(camera, &self.tracks[first..], &now, tolerance_m);
        }
        for (kept, view) in self.views.iter_mut().zip(views) {
            if let Some(view) = view {
                *kept = Some((frame, view));
            }
        }
    }

    /// Seeds the points of cameras in the first frame that they have.
    fn seed(&mut self, fresh: &[(usize, PosedView<'_>)]) {
        let first = self.tracks.len();
        let carried = self.shape_tracker.points.len();
        let mut hands = Vec::new();
        for &(camera, posed) in fresh {
            let object = seeds(posed.view, Region::Object, self.settings);
            let hand = seeds(posed.view, Region::Manipulator, self.settings);
            self.logs[camera].textures = [object.median_texture(), hand.median_texture()];
            self.start_tracks(camera, posed, Region::Object, &object.seeds);
            hands.push(hand.seeds);
        }
        if self.shape_tracker.points.is_empty()
            && hands.iter().flatten().filter(|s| s.texture >= MIN_MANIPULATOR_TEXTURE).count()
                >= MIN_TEXTURED_POINTS
        {
            for (&(camera, posed), seeds) in fresh.iter().zip(&hands) {
                self.logs[camera].guide = Some(Guide::Texture);
                self.start_tracks(camera, posed, Region::Manipulator, seeds);
            }
        } else {
            self.shape_tracker.seed(fresh, self.settings);
        }
        for point in &self.shape_tracker.points[carried..] {
            let log = &mut self.logs[point.camera];
            log.guide = Some(Guide::Shape);
            log.regions.push(Region::Manipulator);
            log.push(point.at, true);
        }
        join(&mut self.tracks, first, self.settings);
    }

    /// Begins to follow textured points.
    fn start_tracks(
        &mut self,
        camera: usize,
        posed: PosedView<'_>,
        region: Region,
        seeds: &[Seed],
    ) {
        let (window, jump) = (self.settings.window_px, self.settings.depth_jump_m as f32);
        let upright = Matrix3::identity();
        let started: Vec<Option<Track>> = seeds
            .par_iter()
            .map(|seed| {
                let seed_point = posed.lift(seed.at, region, jump)?;
                let first = Appearance::new(posed, seed.at, region, upright, window, jump)?;
                Some(Track {
                    camera,
                    region,
                    first_frame: posed.frame,
                    seed_point,
                    neighbours: Vec::new(),
                    first,
                    recent: None,
                    rotation: upright,
                    at: seed.at,
                    point: seed_point,
                    velocity: [0.0; 3],
                    seen: true,
                })
            })
            .collect();
        for track in started.into_iter().flatten() {
            self.logs[camera].regions.push(region);
            self.logs[camera].push(track.at, true);
            self.tracks.push(track);
        }
    }

    fn finish(mut self) -> Vec<CameraTracks> {
        for (camera, log) in self.logs.iter_mut().enumerate() {
            log.contradicted_by = self.cross_checks.excluded_for(camera);
        }
        let (frames, least) = (self.recording.frame_count, self.settings.min_texture);
        let cameras = &self.recording.cameras;
        let logs = self.logs.into_iter().zip(cameras);
        logs.map(|(log, camera)| log.finish(frames, &camera.name, least)).collect()
    }
}

/// The last view of each camera.
fn last<'a>(
    cameras: &'a [Camera],
    views: &'a [Option<(usize, View)>],
) -> Vec<Option<PosedView<'a>>> {
    views
        .iter()
        .zip(cameras)
        .map(|(view, camera)| {
            view.as_ref().map(|(frame, view)| PosedView { view, camera, frame: *frame })
        })
        .collect()
}
