//! Playback: what a person is shown of a capture, in one file that a browser reads by ranges. The
//! tracked points and control points of the observation as 16-bit numbers, and small images of the
//! cameras, thinned until all fits into a bound. `docs/formats/playback.md` specifies the format.

mod head;
mod images;
mod labels;
mod motion;

use std::{fs::File, io, io::Write as _, path::Path};

use bendtwin_capture::raw::Recording;
use bendtwin_core::{Capture, Environment, Plane, Sequence, capture_files::PLAYBACK_MAGIC};

use self::{
    head::{
        CameraEntry, FORMAT, GroundEntry, Head, ImagesEntry, MasksEntry, MotionEntry, Range,
        SequenceEntry, VERSION, short,
    },
    images::{collect, small_size},
    motion::Grid,
};

/// Most points of a sequence, and most control points.
const MAX_POINTS: usize = 4_096;
/// Most bytes of all points and control points.
const MOTION_BYTES: usize = 14 << 20;
/// Most bytes of all images.
const IMAGE_BYTES: usize = 32 << 20;
/// Bytes of the head are a multiple of it, so that numbers lie well.
const ALIGNMENT: usize = 8;

/// Content of a playback.
#[derive(Clone, Copy, Debug)]
pub struct Played<'a> {
    /// Name of the capture.
    pub name: &'a str,
    /// The points; none before they are lifted, or where they cannot be.
    pub capture: Option<&'a Capture>,
    /// The recordings of cameras that the capture's recordings were lifted from or lie beside, in their
    /// order.
    pub recorded: &'a [Option<Recording>],
    /// Doubt of masks that were made from strokes in the first recording, shape [camera, frame].
    pub doubt: &'a [Vec<Option<f32>>],
}

/// Writes the playback of a capture to a new file; `tell` gets the share that is done, 0..=1.
///
/// Images that cannot be read are left out.
///
/// # Errors
/// If the file cannot be written.
pub fn write_playback(
    played: Played<'_>,
    path: &Path,
    tell: &mut dyn FnMut(f64),
) -> io::Result<()> {
    let Played { name, capture, recorded, doubt } = played;
    let mut data = Data::default();
    let mut head = Head {
        format: FORMAT,
        version: VERSION,
        name: short(name),
        sequences: Vec::new(),
        left_out: 0,
    };
    let mut filming = Filming {
        recordings: recorded.iter().flatten().count().max(1),
        filmed: 0,
        doubt,
        tell: &mut *tell,
    };
    let Some(capture) = capture else {
        for (index, source) in recorded.iter().enumerate() {
            let Some(source) = source else { continue };
            let mut entry = entry_without_points(source, index);
            entry.cameras = filming.cameras(source, &mut data);
            head.sequences.push(entry);
        }
        write(&head, data, path)?;
        tell(1.0);
        return Ok(());
    };
    let plan = Plan::new(capture);
    for (index, recording) in capture.recordings().enumerate() {
        let mut source = recorded.get(index).and_then(Option::as_ref);
        for sequence in &recording.sequences {
            if head.sequences.len() == plan.sequences {
                head.left_out += 1;
                continue;
            }
            let mut entry = sequence_entry(recording, index, sequence, plan.most, &mut data);
            // A recording of cameras has one sequence.
            if let Some(source) = source.take() {
                entry.cameras = filming.cameras(source, &mut data);
            }
            head.sequences.push(entry);
        }
    }
    write(&head, data, path)?;
    tell(1.0);
    Ok(())
}

/// Adds the images of recordings, one after another.
struct Filming<'a> {
    /// Number of recordings that share the space.
    recordings: usize,
    /// Number of those that are done.
    filmed: usize,
    /// Doubt of the masks of the first one, shape [camera, frame].
    doubt: &'a [Vec<Option<f32>>],
    tell: &'a mut dyn FnMut(f64),
}

impl Filming<'_> {
    fn cameras(&mut self, source: &Recording, data: &mut Data) -> Vec<CameraEntry> {
        let (filmed, recordings) = (self.filmed, self.recordings);
        let mut share = |done: f64| (self.tell)((filmed as f64 + done) / recordings as f64);
        let images = collect(source, IMAGE_BYTES / recordings, recordings, &mut share);
        let doubt = if filmed == 0 { self.doubt } else { &[] };
        self.filmed += 1;
        cameras(source, images, doubt, data)
    }
}

fn write(head: &Head, data: Data, path: &Path) -> io::Result<()> {
    let mut json = serde_json::to_vec(head)?;
    json.resize(json.len().next_multiple_of(ALIGNMENT), b' ');
    let length = u32::try_from(json.len()).map_err(io::Error::other)?;
    let mut file = io::BufWriter::new(File::create_new(path)?);
    file.write_all(PLAYBACK_MAGIC)?;
    file.write_all(&VERSION.to_le_bytes())?;
    file.write_all(&length.to_le_bytes())?;
    file.write_all(&json)?;
    data.parts.iter().try_for_each(|part| file.write_all(part))?;
    file.flush()
}

/// The sequences that fit, and the number of points of each.
#[derive(Debug, PartialEq)]
struct Plan {
    sequences: usize,
    most: usize,
}

impl Plan {
    /// The selection that fits: fewer points of all sequences alike, then fewer sequences.
    fn new(capture: &Capture) -> Self {
        let sizes = |most: usize| {
            capture.recordings().flat_map(move |r| {
                r.sequences.iter().map(move |s| motion::bytes(s, r.object.point_count, most))
            })
        };
        let total = |most| sizes(most).fold(0, usize::saturating_add);
        let mut most = MAX_POINTS;
        while most > 1 && total(most) > MOTION_BYTES {
            most = most * 3 / 4;
        }
        let mut room = MOTION_BYTES;
        let fits = |size: &usize| {
            let fits = *size <= room;
            room = room.saturating_sub(*size);
            fits
        };
        Self { sequences: sizes(most).take_while(fits).count(), most }
    }
}

/// The data of a playback.
#[derive(Default)]
struct Data {
    parts: Vec<Vec<u8>>,
    bytes: u64,
}

impl Data {
    fn add(&mut self, part: Vec<u8>) -> Range {
        let range = [self.bytes, part.len() as u64];
        self.bytes += range[1];
        self.parts.push(part);
        range
    }

    /// Adds parts one behind the other: the length of each, and the range of all.
    fn add_all(&mut self, parts: Vec<Vec<u8>>) -> (Vec<usize>, Range) {
        let first = self.bytes;
        let lengths = parts.iter().map(Vec::len).collect();
        for part in parts {
            self.add(part);
        }
        (lengths, [first, self.bytes - first])
    }
}

fn sequence_entry(
    recording: &Capture,
    index: usize,
    sequence: &Sequence,
    most: usize,
    data: &mut Data,
) -> SequenceEntry {
    let object = &recording.object;
    let frames = sequence.frame_count;
    let points = motion::thinned(object.point_count, most);
    let controls = motion::thinned(sequence.control_count(), most);
    let grid = Grid::around(sequence.points.iter().chain(&sequence.controls));
    let hands = controls.iter().filter_map(|&c| object.control_hands.get(c).copied()).collect();
    let colors = (!object.colors.is_empty()).then(|| motion::colors(&object.colors, &points));
    SequenceEntry {
        recording: index,
        recording_name: short(&recording.name),
        name: short(&sequence.name),
        fps: recording.fps,
        frame_count: frames,
        train_frame_count: sequence.train_frame_count,
        start_frame: sequence.start_frame(),
        ground: ground(recording.environment),
        observed_points: object.point_count,
        motion: MotionEntry {
            point_count: points.len(),
            control_count: controls.len(),
            origin: grid.origin,
            scale_m: grid.scale_m,
            points: data.add(grid.numbers(&sequence.points, frames, &points)),
            visible: data.add(motion::bits(&sequence.visible, frames, &points)),
            controls: data.add(grid.numbers(&sequence.controls, frames, &controls)),
            control_hands: hands,
            colors: colors.map(|colors| data.add(colors)),
        },
        cameras: Vec::new(),
    }
}

/// A recording without points.
fn entry_without_points(recording: &Recording, index: usize) -> SequenceEntry {
    SequenceEntry {
        recording: index,
        recording_name: short(&recording.name),
        name: String::new(),
        fps: recording.fps,
        frame_count: recording.frame_count,
        train_frame_count: recording.train_frame_count,
        start_frame: 0,
        ground: ground(recording.environment),
        observed_points: 0,
        motion: MotionEntry {
            point_count: 0,
            control_count: 0,
            origin: [0.0; 3],
            scale_m: 1.0,
            points: [0; 2],
            visible: [0; 2],
            controls: [0; 2],
            control_hands: Vec::new(),
            colors: None,
        },
        cameras: Vec::new(),
    }
}

fn ground(environment: Environment) -> Option<GroundEntry> {
    let entry = |plane: Plane| GroundEntry { normal: plane.normal, offset_m: plane.offset_m };
    environment.ground.map(entry)
}

fn cameras(
    recording: &Recording,
    images: images::Images,
    doubt: &[Vec<Option<f32>>],
    data: &mut Data,
) -> Vec<CameraEntry> {
    let every = images.every;
    let each = recording.cameras.iter().zip(images.files).enumerate();
    each.map(|(index, (camera, files))| {
        // One that stands has one pose; one that was not calibrated has none.
        let images = if camera.poses.len() > 1 { files.len() } else { camera.poses.len() };
        let rows = (0..images).flat_map(|image| {
            let pose = camera.pose(image * every);
            (0..3).flat_map(|i| {
                let [a, b, c] = pose.rotation[i];
                [a, b, c, pose.translation[i]]
            })
        });
        let poses = data.add(rows.flat_map(|x| (x as f32).to_le_bytes()).collect());
        let (jpegs, labels): (Vec<_>, Vec<_>) =
            files.into_iter().map(|file| (file.jpeg, file.labels)).unzip();
        let (lengths, bytes) = data.add_all(jpegs);
        let size = small_size(camera.width, camera.height);
        let images = ImagesEntry { size, every, lengths, bytes };
        let masks = labels.iter().any(|runs| !runs.is_empty()).then(|| {
            let (lengths, bytes) = data.add_all(labels);
            MasksEntry { lengths, bytes }
        });
        CameraEntry::new(camera, poses, images, masks, doubt.get(index).cloned())
    })
    .collect()
}

#[cfg(test)]
mod tests;
