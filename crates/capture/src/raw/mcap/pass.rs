//! The pass over the files that finds where their images lie.

use std::{borrow::Cow, collections::BTreeMap};

use mcap::{MAGIC, records::op};

use super::{
    chunk::{Chunk, Compression, MAX_CHUNK},
    index::{Index, Stamped, Topic},
    messages::{self, ImageHead, Kind, Wire},
    place::{Part, Place, is_packed, unpacked, unpacked_start},
    record::{Fields, PREFIX, Record, Region},
    zstd,
};
use crate::{
    Error, Limits,
    files::{MAX_DOCUMENT, at_most, unmark},
    raw::{gripper, stored::MAX_MESH},
};

/// Bytes of a message that is no image.
const MAX_MESSAGE: u64 = 4 << 20;
/// Bytes of a message before its content: channel, number, two times.
const MESSAGE_HEAD: u64 = 22;
/// Channels that are read.
const MAX_CHANNELS: usize = 4096;

/// Use of the messages of a channel.
enum Role {
    Images { topic: usize },
    Calibration { topic: String, wire: Wire },
    Transforms { kind: Kind, wire: Wire, fixed: bool },
    Joints { topic: String, wire: Wire },
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

/// A pass over all files. Schemas and channels are those of the current one.
pub(super) struct Pass<'a> {
    limits: &'a Limits,
    number: u32,
    part: &'a Part,
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Option<Role>>,
    image_count: usize,
    /// Bytes of all files, and what was unpacked of them.
    length: u64,
    unpacked: u64,
    pub(super) index: Index,
}

impl<'a> Pass<'a> {
    /// A pass over these files, of which there must be one.
    pub(super) fn new(parts: &'a [Part], limits: &'a Limits) -> Self {
        Self {
            limits,
            number: 0,
            part: &parts[0],
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            image_count: 0,
            length: parts.iter().map(Part::len).fold(0, u64::saturating_add),
            unpacked: 0,
            index: Index::default(),
        }
    }

    /// Reads a file.
    pub(super) fn file(&mut self, number: u32, part: &'a Part) -> Result<(), Error> {
        (self.number, self.part) = (number, part);
        self.schemas.clear();
        self.channels.clear();
        let start = part.read(0, part.len().min(MAGIC.len() as u64))?;
        if start != MAGIC {
            return Err(part.damaged("it is no MCAP file"));
        }
        let region = Region::File { start: MAGIC.len() as u64, end: part.len() };
        let ended = self.walk(region, Within::File)?;
        if !ended {
            return Err(part.damaged(
                "it ends before its data does, as when a recorder is killed: repair it with `mcap recover`",
            ));
        }
        Ok(())
    }

    /// Visits every record; whether the end of the data was among them. Chunks lie in the file and
    /// not in each other.
    fn walk(&mut self, region: Region<'_>, within: Within) -> Result<bool, Error> {
        let mut at = region.start();
        while let Some(record) = region.record(self.part, at)? {
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
        let part = self.part;
        let chunk = Chunk::parse(&record.prefix, record.start, record.length)
            .map_err(|fault| part.damaged(fault))?;
        if chunk.compression == Compression::None {
            let region = Region::File { start: chunk.start, end: chunk.start + chunk.length };
            return self.walk(region, Within::Plain).map(|_| ());
        }
        let what = || format!("a chunk of `{}`", part.name);
        for bytes in [chunk.unpacked, chunk.length] {
            if bytes > MAX_CHUNK {
                return Err(Error::TooLarge { what: what(), bytes, limit: MAX_CHUNK });
            }
        }
        self.charge(chunk.unpacked)?;
        let number = u32::try_from(self.index.chunks.len()).unwrap_or(u32::MAX);
        self.index.chunks.push(chunk);
        let bytes = part.unpack(&chunk)?;
        self.walk(Region::Memory(&bytes), Within::Compressed(number)).map(|_| ())
    }

    /// Counts bytes that are unpacked. Over all files, because many small bombs cost as much as a
    /// large one.
    fn charge(&mut self, bytes: u64) -> Result<(), Error> {
        self.unpacked = self.unpacked.saturating_add(bytes);
        let limit = self.limits.compression_ratio;
        let most = self.length.saturating_mul(limit).max(self.limits.ratio_from_bytes);
        if self.unpacked > most {
            let ratio = self.unpacked / self.length.max(1);
            return Err(Error::ArchiveRatio { at: self.part.name.clone(), ratio, limit });
        }
        Ok(())
    }

    fn schema(&mut self, record: &Record<'_>) -> Result<(), Error> {
        let mut fields = Fields(&record.prefix);
        let parsed = fields.u16().zip(fields.text());
        let (id, name) =
            parsed.ok_or_else(|| self.part.damaged("the name of a schema is cut off"))?;
        self.schemas.insert(id, name);
        Ok(())
    }

    fn channel(&mut self, record: &Record<'_>) -> Result<(), Error> {
        let mut fields = Fields(&record.prefix);
        let mut parse = || Some((fields.u16()?, fields.u16()?, fields.text()?, fields.text()?));
        let (id, schema, name, encoding) =
            parse().ok_or_else(|| self.part.damaged("the description of a channel is cut off"))?;
        // Chunks repeat the channels that they use.
        if self.channels.contains_key(&id) {
            return Ok(());
        }
        at_most("channels", self.channels.len() + 1, MAX_CHANNELS)?;
        let schema = self.schemas.get(&schema).map_or("", String::as_str);
        let role = match messages::kind_of(schema, &encoding) {
            None => {
                if let Some(what) = messages::unread(schema, &encoding) {
                    self.index.unread.insert(name, what);
                    at_most("topics", self.index.unread.len(), MAX_CHANNELS)?;
                }
                None
            }
            Some((kind @ (Kind::Image | Kind::CompressedImage), wire)) => {
                Some(Role::Images { topic: self.topic(name, kind, wire)? })
            }
            Some((Kind::Calibration, wire)) => Some(Role::Calibration { topic: name, wire }),
            Some((Kind::Joints, wire)) => Some(Role::Joints { topic: name, wire }),
            Some((kind @ (Kind::Transform | Kind::Transforms), wire)) => {
                let fixed = name.ends_with("tf_static");
                Some(Role::Transforms { kind, wire, fixed })
            }
        };
        self.channels.insert(id, role);
        Ok(())
    }

    /// The topic of a name; several channels may feed it.
    fn topic(&mut self, name: String, kind: Kind, wire: Wire) -> Result<usize, Error> {
        let topics = &mut self.index.topics;
        let same = |t: &Topic| t.name == name && t.kind == kind && t.wire == wire;
        if let Some(index) = topics.iter().position(same) {
            return Ok(index);
        }
        // Those of all files together.
        at_most("topics", topics.len() + 1, MAX_CHANNELS)?;
        let head = ImageHead::default();
        topics.push(Topic { name, kind, wire, head, images: Vec::new() });
        Ok(topics.len() - 1)
    }

    fn message(
        &mut self,
        record: &Record<'_>,
        region: Region<'_>,
        within: Within,
    ) -> Result<(), Error> {
        let part = self.part;
        let mut fields = Fields(&record.prefix);
        let mut parse = || Some((fields.u16()?, fields.u32()?, fields.u64()?, fields.u64()?));
        let (channel, _, log_time, _) =
            parse().ok_or_else(|| part.damaged("the head of a message is cut off"))?;
        let message = Message {
            place: Place {
                part: self.number,
                chunk: if let Within::Compressed(number) = within { Some(number) } else { None },
                start: record.start + MESSAGE_HEAD,
                length: record.length.saturating_sub(MESSAGE_HEAD),
            },
            start: fields.0,
            region,
        };
        let log_ns = i64::try_from(log_time).unwrap_or(i64::MAX);
        match self.channels.get(&channel) {
            Some(&Some(Role::Images { topic })) => self.image(topic, &message, log_ns),
            Some(Some(Role::Calibration { topic, wire })) => {
                if self.index.calibrations.contains_key(topic) {
                    return Ok(());
                }
                let (topic, wire) = (topic.clone(), *wire);
                let bytes = self.whole(wire, &message, MAX_MESSAGE)?;
                let calibration = messages::calibration(wire, &bytes)
                    .ok_or_else(|| part.wrong_message(&topic))?;
                self.index.calibrations.insert(topic, calibration);
                at_most("topics", self.index.calibrations.len(), MAX_CHANNELS)?;
                Ok(())
            }
            Some(&Some(Role::Transforms { kind, wire, fixed })) => {
                let bytes = self.whole(wire, &message, MAX_MESSAGE)?;
                let all = messages::transforms(kind, wire, &bytes)
                    .ok_or_else(|| part.wrong_message("tf"))?;
                for transform in all {
                    self.index.tree.add(transform, fixed)?;
                }
                Ok(())
            }
            Some(Some(Role::Joints { topic, wire })) => {
                let (topic, wire) = (topic.clone(), *wire);
                let bytes = self.whole(wire, &message, MAX_MESSAGE)?;
                // Most recordings need no joints, so damage among them is no reason to refuse one.
                if let Some(joints) = messages::joints(wire, &bytes) {
                    self.index.joints.add(&topic, joints, log_ns);
                }
                Ok(())
            }
            Some(None) | None => Ok(()),
        }
    }

    fn image(&mut self, topic: usize, message: &Message<'_>, log_ns: i64) -> Result<(), Error> {
        self.image_count += 1;
        let most = self.limits.recording_frames.saturating_mul(self.limits.cameras);
        at_most("images", self.image_count, most)?;
        let Some(&Topic { kind, wire, .. }) = self.index.topics.get(topic) else { return Ok(()) };
        let head = self.image_head(kind, wire, message)?;
        let Some(topic) = self.index.topics.get_mut(topic) else { return Ok(()) };
        let head = head.ok_or_else(|| self.part.wrong_message(&topic.name))?;
        let ns = if head.stamp_ns == 0 { log_ns } else { head.stamp_ns };
        if topic.images.is_empty() {
            topic.head = head;
        }
        topic.images.push(Stamped { ns, log_ns, place: message.place });
        Ok(())
    }

    /// The head of an image, from as little of its message as holds it.
    fn image_head(
        &mut self,
        kind: Kind,
        wire: Wire,
        message: &Message<'_>,
    ) -> Result<Option<ImageHead>, Error> {
        if wire == Wire::Protobuf {
            // Its fields come in any order.
            return Ok(messages::image_head(kind, wire, &self.whole(wire, message, MAX_CHUNK)?));
        }
        if !is_packed(wire, message.start) {
            return Ok(messages::image_head(kind, wire, message.start));
        }
        let packed = self.packed(message, MAX_CHUNK)?;
        let start = unpacked_start(&packed, PREFIX).map_err(|fault| self.part.damaged(fault))?;
        Ok(messages::image_head(kind, wire, &start))
    }

    /// The content of a message, unpacked if it was compressed by itself, of at most `cap` bytes.
    fn whole<'m>(
        &mut self,
        wire: Wire,
        message: &Message<'m>,
        cap: u64,
    ) -> Result<Cow<'m, [u8]>, Error> {
        if !is_packed(wire, message.start) {
            return message.read(self.part, cap);
        }
        let packed = self.packed(message, cap)?;
        unpacked(&packed, cap).map(Cow::Owned).map_err(|fault| self.part.damaged(fault))
    }

    /// The bytes of a compressed message, after those that it unpacks to were counted.
    fn packed<'m>(&mut self, message: &Message<'m>, cap: u64) -> Result<Cow<'m, [u8]>, Error> {
        self.charge(zstd::announced(message.start))?;
        message.read(self.part, cap)
    }

    fn metadata(&mut self, record: &Record<'_>, region: Region<'_>) -> Result<(), Error> {
        let mut fields = Fields(&record.prefix);
        if fields.text().as_deref() != Some("bendtwin") || record.length > MAX_MESSAGE {
            return Ok(());
        }
        let bytes = region.read(self.part, record.start, record.length)?;
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
        let is_mesh =
            self.index.mesh.is_none() && ["glb", "obj", "ply"].contains(&extension.as_str());
        let is_grippers = self.index.grippers.is_none() && name == gripper::DOCUMENT;
        if !is_mesh && !is_grippers {
            return Ok(());
        }
        if length > record.length.saturating_sub(head) {
            return Err(self.part.damaged(format!("the attachment `{name}` is cut off")));
        }
        let limit = if is_mesh { MAX_MESH } else { MAX_DOCUMENT };
        if length > limit {
            let what = format!("the attachment `{name}`");
            return Err(Error::TooLarge { what, bytes: length, limit });
        }
        let mut bytes = region.read(self.part, record.start + head, length)?.into_owned();
        if is_mesh {
            self.index.mesh = Some((name, bytes));
        } else {
            unmark(&name, &mut bytes)?;
            self.index.grippers = Some(bytes);
        }
        Ok(())
    }
}

/// A message among the records of a region.
struct Message<'a> {
    place: Place,
    /// First bytes of its content.
    start: &'a [u8],
    region: Region<'a>,
}

impl<'a> Message<'a> {
    /// Stored content, of at most `cap` bytes.
    fn read(&self, part: &Part, cap: u64) -> Result<Cow<'a, [u8]>, Error> {
        if self.place.length > cap {
            let what = format!("a message in `{}`", part.name);
            return Err(Error::TooLarge { what, bytes: self.place.length, limit: cap });
        }
        self.region.read(part, self.place.start, self.place.length)
    }
}
