//! Content of a recording's files, as one pass over them finds it.

use std::collections::BTreeMap;

use super::{
    chunk::Chunk,
    joints::Joints,
    messages::{Calibration, ImageHead, Kind, Wire},
    pass::Pass,
    place::{Part, Place},
    transforms::Tree,
};
use crate::{Error, Limits};

/// A topic of images.
#[derive(Debug)]
pub(super) struct Topic {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) wire: Wire,
    /// Head of the first image.
    pub(super) head: ImageHead,
    /// In the order of the file.
    pub(super) images: Vec<Stamped>,
}

/// An image with its time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stamped {
    /// When it was taken, nanoseconds.
    pub(super) ns: i64,
    /// When it was recorded, nanoseconds.
    pub(super) log_ns: i64,
    pub(super) place: Place,
}

/// Content of the files.
#[derive(Debug, Default)]
pub(super) struct Index {
    /// Compressed chunks by their numbers.
    pub(super) chunks: Vec<Chunk>,
    pub(super) topics: Vec<Topic>,
    /// The first calibration of each topic.
    pub(super) calibrations: BTreeMap<String, Calibration>,
    pub(super) tree: Tree,
    pub(super) joints: Joints,
    /// Content of the metadata record `bendtwin`.
    pub(super) settings: BTreeMap<String, String>,
    /// Topics of images, videos and points in messages that are not read: what they are, by name.
    pub(super) unread: BTreeMap<String, String>,
    /// The first attached mesh.
    pub(super) mesh: Option<(String, Vec<u8>)>,
    /// The attached document of grippers.
    pub(super) grippers: Option<Vec<u8>>,
}

impl Index {
    /// Reads all files, in their order.
    pub(super) fn read(parts: &[Part], limits: &Limits) -> Result<Self, Error> {
        let mut pass = Pass::new(parts, limits);
        for (number, part) in (0..).zip(parts) {
            pass.file(number, part)?;
        }
        let mut index = pass.index;
        for topic in &mut index.topics {
            topic.images.sort_by_key(|image| image.ns);
        }
        index.topics.retain(|topic| !topic.images.is_empty());
        index.tree.sort();
        index.joints.sort();
        Ok(index)
    }
}
