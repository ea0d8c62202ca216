//! Playback: what a person is shown of a capture, in one file that a browser reads by ranges. The
//! tracked points and control points of the observation as 16-bit numbers, and small images of the
//! cameras, thinned until all fits into a bound. `docs/formats/playback.md` specifies the format.

mod head;
mod images;
mod motion;

use std::{fs::File, io, io::Write as _, path::Path};

use bendtwin_capture::raw::Recording;
use bendtwin_core::{Capture, Sequence, capture_files::PLAYBACK_MAGIC};

use self::{
    head::{
        CameraEntry, FORMAT, GroundEntry, Head, ImagesEntry, MotionEntry, Range, SequenceEntry,
        VERSION, short,
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

/// Writes the playback of a capture to a new file. `recorded` are the recordings of cameras that its
/// recordings were lifted from or lie beside, in their order; `tell` gets the share that is done, 0..=1.
///
/// Images that cannot be read are left out.
///
/// # Errors
/// If the file cannot be written.
pub fn write_playback(
    capture: &Capture,
    recorded: &[Option<Recording>],
    path: &Path,
    tell: &mut dyn FnMut(f64),
) -> io::Result<()> {
    let mut data = Data::default();
    let plan = Plan::new(capture);
    let mut head = Head {
        format: FORMAT,
        version: VERSION,
        name: short(&capture.name),
        sequences: Vec::with_capacity(plan.sequences),
        left_out: 0,
    };
    let with_images = recorded.iter().flatten().count().max(1);
    let mut filmed = 0;
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
                let mut share = |done: f64| tell((f64::from(filmed) + done) / with_images as f64);
                let budget = IMAGE_BYTES / with_images;
                let images = collect(source, budget, with_images, &mut share);
                entry.cameras = cameras(source, images, &mut data);
                filmed += 1;
            }
            head.sequences.push(entry);
        }
    }
    write(&head, data, path)?;
    tell(1.0);
    Ok(())
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
        ground: recording
            .environment
            .ground
            .map(|plane| GroundEntry { normal: plane.normal, offset_m: plane.offset_m }),
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

fn cameras(recording: &Recording, images: images::Images, data: &mut Data) -> Vec<CameraEntry> {
    let every = images.every;
    let pairs = recording.cameras.iter().zip(images.files);
    pairs
        .map(|(camera, files)| {
            // One that stands has one pose.
            let images = if camera.poses.len() > 1 { files.len() } else { 1 };
            let rows = (0..images).flat_map(|image| {
                let pose = camera.pose(image * every);
                (0..3).flat_map(|i| {
                    let [a, b, c] = pose.rotation[i];
                    [a, b, c, pose.translation[i]]
                })
            });
            let poses = data.add(rows.flat_map(|x| (x as f32).to_le_bytes()).collect());
            let lengths = files.iter().map(Vec::len).collect();
            let first = data.bytes;
            for file in files {
                data.add(file);
            }
            let images = ImagesEntry {
                size: small_size(camera.width, camera.height),
                every,
                lengths,
                bytes: [first, data.bytes - first],
            };
            CameraEntry::new(camera, poses, images)
        })
        .collect()
}

#[cfg(test)]
mod tests;
