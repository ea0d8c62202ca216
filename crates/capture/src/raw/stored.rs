//! Frames that are separate files, in a folder or a ZIP archive: what PhysTwin, the raw
//! bundle and nerfstudio have in common.

mod masks;
pub(super) mod probe;

use std::{borrow::Cow, collections::BTreeMap, fmt, ops::Range, sync::Arc};

use self::masks::Kept;
pub(super) use self::masks::{
    Labelled, MaskFiles, Place, Shown, whole as whole_masks, words as mask_words,
};
use super::{
    ColorImage, DepthImage, Frames, Mask, Region, Source, Tracks,
    decode::{self, DepthUnit, Size, Turn},
    realign::DepthCamera,
    tracks::{self, Order, Subject},
};
use crate::{Error, files::Files, limits::Budget, npy};

/// Bytes of an image file beside those of its pixels.
const OVERHEAD: u64 = 4 << 20;

/// Parts that the mask of one region may be made of.
pub(super) const MAX_PARTS: usize = 64;

/// Frames in which an image is looked for that stands for all of its kind.
const FIRST: usize = 100;

/// A mesh larger than this was not made for a soft body.
pub(super) const MAX_MESH: u64 = 256 << 20;

/// The names of one kind of image, frame by frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Names {
    /// `before` + the frame's number with at least `digits` digits + `after`.
    Numbered { before: String, digits: usize, after: String },
    /// A name for each frame that was recorded.
    Listed(Vec<Option<String>>),
    /// Names that exist, by their frames.
    Found(Arc<BTreeMap<usize, String>>),
}

impl Names {
    /// Number of images that are read under these names in an archive of `entries` files.
    fn count(&self, frames: usize, entries: usize) -> usize {
        match self {
            Self::Numbered { .. } => frames.min(entries),
            // One file may be listed many times, and is decoded as often.
            Self::Listed(names) => names.iter().flatten().count(),
            Self::Found(names) => names.len(),
        }
    }

    pub(super) fn at(&self, frame: usize) -> Option<Cow<'_, str>> {
        match self {
            Self::Numbered { before, digits, after } => {
                Some(format!("{before}{frame:0digits$}{after}").into())
            }
            Self::Listed(names) => names.get(frame)?.as_deref().map(Cow::Borrowed),
            Self::Found(names) => names.get(&frame).map(|name| Cow::Borrowed(name.as_str())),
        }
    }
}

/// Place of one camera's depth.
#[derive(Clone, Debug)]
pub(super) struct DepthNames {
    pub(super) names: Names,
    pub(super) unit: DepthUnit,
    /// The camera that measured it, if that is not the one of colour.
    pub(super) camera: Option<Arc<DepthCamera>>,
}

impl DepthNames {
    /// Depth on the grid of colour.
    pub(super) fn aligned(names: Names, unit: DepthUnit) -> Self {
        Self { names, unit, camera: None }
    }
}

/// Place of one camera's tracks.
#[derive(Clone, Debug)]
pub(super) enum TrackFiles {
    /// An .npz file of positions and visibilities, in the order that suits the masks.
    Npz(String),
    /// Positions [T, N, 2] as column, row; visibilities [T, N].
    Npy { points: String, visible: Option<String> },
}

/// Place of one camera's frames.
#[derive(Clone, Debug)]
pub(super) struct CameraFiles {
    pub(super) size: Size,
    pub(super) color: Names,
    /// What counts of colour images that declare an orientation.
    pub(super) turn: Turn,
    pub(super) depth: Option<DepthNames>,
    /// The object's masks; the region is what any of them shows.
    pub(super) object: Vec<MaskFiles>,
    /// The manipulators' masks, likewise.
    pub(super) manipulator: Vec<MaskFiles>,
    pub(super) tracks: Option<TrackFiles>,
    /// Frames of its own images, if they are not all frames.
    pub(super) span: Option<Range<usize>>,
}

/// A [`Source`] over files.
pub(super) struct StoredFrames {
    pub(super) files: Files<'static>,
    pub(super) frame_count: usize,
    pub(super) cameras: Vec<CameraFiles>,
}

impl StoredFrames {
    /// The frames of these cameras.
    ///
    /// # Errors
    /// If their images have more pixels than an archive of its size may hold, or are pointers of Git
    /// LFS.
    pub(super) fn new(
        mut files: Files<'static>,
        frame_count: usize,
        cameras: Vec<CameraFiles>,
    ) -> Result<Self, Error> {
        for camera in &cameras {
            for names in camera.images() {
                let first = (0..frame_count.min(FIRST))
                    .find_map(|frame| names.at(frame).filter(|name| files.has(name)));
                if let Some(name) = first {
                    files.refuse_disguised(&name)?;
                }
            }
        }
        let entries = files.entry_count().unwrap_or(usize::MAX);
        let pixels = cameras.iter().map(|c| c.pixels(frame_count, entries));
        let pixels = pixels.fold(0, u64::saturating_add);
        files.limits.check_pixels(pixels, frame_count, files.length())?;
        Ok(Self { files, frame_count, cameras })
    }

    fn reader(&self, camera: usize) -> Result<Reader<'_>, Error> {
        let camera = self.cameras.get(camera).ok_or(Error::NoCamera(camera))?;
        Ok(Reader {
            files: self.files.fork(),
            camera,
            frame_count: self.frame_count,
            kept: Kept::default(),
        })
    }

    /// The form of a camera's tracks in words; none if there are none, or they cannot be read.
    pub(super) fn track_form(&self, camera: usize) -> Option<String> {
        self.reader(camera).ok()?.read_tracks().ok().flatten().map(|(_, form)| form)
    }
}

impl CameraFiles {
    /// Most bytes of an image's file.
    pub(super) fn file_cap(&self) -> u64 {
        let depth = self.depth.as_ref().and_then(|depth| Some(depth.camera.as_ref()?.size()));
        let area = |[width, height]: Size| (width as u64).saturating_mul(height as u64);
        let pixels = area(self.size).max(depth.map_or(0, area));
        OVERHEAD.saturating_add(pixels.saturating_mul(16))
    }

    /// Names of its images of all kinds.
    fn images(&self) -> impl Iterator<Item = &Names> {
        let depth = self.depth.as_ref().map(|d| &d.names);
        let masks = self.masks().filter_map(|masks| match &masks.place {
            Place::Each(names) => Some(names),
            Place::Whole(_) => None,
        });
        [&self.color].into_iter().chain(depth).chain(masks)
    }

    fn masks(&self) -> impl Iterator<Item = &MaskFiles> {
        self.object.iter().chain(&self.manipulator)
    }

    /// Pixels of all its images, at most.
    fn pixels(&self, frames: usize, entries: usize) -> u64 {
        let area = |[width, height]: Size| (width as u64).saturating_mul(height as u64);
        let count = |names: &Names| names.count(frames, entries) as u64;
        let single = self.images().map(count).fold(0, u64::saturating_add);
        let whole = self.masks().filter(|masks| matches!(masks.place, Place::Whole(_))).count();
        let images = single.saturating_add((whole as u64).saturating_mul(frames as u64));
        // Depth of another camera is decoded in its own size before it is drawn in that of colour.
        let other = self.depth.as_ref().and_then(|depth| {
            Some(area(depth.camera.as_ref()?.size()).saturating_mul(count(&depth.names)))
        });
        area(self.size).saturating_mul(images).saturating_add(other.unwrap_or(0))
    }
}

impl fmt::Debug for StoredFrames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("StoredFrames").field("cameras", &self.cameras).finish_non_exhaustive()
    }
}

impl Source for StoredFrames {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        Ok(Box::new(self.reader(camera)?))
    }

    fn files(&self) -> Vec<String> {
        let mut names = Vec::new();
        for camera in &self.cameras {
            for frame in 0..self.frame_count {
                names.extend(camera.images().filter_map(|n| Some(n.at(frame)?.into_owned())));
            }
            names.extend(camera.masks().filter_map(|masks| match &masks.place {
                Place::Whole(name) => Some(name.clone()),
                Place::Each(_) => None,
            }));
            match &camera.tracks {
                Some(TrackFiles::Npz(name)) => names.push(name.clone()),
                Some(TrackFiles::Npy { points, visible }) => {
                    names.extend([Some(points), visible.as_ref()].into_iter().flatten().cloned());
                }
                None => {}
            }
        }
        // Several labels may lie in one file.
        names.sort_unstable();
        names.dedup();
        let there = names.iter().filter(|name| self.files.has(name));
        there.map(|name| self.files.full_name(name)).collect()
    }

    fn color_stem(&self, camera: usize, frame: usize) -> Option<String> {
        let name = self.cameras.get(camera)?.color.at(frame)?;
        let file = name.rsplit('/').next().unwrap_or(&name);
        Some(file.rsplit_once('.').map_or(file, |(stem, _)| stem).to_owned())
    }
}

/// A file's name and content.
type Named<'a> = (Cow<'a, str>, Vec<u8>);

/// Reads one camera.
struct Reader<'a> {
    files: Files<'static>,
    camera: &'a CameraFiles,
    frame_count: usize,
    kept: Kept,
}

impl Reader<'_> {
    /// The file of a frame. The charge of an earlier one is given back: it is no longer held here.
    fn file<'n>(&mut self, names: &'n Names, frame: usize) -> Result<Option<Named<'n>>, Error> {
        if frame >= self.frame_count {
            return Ok(None);
        }
        let Some(name) = names.at(frame) else { return Ok(None) };
        self.files.budget = Budget::new(&self.files.limits);
        let cap = self.camera.file_cap();
        Ok(self.files.find_within(&name, cap)?.map(|bytes| (name, bytes)))
    }
}

impl Frames for Reader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        let camera = self.camera;
        let Some((at, bytes)) = self.file(&camera.color, frame)? else { return Ok(None) };
        decode::color_turned(&at, &bytes, camera.size, camera.turn).map(Some)
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        let camera = self.camera;
        let Some(depth) = &camera.depth else { return Ok(None) };
        let Some((at, bytes)) = self.file(&depth.names, frame)? else { return Ok(None) };
        let size = depth.camera.as_ref().map_or(camera.size, |camera| camera.size());
        let image = decode::depth(&at, &bytes, depth.unit, size, &mut self.files.budget)?;
        Ok(Some(match &depth.camera {
            Some(camera) => camera.align(&image),
            None => image,
        }))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        let camera = self.camera;
        let parts = match region {
            Region::Object => &camera.object,
            Region::Manipulator => &camera.manipulator,
        };
        let mut whole: Option<Mask> = None;
        for part in parts {
            let Some(mask) = self.part(part, frame)? else { continue };
            match &mut whole {
                None => whole = Some(mask),
                Some(whole) => {
                    whole.pixels.iter_mut().zip(&mask.pixels).for_each(|(a, b)| *a |= *b);
                }
            }
        }
        Ok(whole)
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        Ok(self.read_tracks()?.map(|(tracks, _)| tracks))
    }
}

impl Reader<'_> {
    /// Tracks, and their form in words.
    fn read_tracks(&mut self) -> Result<Option<(Tracks, String)>, Error> {
        let camera = self.camera;
        let Some(files) = &camera.tracks else { return Ok(None) };
        let mask = matches!(files, TrackFiles::Npz(_)).then(|| self.first_mask()).flatten();
        let subject = Subject {
            frame_count: self.frame_count,
            span: camera.span.clone().unwrap_or(0..self.frame_count),
            size: camera.size,
            mask: mask.as_ref(),
            order: match files {
                TrackFiles::Npz(_) => Order::Detected,
                TrackFiles::Npy { .. } => Order::Xy,
            },
        };
        let source = &mut self.files;
        source.budget = Budget::new(&source.limits);
        match files {
            TrackFiles::Npz(name) => {
                let Some(bytes) = source.find(name)? else { return Ok(None) };
                tracks::read_npz(name, &bytes, &subject, &source.limits, &mut source.budget)
                    .map(Some)
            }
            TrackFiles::Npy { points, visible } => {
                let Some(bytes) = source.find(points)? else { return Ok(None) };
                let seen = match visible {
                    Some(name) => Some((name, source.read(name)?)),
                    None => None,
                };
                let seen = match &seen {
                    Some((name, bytes)) => Some(npy::read(name, bytes)?),
                    None => None,
                };
                let (points, limit) = (npy::read(points, &bytes)?, source.limits.points);
                tracks::join(points, seen, &subject, limit, &mut source.budget).map(Some)
            }
        }
    }

    /// Object and manipulator in the first of the camera's frames, as far as they can be read.
    fn first_mask(&mut self) -> Option<Mask> {
        let first = self.camera.span.as_ref().map_or(0, |span| span.start);
        let regions = [Region::Object, Region::Manipulator];
        let masks = regions.map(|region| self.mask(first, region).ok().flatten());
        masks.into_iter().flatten().reduce(|mut all, mask| {
            all.pixels.iter_mut().zip(&mask.pixels).for_each(|(a, b)| *a |= *b);
            all
        })
    }
}
