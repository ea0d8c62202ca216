//! The pass over the file that finds where its images lie.

use std::collections::BTreeMap;

use mcap::{MAGIC, records::op};

use super::{
    chunk::{Chunk, Compression, MAX_CHUNK},
    messages::{self, Calibration, ImageHead, Kind, Wire},
    place::{Place, Store},
    record::{Fields, Record, Region},
    transforms::Tree,
};
use crate::{Error, Limits, files::at_most, raw::stored::MAX_MESH};

/// Bytes of a message that is no image.
const MAX_MESSAGE: u64 = 4 << 20;
/// Bytes of a message before its content: channel, number, two times.
const MESSAGE_HEAD: u64 = 22;
/// Channels that are read.
const MAX_CHANNELS: usize = 4096;

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
    pub(super) place: Place,
}

/// Content of a file.
#[derive(Debug, Default)]
pub(super) struct Index {
    /// Compressed chunks by their numbers.
    pub(super) chunks: Vec<Chunk>,
    pub(super) topics: Vec<Topic>,
    /// The first calibration of each topic.
    pub(super) calibrations: BTreeMap<String, Calibration>,
    pub(super) tree: Tree,
    /// Content of the metadata record `bendtwin`.
    pub(super) settings: BTreeMap<String, String>,
    /// The first attached mesh.
    pub(super) mesh: Option<(String, Vec<u8>)>,
}

/// Use of the messages of a channel.
enum Role {
    Images { topic: usize },
    Calibration { topic: String, wire: Wire },
    Transforms { kind: Kind, wire: Wire, fixed: bool },
}

/// Place of a record.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Within {
    File,
    /// A chunk that is not compressed.
    Plain,
    /// A compressed chunk, by its number.
    Compressed(u32),
}

struct Pass<'a> {
    store: &'a Store,
    limits: &'a Limits,
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Option<Role>>,
    image_count: usize,
    unpacked: u64,
    index: Index,
}

impl Index {
    pub(super) fn read(store: &mut Store, limits: &Limits) -> Result<Self, Error> {
        if store.read(0, MAGIC.len() as u64)? != MAGIC {
            return Err(store.damaged("it is no MCAP file"));
        }
        let mut pass = Pass {
            store,
            limits,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            image_count: 0,
            unpacked: 0,
            index: Self::default(),
        };
        let region = Region::File { start: MAGIC.len() as u64, end: store.len() };
        let ended = pass.walk(region, Within::File)?;
        if !ended {
            return Err(store.damaged(
                "it ends before its data does, as when a recorder is killed: repair it with `mcap recover`",
            ));
        }
        let mut index = pass.index;
        for topic in &mut index.topics {
            topic.images.sort_by_key(|image| image.ns);
        }
        index.topics.retain(|topic| !topic.images.is_empty());
        index.tree.sort();
        Ok(index)
    }
}

impl Pass<'_> {
    /// Visits every record; whether the end of the data was among them. Chunks lie in the file and
    /// not in each other.
    fn walk(&mut self, region: Region<'_>, within: Within) -> Result<bool, Error> {
        let mut at = region.start();
        while let Some(record) = region.record(self.store, at)? {
            at = record.end();
            match record.opcode {
                op::DATA_END => return Ok(true),
                op::CHUNK if within == Within::File => self.chunk(&record)?,
                op::SCHEMA => self.schema(&record)?,
                op::CHANNEL => self.channel(&record)?,
                op::MESSAGE => self.message(&record, region, within)?,
                op::METADATA => self.metadata(&record, region)?,
                op::ATTACHMENT => self.attachment(&record, region)?,
                _ => {}
            }
        }
        Ok(false)
    }

    fn chunk(&mut self, record: &Record<'_>) -> Result<(), Error> {
        let store = self.store;
        let chunk = Chunk::parse(&record.prefix, record.start, record.length)
            .map_err(|fault| store.damaged(fault))?;
        if chunk.compression == Compression::None {
            let region = Region::File { start: chunk.start, end: chunk.start + chunk.length };
            return self.walk(region, Within::Plain).map(|_| ());
        }
        let what = || format!("a chunk of `{}`", store.name());
        for bytes in [chunk.unpacked, chunk.length] {
            if bytes > MAX_CHUNK {
                return Err(Error::TooLarge { what: what(), bytes, limit: MAX_CHUNK });
            }
        }
        self.unpacked = self.unpacked.saturating_add(chunk.unpacked);
        // Over the whole file, because many small chunks cost as much as a large one.
        let limit = self.limits.compression_ratio;
        let most = store.len().saturating_mul(limit).max(self.limits.ratio_from_bytes);
        if self.unpacked > most {
            let ratio = self.unpacked / store.len().max(1);
            return Err(Error::ArchiveRatio { at: store.name().to_owned(), ratio, limit });
        }
        let number = u32::try_from(self.index.chunks.len()).unwrap_or(u32::MAX);
        self.index.chunks.push(chunk);
        let bytes = store.unpack(&chunk)?;
        self.walk(Region::Memory(&bytes), Within::Compressed(number)).map(|_| ())
    }

    fn schema(&mut self, record: &Record<'_>) -> Result<(), Error> {
        let mut fields = Fields(&record.prefix);
        let parsed = fields.u16().zip(fields.text());
        let (id, name) =
            parsed.ok_or_else(|| self.store.damaged("the name of a schema is cut off"))?;
        self.schemas.insert(id, name);
        Ok(())
    }

    fn channel(&mut self, record: &Record<'_>) -> Result<(), Error> {
        let mut fields = Fields(&record.prefix);
        let mut parse = || Some((fields.u16()?, fields.u16()?, fields.text()?, fields.text()?));
        let (id, schema, name, encoding) =
            parse().ok_or_else(|| self.store.damaged("the description of a channel is cut off"))?;
        // Chunks repeat the channels that they use.
        if self.channels.contains_key(&id) {
            return Ok(());
        }
        at_most("channels", self.channels.len() + 1, MAX_CHANNELS)?;
        let schema = self.schemas.get(&schema).map_or("", String::as_str);
        let role = messages::kind_of(schema, &encoding).map(|(kind, wire)| match kind {
            Kind::Image | Kind::CompressedImage => {
                Role::Images { topic: self.topic(name, kind, wire) }
            }
            Kind::Calibration => Role::Calibration { topic: name, wire },
            Kind::Transform | Kind::Transforms => {
                Role::Transforms { kind, wire, fixed: name.ends_with("tf_static") }
            }
        });
        self.channels.insert(id, role);
        Ok(())
    }

    /// The topic of a name; several channels may feed it.
    fn topic(&mut self, name: String, kind: Kind, wire: Wire) -> usize {
        let topics = &mut self.index.topics;
        let same = |t: &Topic| t.name == name && t.kind == kind && t.wire == wire;
        if let Some(index) = topics.iter().position(same) {
            return index;
        }
        let head = ImageHead::default();
        topics.push(Topic { name, kind, wire, head, images: Vec::new() });
        topics.len() - 1
    }

    fn message(
        &mut self,
        record: &Record<'_>,
        region: Region<'_>,
        within: Within,
    ) -> Result<(), Error> {
        let store = self.store;
        let mut fields = Fields(&record.prefix);
        let mut parse = || Some((fields.u16()?, fields.u32()?, fields.u64()?, fields.u64()?));
        let (channel, _, log_time, _) =
            parse().ok_or_else(|| store.damaged("the head of a message is cut off"))?;
        let place = Place {
            chunk: if let Within::Compressed(number) = within { Some(number) } else { None },
            start: record.start + MESSAGE_HEAD,
            length: record.length.saturating_sub(MESSAGE_HEAD),
        };
        let Some(Some(role)) = self.channels.get(&channel) else { return Ok(()) };
        let whole = |cap: u64| {
            if place.length > cap {
                let what = format!("a message in `{}`", store.name());
                return Err(Error::TooLarge { what, bytes: place.length, limit: cap });
            }
            region.read(store, place.start, place.length)
        };
        let wrong = |topic: &str| {
            store.damaged(format!("a message of `{topic}` is not as its schema says"))
        };
        match role {
            Role::Images { topic } => {
                self.image_count += 1;
                let most = self.limits.recording_frames.saturating_mul(self.limits.cameras);
                at_most("images", self.image_count, most)?;
                let Some(topic) = self.index.topics.get_mut(*topic) else { return Ok(()) };
                let head = if topic.wire == Wire::Protobuf {
                    // Its fields come in any order.
                    messages::image_head(topic.kind, topic.wire, &whole(MAX_CHUNK)?)
                } else {
                    messages::image_head(topic.kind, topic.wire, fields.0)
                };
                let head = head.ok_or_else(|| wrong(&topic.name))?;
                let ns = if head.stamp_ns == 0 {
                    i64::try_from(log_time).unwrap_or(i64::MAX)
                } else {
                    head.stamp_ns
                };
                if topic.images.is_empty() {
                    topic.head = head;
                }
                topic.images.push(Stamped { ns, place });
            }
            Role::Calibration { topic, wire } => {
                if !self.index.calibrations.contains_key(topic) {
                    let bytes = whole(MAX_MESSAGE)?;
                    let calibration =
                        messages::calibration(*wire, &bytes).ok_or_else(|| wrong(topic))?;
                    self.index.calibrations.insert(topic.clone(), calibration);
                }
            }
            Role::Transforms { kind, wire, fixed } => {
                let bytes = whole(MAX_MESSAGE)?;
                let all = messages::transforms(*kind, *wire, &bytes).ok_or_else(|| wrong("tf"))?;
                for transform in all {
                    self.index.tree.add(transform, *fixed)?;
                }
            }
        }
        Ok(())
    }

    fn metadata(&mut self, record: &Record<'_>, region: Region<'_>) -> Result<(), Error> {
        let mut fields = Fields(&record.prefix);
        if fields.text().as_deref() != Some("bendtwin") || record.length > MAX_MESSAGE {
            return Ok(());
        }
        let bytes = region.read(self.store, record.start, record.length)?;
        let mut fields = Fields(&bytes);
        fields.text();
        fields.u32();
        while let Some((key, value)) = fields.text().and_then(|key| Some((key, fields.text()?))) {
            self.index.settings.insert(key, value);
        }
        Ok(())
    }

    fn attachment(&mut self, record: &Record<'_>, region: Region<'_>) -> Result<(), Error> {
        let mut fields = Fields(&record.prefix);
        let mut parse = || {
            fields.take(16)?;
            let (name, _kind, length) = (fields.text()?, fields.text()?, fields.u64()?);
            Some((name, length, (record.prefix.len() - fields.0.len()) as u64))
        };
        let Some((name, length, head)) = parse() else { return Ok(()) };
        let extension = name.rsplit_once('.').map_or("", |(_, e)| e).to_lowercase();
        if self.index.mesh.is_some() || !["glb", "obj", "ply"].contains(&extension.as_str()) {
            return Ok(());
        }
        if length > record.length.saturating_sub(head) {
            return Err(self.store.damaged(format!("the attachment `{name}` is cut off")));
        }
        if length > MAX_MESH {
            let what = format!("the attachment `{name}`");
            return Err(Error::TooLarge { what, bytes: length, limit: MAX_MESH });
        }
        let bytes = region.read(self.store, record.start + head, length)?;
        self.index.mesh = Some((name, bytes.into_owned()));
        Ok(())
    }
}
