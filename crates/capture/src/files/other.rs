//! Formats that labs have and that have to be converted first, recognised by their content: a
//! message names the command for it.

use super::storage::Storage;
use crate::Error;

/// Bytes at the start and at the end of a file by which its format is recognized.
const LOOKED_AT: u64 = 64 << 10;

/// Topics of a RealSense recording in a ROS bag begin so.
const REALSENSE: &[u8] = b"/device_0/";

/// A format and what to do with it; `FILE` stands for the file's name.
struct Other {
    what: &'static str,
    advice: &'static str,
}

const REALSENSE_BAG: Other = Other {
    what: "a RealSense recording (.bag)",
    advice: "its depth is not aligned to colour yet: play it with pyrealsense2 through `rs.align(rs.stream.color)` and \
             write colour and depth as PNG (docs/formats/capture.md, section 6.2, has the script)",
};
const ROS1_BAG: Other = Other {
    what: "a bag of ROS 1",
    advice: "convert it with `mcap convert FILE recording.mcap` (https://mcap.dev/guides/cli) and send that",
};
const ROS2_DATABASE: Other = Other {
    what: "an SQLite database, as ROS 2 records bags (.db3)",
    advice: "convert it with `mcap convert FILE recording.mcap` (https://mcap.dev/guides/cli) in a shell with the ROS \
             workspace, or record with `ros2 bag record -s mcap`, and send that",
};
const VIDEO: Other = Other {
    what: "a video, which has no depth and whose frames are packed",
    advice: "write its frames as images with `ffmpeg -i FILE -fps_mode passthrough -start_number 0 color/0/%d.png`, \
             beside depth and calibration (docs/formats/capture.md, section 6)",
};
const PACKED: Other = Other {
    what: "an archive of another kind",
    advice: "unpack it, and send the folder, a .zip, a .tar or a .tar.gz",
};
const HDF5: Other = Other {
    what: "an HDF5 file",
    advice: "write its images as PNG into folders (docs/formats/capture.md, section 6), or its points with \
             `client.upload_motion` of the Python client",
};

/// First bytes of formats.
const STARTS: &[(&[u8], &Other)] = &[
    (b"SQLite format 3\0", &ROS2_DATABASE),
    (b"\x1a\x45\xdf\xa3", &VIDEO),
    (b"7z\xbc\xaf\x27\x1c", &PACKED),
    (b"Rar!\x1a\x07", &PACKED),
    (b"\xfd7zXZ\0", &PACKED),
    (b"BZh", &PACKED),
    (b"\x28\xb5\x2f\xfd", &PACKED),
    (b"\x89HDF\r\n\x1a\n", &HDF5),
];

/// The error for a file that is of a known format which is not read; `name` is that of the file.
pub(super) fn recognise(name: &str, storage: &mut Storage<'_>) -> Option<Error> {
    let start = storage.first(LOOKED_AT).ok()?;
    let other = if start.starts_with(b"#ROSBAG V2.0") {
        let end = storage.last(LOOKED_AT).ok()?;
        let is_realsense = [&start, &end].iter().any(|part| contains(part, REALSENSE));
        if is_realsense { &REALSENSE_BAG } else { &ROS1_BAG }
    } else if start.get(4..8) == Some(b"ftyp")
        || (start.starts_with(b"RIFF") && start.get(8..12) == Some(b"AVI "))
    {
        &VIDEO
    } else {
        STARTS.iter().find(|(magic, _)| start.starts_with(magic)).map(|(_, other)| *other)?
    };
    Some(error(name, other))
}

/// The error for a video in the place of images that `images` would name, `color/0/%d.png` say.
pub(crate) fn video(name: &str, images: &str) -> Error {
    let folder = images.rsplit_once('/').map_or("", |(folder, _)| folder);
    Error::OtherFormat {
        at: name.to_owned(),
        what: VIDEO.what,
        advice: format!(
            "write its frames as images with `mkdir -p {folder} && ffmpeg -i {name} -fps_mode passthrough \
             -start_number 0 {images}` in the recording's folder"
        ),
    }
}

/// `true` if a file is a video by its name.
pub(crate) fn is_video(name: &str) -> bool {
    let ending = name.rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase());
    ending.is_some_and(|e| ["mp4", "mkv", "avi", "mov", "webm"].contains(&e.as_str()))
}

/// gzip of one file that is no archive.
pub(super) fn gzip(name: &str) -> Error {
    Error::OtherFormat {
        at: name.to_owned(),
        what: "compressed with gzip, but no tar archive",
        advice: "send the folder, a .zip, a .tar or a .tar.gz of it".to_owned(),
    }
}

fn error(name: &str, other: &Other) -> Error {
    let advice = other.advice.replace("FILE", name);
    Error::OtherFormat { at: name.to_owned(), what: other.what, advice }
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}
