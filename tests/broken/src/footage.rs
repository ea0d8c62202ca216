//! Camera data in memory, easy to change.

use std::sync::{Arc, LazyLock};

use bendtwin_capture::{
    Error,
    raw::{ColorImage, DepthImage, Frames, Mask, Recording, Region, Source, Tracks},
};
use bendtwin_synth::{FilmOptions, Scene, film};

/// A recording whose frames lie in memory.
#[derive(Clone, Debug)]
pub struct Footage {
    /// The recording without its frames.
    pub about: Recording,
    /// The frames of each camera.
    pub reels: Vec<CameraFrames>,
}

/// The frames of one camera, each shape [T].
#[derive(Clone, Debug, Default)]
pub struct CameraFrames {
    /// Colour images.
    pub color: Vec<Option<Arc<ColorImage>>>,
    /// Depth images.
    pub depth: Vec<Option<Arc<DepthImage>>>,
    /// Masks of the object.
    pub object: Vec<Option<Arc<Mask>>>,
    /// Masks of the hand.
    pub hand: Vec<Option<Arc<Mask>>>,
    /// 2D tracks.
    pub tracks: Option<Tracks>,
}

/// Number of frames of the healthy recording.
pub const FRAMES: usize = 36;

static HEALTHY: LazyLock<Footage> = LazyLock::new(|| {
    let options =
        FilmOptions { frames: FRAMES, cameras: 3, size: [160, 120], ..FilmOptions::tiny(7) };
    let film = film(Scene::Toy, &options).expect("the scene is filmed");
    Footage::of(&film).expect("every frame is there")
});

/// A recording without any fault: three cameras, 36 frames.
pub fn healthy() -> Footage {
    HEALTHY.clone()
}

impl Footage {
    /// Reads all frames of a recording.
    ///
    /// # Errors
    /// If one is damaged.
    pub fn of(recording: &Recording) -> Result<Self, Error> {
        let reel = |camera| -> Result<CameraFrames, Error> {
            let mut frames = recording.source.frames(camera)?;
            let mut reel = CameraFrames { tracks: frames.tracks()?, ..CameraFrames::default() };
            for frame in 0..recording.frame_count {
                reel.color.push(frames.color(frame)?.map(Arc::new));
                reel.depth.push(frames.depth(frame)?.map(Arc::new));
                reel.object.push(frames.mask(frame, Region::Object)?.map(Arc::new));
                reel.hand.push(frames.mask(frame, Region::Manipulator)?.map(Arc::new));
            }
            Ok(reel)
        };
        let reels = (0..recording.cameras.len()).map(reel).collect::<Result<_, _>>()?;
        Ok(Self { about: recording.clone(), reels })
    }

    /// The recording as a reader would return it.
    pub fn recording(self) -> Recording {
        Recording { source: Arc::new(MemorySource(self.reels)), ..self.about }
    }

    /// Changes every depth of a camera.
    pub fn change_depth(&mut self, camera: usize, change: impl Fn(f32) -> f32) {
        for depth in self.reels[camera].depth.iter_mut().flatten() {
            Arc::make_mut(depth).pixels.iter_mut().for_each(|z| *z = change(*z));
        }
    }

    /// Changes every track of a camera, given its frame and number.
    pub fn change_tracks(
        &mut self,
        camera: usize,
        change: impl Fn(usize, usize, &mut [f32; 2], &mut bool),
    ) {
        let Some(tracks) = &mut self.reels[camera].tracks else { return };
        let cells = tracks.points.iter_mut().zip(&mut tracks.visible);
        for (i, (point, visible)) in cells.enumerate() {
            change(i / tracks.count, i % tracks.count, point, visible);
        }
    }

    /// Shows in frame f what the camera saw in frame `moment(f)`; nothing if that is `None`.
    pub fn retime(&mut self, camera: usize, moment: impl Fn(usize) -> Option<usize>) {
        let reel = &mut self.reels[camera];
        let moments: Vec<Option<usize>> = (0..self.about.frame_count).map(moment).collect();
        fn at<T: Clone>(images: &[Option<T>], moments: &[Option<usize>]) -> Vec<Option<T>> {
            moments.iter().map(|m| images.get((*m)?).cloned().flatten()).collect()
        }
        reel.color = at(&reel.color, &moments);
        reel.depth = at(&reel.depth, &moments);
        reel.object = at(&reel.object, &moments);
        reel.hand = at(&reel.hand, &moments);
        if let Some(tracks) = &mut reel.tracks {
            let n = tracks.count;
            let rows = |m: &Option<usize>| m.unwrap_or(0) * n..(m.unwrap_or(0) + 1) * n;
            tracks.points = moments.iter().flat_map(|m| tracks.points[rows(m)].to_vec()).collect();
            let seen = |m: &Option<usize>| {
                let row = tracks.visible[rows(m)].iter();
                row.map(|v| *v && m.is_some()).collect::<Vec<_>>()
            };
            tracks.visible = moments.iter().flat_map(seen).collect();
        }
    }
}

#[derive(Debug)]
struct MemorySource(Vec<CameraFrames>);

struct MemoryReader<'a>(&'a CameraFrames);

impl Source for MemorySource {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        let reel = self.0.get(camera).ok_or(Error::NoCamera(camera))?;
        Ok(Box::new(MemoryReader(reel)))
    }
}

fn shown<T: Clone>(images: &[Option<Arc<T>>], frame: usize) -> Option<T> {
    Some(T::clone(images.get(frame)?.as_ref()?))
}

impl Frames for MemoryReader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        Ok(shown(&self.0.color, frame))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        Ok(shown(&self.0.depth, frame))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        Ok(shown(
            match region {
                Region::Object => &self.0.object,
                Region::Manipulator => &self.0.hand,
            },
            frame,
        ))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        Ok(self.0.tracks.clone())
    }
}
