//! Frames that are separate files, in a folder or a ZIP archive: what PhysTwin, the raw
//! bundle and nerfstudio have in common.

mod masks;

use std::{borrow::Cow, collections::BTreeMap, fmt, sync::Arc};

use self::masks::Kept;
pub(super) use self::masks::{
    Labelled, MaskFiles, Place, Shown, whole as whole_masks, words as mask_words,
};
use super::{
    ColorImage, DepthImage, Frames, Mask, Region, Source, Tracks,
    decode::{self, DepthUnit, Size},
    tracks::{self, Order},
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
}

/// Place of one camera's tracks.
#[derive(Clone, Debug)]
pub(super) enum TrackFiles {
    /// CoTracker's .npz: `tracks` [T, N, 2] as row, column and `visibility` [T, N].
    Npz(String),
    /// Positions [T, N, 2] as column, row; visibilities [T, N].
    Npy { points: String, visible: Option<String> },
}

/// Place of one camera's frames.
#[derive(Clone, Debug)]
pub(super) struct CameraFiles {
    pub(super) size: Size,
    pub(super) color: Names,
    pub(super) depth: Option<DepthNames>,
    /// The object's masks; the region is what any of them shows.
    pub(super) object: Vec<MaskFiles>,
    /// The manipulators' masks, likewise.
    pub(super) manipulator: Vec<MaskFiles>,
    pub(super) tracks: Option<TrackFiles>,
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
}

impl CameraFiles {
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
        let single = self.images().map(|names| names.count(frames, entries) as u64).sum::<u64>();
        let whole = self.masks().filter(|masks| matches!(masks.place, Place::Whole(_))).count();
        let images = single.saturating_add((whole as u64).saturating_mul(frames as u64));
        let [width, height] = self.size.map(|n| n as u64);
        width.saturating_mul(height).saturating_mul(images)
    }
}

impl fmt::Debug for StoredFrames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("StoredFrames").field("cameras", &self.cameras).finish_non_exhaustive()
    }
}

impl Source for StoredFrames {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        let camera = self.cameras.get(camera).ok_or(Error::NoCamera(camera))?;
        Ok(Box::new(Reader {
            files: self.files.fork(),
            camera,
            frame_count: self.frame_count,
            kept: Kept::default(),
        }))
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
        let [width, height] = self.camera.size;
        let cap = OVERHEAD + (width as u64 * height as u64).saturating_mul(16);
        Ok(self.files.find_within(&name, cap)?.map(|bytes| (name, bytes)))
    }
}

impl Frames for Reader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        let camera = self.camera;
        let Some((at, bytes)) = self.file(&camera.color, frame)? else { return Ok(None) };
        decode::color(&at, &bytes, camera.size).map(Some)
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        let camera = self.camera;
        let Some(depth) = &camera.depth else { return Ok(None) };
        let Some((at, bytes)) = self.file(&depth.names, frame)? else { return Ok(None) };
        decode::depth(&at, &bytes, depth.unit, camera.size, &mut self.files.budget).map(Some)
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
        let files = &mut self.files;
        files.budget = Budget::new(&files.limits);
        let limit = files.limits.points;
        match &self.camera.tracks {
            None => Ok(None),
            Some(TrackFiles::Npz(name)) => {
                let Some(bytes) = files.find(name)? else { return Ok(None) };
                let mut inner = Files::from_bytes(name, &bytes, &files.limits)?;
                let missing =
                    |array: &str| Error::MissingArray { at: name.clone(), array: array.to_owned() };
                let point_bytes = inner.find("tracks.npy")?.ok_or_else(|| missing("tracks"))?;
                let points = npy::read(&format!("{name}: tracks"), &point_bytes)?;
                let seen_bytes =
                    inner.find("visibility.npy")?.ok_or_else(|| missing("visibility"))?;
                let seen = npy::read(&format!("{name}: visibility"), &seen_bytes)?;
                let budget = &mut files.budget;
                tracks::join(
                    &points,
                    Some(&seen),
                    Order::RowColumn,
                    self.frame_count,
                    limit,
                    budget,
                )
                .map(Some)
            }
            Some(TrackFiles::Npy { points, visible }) => {
                let Some(bytes) = files.find(points)? else { return Ok(None) };
                let seen = match visible {
                    Some(name) => Some((name, files.read(name)?)),
                    None => None,
                };
                let seen = match &seen {
                    Some((name, bytes)) => Some(npy::read(name, bytes)?),
                    None => None,
                };
                let points = npy::read(points, &bytes)?;
                let budget = &mut files.budget;
                tracks::join(&points, seen.as_ref(), Order::Xy, self.frame_count, limit, budget)
                    .map(Some)
            }
        }
    }
}
