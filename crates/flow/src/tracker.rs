//! Frame after frame: reads all cameras side by side, follows all points, keeps what was found.

use bendtwin_capture::raw::{Frames, Recording, Region, Tracks};
use bendtwin_core::Point;
use bendtwin_engine::backend::CancelToken;
use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::{
    Error, FlowSettings, Texture, TrackerQuality,
    appearance::{Appearance, Glimpse},
    frame::{Found, follow_all},
    quality::median,
    seed::{Seeds, seeds},
    track::{Track, join},
    view::View,
};

/// What was tracked in one camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraTracks {
    /// Tracks of the object, then of the manipulator. While a point is not seen, its place is where its neighbours put it,
    /// or where it was last seen.
    pub tracks: Tracks,
    /// What each track lies on, shape [N].
    pub regions: Vec<Region>,
    /// How good they are.
    pub quality: TrackerQuality,
}

/// Tracks the points of all cameras of a recording; element `c` belongs to camera `c`. `progress` is called after each frame
/// with the number of frames that are done and of all frames. Two frames of each camera are in memory at a time.
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
    let mut readers = (0..recording.cameras.len())
        .map(|c| recording.source.frames(c))
        .collect::<Result<Vec<_>, _>>()?;
    let mut state = State::new(recording, settings);
    for frame in 0..recording.frame_count {
        if cancel.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let views = read(&mut readers, recording, frame, settings)?;
        state.advance(frame, views);
        progress(frame + 1, recording.frame_count);
    }
    Ok(state.finish())
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
    seeds: Vec<[Seeds; 2]>,
    /// For each frame what was found of each track; fewer tracks in frames before the last seeding.
    places: Vec<Vec<Place>>,
    forward_backward: Vec<Vec<f64>>,
    deviations: Vec<Vec<f64>>,
}

#[derive(Clone, Copy)]
struct Place {
    at: [f32; 2],
    seen: bool,
}

const REGIONS: [Region; 2] = [Region::Object, Region::Manipulator];

impl<'a> State<'a> {
    fn new(recording: &'a Recording, settings: &'a FlowSettings) -> Self {
        let cameras = recording.cameras.len();
        Self {
            recording,
            settings,
            views: (0..cameras).map(|_| None).collect(),
            tracks: Vec::new(),
            seeds: vec![Default::default(); cameras],
            places: Vec::new(),
            forward_backward: vec![Vec::new(); cameras],
            deviations: vec![Vec::new(); cameras],
        }
    }

    fn advance(&mut self, frame: usize, views: Vec<Option<View>>) {
        let cameras = &self.recording.cameras;
        let before: Vec<_> = glimpses(cameras, &self.views);
        let now: Vec<_> = views
            .iter()
            .zip(cameras)
            .map(|(view, camera)| view.as_ref().map(|view| Glimpse { view, camera, frame }))
            .collect();
        let found = follow_all(&self.tracks, &before, &now, self.settings);
        let mut places = Vec::with_capacity(found.len());
        for (track, found) in self.tracks.iter_mut().zip(found) {
            let camera = track.camera;
            match found {
                Found::Unknown => {
                    places.push(Place { at: track.at.map(|v| v as f32), seen: false });
                }
                Found::Hidden { at } => {
                    track.seen = false;
                    let at = at.unwrap_or(track.at);
                    places.push(Place { at: at.map(|v| v as f32), seen: false });
                }
                Found::Seen(sighting) => {
                    self.forward_backward[camera].extend(sighting.forward_backward_px);
                    self.deviations[camera].extend(sighting.deviation_m);
                    places.push(Place { at: sighting.at.map(|v| v as f32), seen: true });
                    track.see(*sighting);
                }
            }
        }
        self.places.push(places);
        for (camera, glimpse) in now.iter().enumerate() {
            if let Some(glimpse) = glimpse
                && self.views[camera].is_none()
            {
                self.seed(camera, *glimpse);
            }
        }
        let first = self.tracks.iter().position(|t| t.born == frame).unwrap_or(self.tracks.len());
        join(&mut self.tracks, first, self.settings);
        for (kept, view) in self.views.iter_mut().zip(views) {
            if let Some(view) = view {
                *kept = Some((frame, view));
            }
        }
    }

    /// Seeds the points of a camera in the first frame that it has.
    fn seed(&mut self, camera: usize, glimpse: Glimpse<'_>) {
        let settings = self.settings;
        let jump = settings.depth_jump_m as f32;
        for (i, region) in REGIONS.into_iter().enumerate() {
            let seeds = seeds(glimpse.view, region, settings);
            let upright = Matrix3::identity();
            let born: Vec<Option<Track>> = seeds
                .seeds
                .par_iter()
                .map(|seed| {
                    let (at, window) = (seed.at, settings.window_px);
                    let home: Point = glimpse.lift(at, region, jump)?;
                    let first = Appearance::new(glimpse, at, region, upright, window, jump)?;
                    Some(Track {
                        camera,
                        region,
                        born: glimpse.frame,
                        home,
                        neighbours: Vec::new(),
                        first,
                        recent: None,
                        rotation: upright,
                        at,
                        point: home,
                        velocity: [0.0; 3],
                        seen: true,
                    })
                })
                .collect();
            for track in born.into_iter().flatten() {
                if let Some(places) = self.places.last_mut() {
                    places.push(Place { at: track.at.map(|v| v as f32), seen: true });
                }
                self.tracks.push(track);
            }
            self.seeds[camera][i] = seeds;
        }
    }

    fn finish(self) -> Vec<CameraTracks> {
        (0..self.recording.cameras.len()).map(|camera| self.of_camera(camera)).collect()
    }

    fn of_camera(&self, camera: usize) -> CameraTracks {
        let mine: Vec<usize> =
            (0..self.tracks.len()).filter(|&i| self.tracks[i].camera == camera).collect();
        let mut tracks = Tracks { count: mine.len(), ..Tracks::default() };
        let mut survivors = [Vec::new(), Vec::new()];
        for places in &self.places {
            let mut seen = [0, 0];
            for &i in &mine {
                // Before it was seeded, a point is where it was seeded, unseen.
                let place = places.get(i).copied();
                let place = place.unwrap_or(Place { at: self.first_place(i), seen: false });
                tracks.points.push(place.at);
                tracks.visible.push(place.seen);
                let region = usize::from(self.tracks[i].region == Region::Manipulator);
                seen[region] += usize::from(place.seen);
            }
            for (all, seen) in survivors.iter_mut().zip(seen) {
                all.push(seen);
            }
        }
        let regions: Vec<_> = mine.iter().map(|&i| self.tracks[i].region).collect();
        CameraTracks { tracks, quality: self.quality(camera, &regions, survivors), regions }
    }

    fn first_place(&self, track: usize) -> [f32; 2] {
        let born = self.tracks[track].born;
        self.places.get(born).and_then(|p| p.get(track)).map_or([0.0; 2], |p| p.at)
    }

    fn quality(
        &self,
        camera: usize,
        regions: &[Region],
        [object, manipulator]: [Vec<usize>; 2],
    ) -> TrackerQuality {
        let object_points = regions.iter().filter(|&&r| r == Region::Object).count();
        let texture = |i: usize| {
            let textures = &self.seeds[camera][i].textures;
            textures.get(textures.len() / 2).copied().map(f64::from)
        };
        let kept =
            object.iter().sum::<usize>() as f64 / (object.len() * object_points).max(1) as f64;
        let verdict = Texture::judge(texture(0), object_points, kept, self.settings.min_texture);
        TrackerQuality {
            object_points,
            manipulator_points: regions.len() - object_points,
            object_survivors: object,
            manipulator_survivors: manipulator,
            forward_backward_px: median(&mut self.forward_backward[camera].clone()),
            deviation_m: median(&mut self.deviations[camera].clone()),
            object_texture: texture(0),
            manipulator_texture: texture(1),
            verdict,
            summary: verdict.words(&self.recording.cameras[camera].name),
        }
    }
}

/// What each camera saw last.
fn glimpses<'a>(
    cameras: &'a [bendtwin_capture::raw::Camera],
    views: &'a [Option<(usize, View)>],
) -> Vec<Option<Glimpse<'a>>> {
    views
        .iter()
        .zip(cameras)
        .map(|(view, camera)| {
            view.as_ref().map(|(frame, view)| Glimpse { view, camera, frame: *frame })
        })
        .collect()
}
