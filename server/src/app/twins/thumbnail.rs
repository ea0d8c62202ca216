//! Small pictures of twins and captures, for lists. They are drawn on request, a few at a time, and the last ones
//! are kept: a list of a thousand entries is drawn once.

use std::{
    collections::{HashMap, VecDeque},
    sync::{Mutex, PoisonError},
};

use bendtwin_core::{Point, ids::CaptureId};
use bendtwin_render::thumbnail;
use bendtwin_store::Digest;
use bendtwin_surface::of_twin;
use bytes::Bytes;
use futures::TryStreamExt as _;
use serde::Deserialize;
use tokio::sync::{Semaphore, SemaphorePermit};

use super::{App, Error, Result};
use crate::access::Scope;

/// Surfaces, pictures and exports that are made together.
const TURNS: usize = 2;
/// Pictures that are kept [bytes].
const KEPT_BYTES: usize = 32 << 20;
/// Largest head of a playback that is read for a picture [bytes].
const MOST_HEAD_BYTES: u64 = 4 << 20;
/// Bytes before the head of a playback, the last four of which have its length.
const BEFORE_HEAD: u64 = 16;
/// Coordinate of an unknown point in a playback.
const UNKNOWN: i16 = i16::MIN;

/// The turns of those that draw, and the pictures that are kept.
#[derive(Debug)]
pub(in crate::app) struct Drawing {
    turns: Semaphore,
    kept: Mutex<Kept>,
}

/// What a picture was made of, and its width.
type Key = (Digest, u32);

#[derive(Debug, Default)]
struct Kept {
    pictures: HashMap<Key, Thumbnail>,
    /// Oldest first.
    order: VecDeque<Key>,
    bytes: usize,
}

/// A picture in a file.
#[derive(Clone, Debug)]
pub(crate) struct Thumbnail {
    pub(crate) bytes: Bytes,
    pub(crate) media_type: &'static str,
    /// Digest of what it was made of.
    pub(crate) source: Digest,
}

/// What is to be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shown {
    Twin,
    /// The first image of its first camera, or else its points.
    Capture,
}

impl Default for Drawing {
    fn default() -> Self {
        Self { turns: Semaphore::new(TURNS), kept: Mutex::default() }
    }
}

impl Drawing {
    /// Waits until it is this caller's turn to draw.
    pub(super) async fn turn(&self) -> Option<SemaphorePermit<'_>> {
        // It is never closed.
        self.turns.acquire().await.ok()
    }

    fn find(&self, key: Key) -> Option<Thumbnail> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).pictures.get(&key).cloned()
    }

    fn keep(&self, key: Key, picture: &Thumbnail) {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).add(key, picture.clone());
    }
}

impl Kept {
    fn add(&mut self, key: Key, picture: Thumbnail) {
        self.bytes += picture.bytes.len();
        if let Some(before) = self.pictures.insert(key, picture) {
            self.bytes -= before.bytes.len();
        } else {
            self.order.push_back(key);
        }
        while self.bytes > KEPT_BYTES
            && let Some(oldest) = self.order.pop_front()
        {
            self.bytes -= self.pictures.remove(&oldest).map_or(0, |picture| picture.bytes.len());
        }
    }
}

impl App {
    /// A picture of about this width [pixels].
    ///
    /// # Errors
    /// [`Error::NoSurface`], or that there is no playback; [`Error::Invalid`] for an impossible width.
    pub(crate) async fn thumbnail(
        &self,
        shown: Shown,
        name: &str,
        width: u32,
    ) -> Result<Thumbnail> {
        let widths = thumbnail::WIDTHS;
        if !widths.contains(&width) {
            let fault = format!("is {width}: {} to {} are possible", widths.start(), widths.end());
            return Err(Error::invalid("width", fault));
        }
        match shown {
            Shown::Twin => self.twin_thumbnail(name, width).await,
            Shown::Capture => self.capture_thumbnail(name, width).await,
        }
    }

    async fn twin_thumbnail(&self, name: &str, width: u32) -> Result<Thumbnail> {
        let id = self.reach(Scope::TwinsRead, name).await?;
        let key = (self.store.twins().get(id).await?.digest, width);
        if let Some(kept) = self.drawing.find(key) {
            return Ok(kept);
        }
        let _turn = self.drawing.turn().await;
        let drawn = self.read_twin(id, move |row, twin| match of_twin(twin) {
            Some(surface) => Ok(thumbnail::of_surface(&surface, &twin.graph.rest_positions, width)),
            None => Err(Error::NoSurface(row.id.to_string())),
        });
        let picture =
            Thumbnail { bytes: drawn.await?.into(), media_type: "image/png", source: key.0 };
        self.drawing.keep(key, &picture);
        Ok(picture)
    }

    async fn capture_thumbnail(&self, name: &str, width: u32) -> Result<Thumbnail> {
        let id = self.reach(Scope::CapturesRead, name).await?;
        let key = (self.store.captures().playback_digest(id).await?, width);
        if let Some(kept) = self.drawing.find(key) {
            return Ok(kept);
        }
        let _turn = self.drawing.turn().await;
        let picture = self.picture_of_playback(id, key).await?;
        self.drawing.keep(key, &picture);
        Ok(picture)
    }

    async fn picture_of_playback(&self, id: CaptureId, (source, width): Key) -> Result<Thumbnail> {
        let unread = || Error::Internal(format!("the playback of {id} cannot be read"));
        let part = async |from: u64, length: u64| -> Result<Vec<u8>> {
            if length == 0 {
                return Ok(Vec::new());
            }
            let content = self.store.captures().playback_content(id).await?;
            let size = content.size_bytes;
            let end = from.checked_add(length).filter(|end| *end <= size).ok_or_else(unread)?;
            let chunks: Vec<_> = content.range(from..end).await?.chunks.try_collect().await?;
            Ok(chunks.concat())
        };
        let start = part(0, BEFORE_HEAD).await?;
        let length = start.last_chunk().map(|bytes| u64::from(u32::from_le_bytes(*bytes)));
        let length = length.filter(|length| *length <= MOST_HEAD_BYTES).ok_or_else(unread)?;
        let head = part(BEFORE_HEAD, length).await?;
        let head: Head = serde_json::from_slice(&head).map_err(|_| unread())?;
        let first = head.sequences.first();
        let data = BEFORE_HEAD + length;
        let at = |[from, length]: [u64; 2]| (data.saturating_add(from), length);
        if let Some(place) = first.and_then(|sequence| sequence.first_image()) {
            let (from, length) = at(place);
            let bytes = part(from, length).await?.into();
            return Ok(Thumbnail { bytes, media_type: "image/jpeg", source });
        }
        let Some(Sequence { motion, .. }) = first else {
            return Err(Error::NoSurface(id.to_string()));
        };
        let (from, all) = at(motion.points);
        let points = part(from, all.min(6 * motion.point_count)).await?;
        let colors = match motion.colors {
            Some(place) => part(at(place).0, at(place).1.min(3 * motion.point_count)).await?,
            None => Vec::new(),
        };
        let points = motion.positions(&points);
        let drawn = tokio::task::spawn_blocking(move || {
            thumbnail::of_points(&points, colors.as_chunks::<3>().0, width)
        });
        let bytes = drawn.await.map_err(|e| Error::Internal(format!("drawing {id}: {e}")))?.into();
        Ok(Thumbnail { bytes, media_type: "image/png", source })
    }
}

/// What a picture needs of the head of a playback (docs/formats/playback.md).
#[derive(Deserialize)]
struct Head {
    sequences: Vec<Sequence>,
}

#[derive(Deserialize)]
struct Sequence {
    motion: Motion,
    cameras: Vec<Camera>,
}

#[derive(Deserialize)]
struct Motion {
    point_count: u64,
    origin: [f64; 3],
    scale_m: f64,
    points: [u64; 2],
    colors: Option<[u64; 2]>,
}

#[derive(Deserialize)]
struct Camera {
    images: Images,
}

#[derive(Deserialize)]
struct Images {
    lengths: Vec<u64>,
    bytes: [u64; 2],
}

impl Sequence {
    /// Place of the first recorded image of the first camera that has one.
    fn first_image(&self) -> Option<[u64; 2]> {
        self.cameras.iter().find_map(|Camera { images }| {
            // Images that were not recorded take no bytes.
            let length = images.lengths.iter().find(|length| **length > 0)?;
            Some([images.bytes[0], *length])
        })
    }
}

impl Motion {
    /// Points of the first frame [m]; those that are unknown are not finite.
    fn positions(&self, bytes: &[u8]) -> Vec<Point> {
        let points = bytes.as_chunks::<6>().0.iter();
        let number =
            |bytes: &[u8; 6], k: usize| i16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]);
        let place = |bytes: &[u8; 6], k: usize| match number(bytes, k) {
            UNKNOWN => f32::NAN,
            number => (self.origin[k] + self.scale_m * f64::from(number)) as f32,
        };
        points.map(|bytes| [0, 1, 2].map(|k| place(bytes, k))).collect()
    }
}

#[cfg(test)]
mod tests;
