//! Masks that are added to a recording of any format, from a separate archive or folder.

use std::{path::Path, sync::Arc};

use super::{Regions, find, parts::Stored};
use crate::{
    Error, Limits,
    files::Files,
    raw::{
        ColorImage, DepthImage, Frames, Mask, Recording, Region, Source, Tracks,
        decode::Turn,
        numbering::{self, Images},
        stored::{CameraFiles, Names, StoredFrames},
    },
};

/// What names the labels of masks that are added: no description of a recording lies beside them.
const NAMED: &str = "beside masks that are added `labels.json` says what their labels show, as in {\"1\": \"object\", \"2\": \"hand\"}";

/// Frames of a recording with masks of other files.
#[derive(Debug)]
struct WithMasks {
    images: Arc<dyn Source>,
    masks: StoredFrames,
}

struct Reader<'a> {
    images: Box<dyn Frames + 'a>,
    masks: Box<dyn Frames + 'a>,
}

impl Recording {
    /// The recording with the masks in a folder or an archive, which replace those that it has. They lie in `mask`,
    /// or at the root, in any form that a raw PhysTwin case may have, and are numbered by frames.
    ///
    /// # Errors
    /// If there are none, they are damaged, or nothing says what their labels show.
    pub fn with_mask_files(mut self, path: &Path, limits: &Limits) -> Result<Self, Error> {
        let mut files = Files::open(path, limits)?;
        let mut found = find(&mut files, &self.cameras, self.frame_count)?;
        // An archive may have one folder around all.
        if let ([only], true) = (files.list("").folders.as_slice(), found.is_empty()) {
            files = files.part(only);
            found = find(&mut files, &self.cameras, self.frame_count)?;
        }
        if found.is_empty() {
            return Err(Error::NoMasks { there: files.describe("") });
        }
        let parts = || found.cameras.iter().flat_map(|masks| masks.parts.iter().map(|(_, p)| p));
        let images: Vec<&Images> = parts()
            .filter_map(|part| match &part.stored {
                Stored::Images(images) => Some(images),
                Stored::Whole(_) => None,
            })
            .collect();
        let count = Some(("the recording", self.frame_count));
        let numbering = numbering::align(&images, count, limits)?;
        for images in &images {
            images.expect_frames(numbering)?;
        }
        let is_mask = |part: &str| part == "object masks" || part == "hand masks";
        self.sources.taken.retain(|taken| !is_mask(&taken.part));
        let stale = ["MASK_LABELS", "MASK_INFO_MISMATCH", "MASKS_NOT_FOUND"];
        self.notes.retain(|note| !stale.contains(&&*note.code));
        let regions = found
            .sort(&[], &self.cameras, numbering, &[], &mut self.notes, &mut self.sources)
            .map_err(|error| match error {
                Error::MaskLabels(fault) => Error::MaskLabels(format!("{fault}; {NAMED}")),
                other => other,
            })?;
        for note in self.notes.iter_mut().filter(|note| note.code == "MASK_LABELS") {
            note.advice = format!("if it is otherwise: {NAMED}");
        }
        let stored = self.cameras.iter().zip(regions).map(|(camera, regions)| {
            let [object, manipulator]: Regions = regions;
            CameraFiles {
                size: [camera.width, camera.height],
                color: Names::Listed(Vec::new()),
                turn: Turn::default(),
                depth: None,
                object,
                manipulator,
                tracks: None,
                span: None,
            }
        });
        let masks = StoredFrames::new(files, self.frame_count, stored.collect())?;
        self.source = Arc::new(WithMasks { images: self.source, masks });
        Ok(self)
    }
}

impl Source for WithMasks {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        let (images, masks) = (self.images.frames(camera)?, self.masks.frames(camera)?);
        Ok(Box::new(Reader { images, masks }))
    }

    fn files(&self) -> Vec<String> {
        self.images.files()
    }

    fn color_stem(&self, camera: usize, frame: usize) -> Option<String> {
        self.images.color_stem(camera, frame)
    }
}

impl Frames for Reader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        self.images.color(frame)
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        self.images.depth(frame)
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        self.masks.mask(frame, region)
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        self.images.tracks()
    }
}
