//! Recordings of cameras: archives of images, MCAP files, and the compression of their chunks.

use std::io::Write as _;

use bendtwin_capture::raw::{self, Recording, Region};
use bendtwin_hostile::{
    messages,
    recordings::{chunk, of_chunk},
};
use tempfile::NamedTempFile;

use crate::limits;

/// Frames of each camera that are decoded.
const FRAMES: usize = 3;

/// An MCAP file.
pub fn mcap(data: &[u8]) {
    expect_sound(data);
}

/// Images of ROS 2 in an MCAP file: a byte that says in which encoding, and their data.
pub fn ros_image(data: &[u8]) {
    if let Some(file) = messages::of_bytes(data) {
        expect_sound(&file);
    }
}

/// A chunk of an MCAP file in frames of LZ4: four bytes of the size that it claims, and the rest.
pub fn lz4(data: &[u8]) {
    packed("lz4", data);
}

/// A chunk of an MCAP file in frames of Zstandard: four bytes of the size that it claims, and the
/// rest.
pub fn zstd(data: &[u8]) {
    packed("zstd", data);
}

fn packed(compression: &str, data: &[u8]) {
    let Some((size, packed)) = data.split_first_chunk() else { return };
    let size = u64::from(u32::from_le_bytes(*size)) % (4 << 20);
    expect_sound(&of_chunk(chunk(size, 0, compression, packed)));
}

/// Opens a recording and decodes some of its frames, which have the size that they should have.
pub(crate) fn expect_sound(bytes: &[u8]) {
    // Readers of recordings keep the file open, so they ask for a path.
    let mut file = scratch();
    file.write_all(bytes).expect("the file can be written");
    let Ok(recording) = raw::open(file.path(), &limits()) else { return };
    let limits = limits();
    assert!((1..=limits.cameras).contains(&recording.cameras.len()));
    assert!((1..=limits.recording_frames).contains(&recording.frame_count));
    assert!(recording.fps.is_finite() && recording.fps > 0.0);
    for gripper in &recording.grippers {
        assert_eq!(gripper.poses.len(), recording.frame_count);
        assert!([0, recording.frame_count].contains(&gripper.widths_m.len()));
    }
    for index in 0..recording.cameras.len() {
        decode(&recording, index);
    }
}

fn decode(recording: &Recording, index: usize) {
    let camera = &recording.cameras[index];
    let size = (camera.width, camera.height);
    assert!(camera.width * camera.height <= limits().image_pixels);
    let Ok(mut frames) = recording.source.frames(index) else { return };
    for frame in 0..recording.frame_count.min(FRAMES) {
        if let Ok(Some(image)) = frames.color(frame) {
            assert_eq!((image.width, image.height), size);
        }
        if let Ok(Some(image)) = frames.depth(frame) {
            assert_eq!((image.width, image.height), size);
            assert!(image.pixels.iter().all(|m| m.is_finite() && *m >= 0.0));
        }
        for region in [Region::Object, Region::Manipulator] {
            if let Ok(Some(image)) = frames.mask(frame, region) {
                assert_eq!((image.width, image.height), size);
            }
        }
    }
    if let Ok(Some(tracks)) = frames.tracks() {
        assert_eq!(tracks.points.len(), tracks.count * recording.frame_count);
        assert_eq!(tracks.visible.len(), tracks.points.len());
    }
}

/// A file in memory where the system has such a folder.
fn scratch() -> NamedTempFile {
    let memory = std::path::Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
    NamedTempFile::new_in(folder).expect("there is room for a file")
}
