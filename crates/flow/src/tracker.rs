//! Frame after frame: reads all cameras side by side, follows all points, keeps what was found.

use bendtwin_capture::raw::{Camera, Frames, Recording, Region};
use bendtwin_core::CancelToken;
use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::{
    CameraTracks, Error, FlowSettings, Guide,
    appearance::{Appearance, Glimpse},
    carried::Carriers,
    frame::{Found, follow_all},
    multiview::Witnesses,
    outcome::Log,
    seed::{Seed, seeds},
    track::{Track, join},
    view::View,
};

/// Tracks the points of all cameras of a recording; element `c` belongs to camera `c`. `progress` is called after each frame
/// with the number of frames that are done and of all frames. Two frames of each camera are in memory at a time.
///
/// Points are seeded in the first frame that a camera has. The manipulator's points are followed by their texture, or, where it
/// has none, by its shape.
///
/// # Errors
/// If settings are out of range, frames are damaged or of another size than their camera, or `cancel` was called.
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

/// The same settings with no more points than a usual machine can follow in as many cameras and keep over as many frames.
fn affordable(settings: &FlowSettings, cameras: usize, frames: usize) -> FlowSettings {
    /// Points in all cameras together; each keeps about 25 kB.
    const POINTS: usize = 6_000;
    /// Points times frames; each keeps about 25 bytes.
    const SIGHTINGS: usize = 20_000_000;
    let most = POINTS.min(SIGHTINGS / frames.max(1)) / cameras.max(1);
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

/// All that is known after some frames.
struct State<'a> {
    recording: &'a Recording,
    settings: &'a FlowSettings,
    /// Each camera's last view, and its frame.
    views: Vec<Option<(usize, View)>>,
    tracks: Vec<Track>,
    carriers: Carriers,
    witnesses: Witnesses,
    logs: Vec<Log>,
}

/// Fewer textured points than this in all cameras do not tell how a manipulator moves.
const FEW: usize = 30;

impl<'a> State<'a> {
    fn new(recording: &'a Recording, settings: &'a FlowSettings) -> Self {
        let cameras = recording.cameras.len();
        Self {
            recording,
            settings,
            views: (0..cameras).map(|_| None).collect(),
            tracks: Vec::new(),
            carriers: Carriers::default(),
            witnesses: Witnesses::new(cameras),
            logs: vec![Log::default(); cameras],
        }
    }

    fn advance(&mut self, frame: usize, views: Vec<Option<View>>) {
        let cameras = &self.recording.cameras;
        let before = last(cameras, &self.views);
        let now: Vec<_> = views
            .iter()
            .zip(cameras)
            .map(|(view, camera)| view.as_ref().map(|view| Glimpse { view, camera, frame }))
            .collect();
        let found = follow_all(&self.tracks, &before, &now, &self.witnesses, self.settings);
        self.carriers.advance(&now, self.settings);
        for (track, found) in self.tracks.iter_mut().zip(found) {
            let log = &mut self.logs[track.camera];
            match found {
                Found::Unknown => log.push(track.at, false),
                Found::Hidden { at } => {
                    track.seen = false;
                    log.push(at.unwrap_or(track.at), false);
                }
                Found::Seen(sighting) => {
                    log.forward_backward.extend(sighting.forward_backward_px);
                    log.deviations.extend(sighting.deviation_m);
                    log.push(sighting.at, true);
                    track.see(*sighting);
                }
            }
        }
        for point in &self.carriers.points {
            self.logs[point.camera].push(point.at, point.seen && now[point.camera].is_some());
        }
        let fresh: Vec<(usize, Glimpse<'_>)> = now
            .iter()
            .enumerate()
            .filter(|(camera, _)| self.views[*camera].is_none())
            .filter_map(|(camera, glimpse)| Some((camera, (*glimpse)?)))
            .collect();
        let first = self.tracks.len();
        self.seed(&fresh);
        for (camera, _) in fresh {
            let tolerance_m = self.settings.multi_view_tolerance_m;
            self.witnesses.examine(camera, &self.tracks[first..], &now, tolerance_m);
        }
        for (kept, view) in self.views.iter_mut().zip(views) {
            if let Some(view) = view {
                *kept = Some((frame, view));
            }
        }
    }

    /// Seeds the points of cameras in the first frame that they have.
    fn seed(&mut self, fresh: &[(usize, Glimpse<'_>)]) {
        let first = self.tracks.len();
        let carried = self.carriers.points.len();
        let mut hands = Vec::new();
        for &(camera, glimpse) in fresh {
            let object = seeds(glimpse.view, Region::Object, self.settings);
            let hand = seeds(glimpse.view, Region::Manipulator, self.settings);
            self.logs[camera].textures = [object.median_texture(), hand.median_texture()];
            self.sow(camera, glimpse, Region::Object, &object.seeds);
            hands.push(hand.seeds);
        }
        if self.carriers.points.is_empty() && hands.iter().map(Vec::len).sum::<usize>() >= FEW {
            for (&(camera, glimpse), seeds) in fresh.iter().zip(&hands) {
                self.logs[camera].guide = Some(Guide::Texture);
                self.sow(camera, glimpse, Region::Manipulator, seeds);
            }
        } else {
            self.carriers.seed(fresh, self.settings);
        }
        for point in &self.carriers.points[carried..] {
            let log = &mut self.logs[point.camera];
            log.guide = Some(Guide::Shape);
            log.regions.push(Region::Manipulator);
            log.push(point.at, true);
        }
        join(&mut self.tracks, first, self.settings);
    }

    /// Begins to follow textured points.
    fn sow(&mut self, camera: usize, glimpse: Glimpse<'_>, region: Region, seeds: &[Seed]) {
        let (window, jump) = (self.settings.window_px, self.settings.depth_jump_m as f32);
        let upright = Matrix3::identity();
        let born: Vec<Option<Track>> = seeds
            .par_iter()
            .map(|seed| {
                let home = glimpse.lift(seed.at, region, jump)?;
                let first = Appearance::new(glimpse, seed.at, region, upright, window, jump)?;
                Some(Track {
                    camera,
                    region,
                    born: glimpse.frame,
                    home,
                    neighbours: Vec::new(),
                    first,
                    recent: None,
                    rotation: upright,
                    at: seed.at,
                    point: home,
                    velocity: [0.0; 3],
                    seen: true,
                })
            })
            .collect();
        for track in born.into_iter().flatten() {
            self.logs[camera].regions.push(region);
            self.logs[camera].push(track.at, true);
            self.tracks.push(track);
        }
    }

    fn finish(mut self) -> Vec<CameraTracks> {
        for (camera, log) in self.logs.iter_mut().enumerate() {
            log.contradicted_by = self.witnesses.unfit_for(camera);
        }
        let (frames, least) = (self.recording.frame_count, self.settings.min_texture);
        let cameras = &self.recording.cameras;
        let logs = self.logs.into_iter().zip(cameras);
        logs.map(|(log, camera)| log.finish(frames, &camera.name, least)).collect()
    }
}

/// What each camera saw last.
fn last<'a>(cameras: &'a [Camera], views: &'a [Option<(usize, View)>]) -> Vec<Option<Glimpse<'a>>> {
    views
        .iter()
        .zip(cameras)
        .map(|(view, camera)| {
            view.as_ref().map(|(frame, view)| Glimpse { view, camera, frame: *frame })
        })
        .collect()
}
