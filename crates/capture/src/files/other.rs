//! Formats that labs have and that have to be converted first, recognised by their content: a
//! message names the command for it.

use super::{storage::Storage, tar::is_tar};
use crate::Error;

/// Bytes at the start and at the end of a file by which its format is recognized.
const LOOKED_AT: u64 = 64 << 10;

/// Topics of a RealSense recording in a ROS bag begin so.
const REALSENSE: &[u8] = b"/device_0/";

/// First bytes of what is compressed with gzip.
pub(super) const GZIP: &[u8] = b"\x1f\x8b";
/// First bytes of a pointer of Git LFS, which stands in for a file that was not fetched.
const POINTER: &[u8] = b"version https://git-lfs.github.com/spec/";
/// Bytes of a pointer, at most.
pub(super) const LONGEST_POINTER: u64 = 1024;

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
const SEVEN_ZIP: Other = Other {
    what: "a 7z archive",
    advice: "unpack it with `7z x FILE`, and send the folder, a .zip or a .tar",
};
const RAR: Other = Other {
    what: "a RAR archive",
    advice: "unpack it with `unrar x FILE`, and send the folder, a .zip or a .tar",
};
const XZ: Other = Other {
    what: "compressed with xz",
    advice: "unpack it with `unxz FILE`, and send what comes out of it, a .zip or a .tar",
};
const BZIP2: Other = Other {
    what: "compressed with bzip2",
    advice: "unpack it with `bunzip2 FILE`, and send what comes out of it, a .zip or a .tar",
};
const ZSTD: Other = Other {
    what: "compressed with Zstandard",
    advice: "unpack it with `zstd -d FILE`, and send what comes out of it",
};
const GZIPPED: Other = Other {
    what: "compressed with gzip",
    advice: "unpack it with `gunzip FILE`, and send what comes out of it; only a .tar.gz is read packed",
};
const INNER: Other = Other {
    what: "an archive in the place of a capture's files",
    advice: "unpack the outer folder or archive, and send this one by itself",
};
const LFS: Other = Other {
    what: "a Git LFS pointer, not the file itself",
    advice: "run `git lfs pull` in the repository that it comes from, and send it again",
};
const HTML: Other = Other {
    what: "an HTML page, not the file that its name says",
    advice: "the download was answered with a page (a login, a quota, a preview): open it in a browser, and download \
             the file itself",
};
const PICKLE: Other = Other {
    what: "a pickle by itself",
    advice: "send the folder of a PhysTwin case whole; of motion capture, as DEFORM's data has it, write an .npz and its \
             .json with the lines of docs/formats/capture.md, section 3",
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
    (b"7z\xbc\xaf\x27\x1c", &SEVEN_ZIP),
    (b"Rar!\x1a\x07", &RAR),
    (b"\xfd7zXZ\0", &XZ),
    (b"BZh", &BZIP2),
    (b"\x28\xb5\x2f\xfd", &ZSTD),
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
    } else if let Some(known) = disguised(name, &start) {
        return Some(known);
    } else {
        let lower = name.to_ascii_lowercase();
        let is_archive = start.starts_with(b"PK") && lower.ends_with(".zip") || is_tar(&start);
        let known = STARTS.iter().find(|(magic, _)| start.starts_with(magic));
        match known {
            Some((_, other)) => other,
            None if is_archive => &INNER,
            None if lower.ends_with(".pkl") || lower.ends_with(".pickle") => &PICKLE,
            None => return None,
        }
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

/// The error for a file of an archive that is a capture by itself, by its name.
pub(super) fn packed(name: &str) -> Option<Error> {
    let lower = name.to_ascii_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|ending| lower.ends_with(ending));
    let other = if ends(&[".zip", ".tar", ".tar.gz", ".tgz", ".7z", ".rar", ".tar.xz", ".tar.bz2"])
    {
        &INNER
    } else if ends(&[".gz"]) {
        &GZIPPED
    } else if ends(&[".pkl", ".pickle"]) {
        &PICKLE
    } else {
        return None;
    };
    Some(error(name, other))
}

/// The error for a file whose content is not a capture's, under any name.
pub(super) fn disguised(name: &str, bytes: &[u8]) -> Option<Error> {
    let other = if bytes.starts_with(POINTER) {
        &LFS
    } else if is_html(bytes) {
        &HTML
    } else if bytes.starts_with(GZIP) {
        &GZIPPED
    } else {
        return None;
    };
    Some(error(name, other))
}

/// The error for gzip of something that is no tar archive, by the first bytes of what is inside.
pub(super) fn gzip(name: &str, inside: &[u8]) -> Error {
    let advice = match inside {
        [0x89, b'M', b'C', b'A', b'P', ..] => {
            "it is an MCAP file inside: unpack it with `gunzip FILE`, and send that"
        }
        [b'P', b'K', ..] => {
            "it is a ZIP archive inside: unpack it with `gunzip FILE`, and send that"
        }
        _ => {
            "unpack it with `gunzip FILE`, and send what comes out of it; or send the folder, a .zip, a .tar or a .tar.gz"
        }
    };
    error(name, &Other { what: "compressed with gzip, but no tar archive", advice })
}

/// `true` if a file begins as a page of the web does.
fn is_html(bytes: &[u8]) -> bool {
    let text = bytes.trim_ascii_start();
    let begins = |word: &[u8]| text.get(..word.len()).is_some_and(|t| t.eq_ignore_ascii_case(word));
    begins(b"<!doctype html") || begins(b"<html")
}

fn error(name: &str, other: &Other) -> Error {
    let advice = other.advice.replace("FILE", name);
    Error::OtherFormat { at: name.to_owned(), what: other.what, advice }
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}
