//! Readers of strangers' bytes, one function each, for the fuzzer and for the replay of its corpora.
//!
//! A function calls a reader under small limits and asserts what must hold of every input: it does
//! not panic, what it accepts is within the limits, and what can be written is read again as the
//! same. [`TARGETS`] lists them with their seeds; `docs/develop/fuzzing.md` says how to run them and how to
//! add one.

pub mod archives;
pub mod calibrations;
pub mod images;
pub mod markers;
pub mod meshes;
pub mod recordings;
pub mod requests;
pub mod splats;
pub mod twins;

mod seeds;

/// A reader of strangers' bytes.
#[derive(Clone, Copy)]
pub struct Target {
    /// Name of the binary, of the folder of its corpus and of its dictionary.
    pub name: &'static str,
    /// Reads bytes; a panic is a fault of the reader.
    pub run: fn(&[u8]),
    /// Valid files, and files with one fault each, to start from.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

/// All targets, by name.
pub const TARGETS: &[Target] = &[
    Target { name: "calibration", run: calibrations::calibration, seeds: seeds::calibration },
    Target { name: "case", run: archives::case, seeds: seeds::case },
    Target { name: "checkpoint", run: twins::checkpoint, seeds: seeds::checkpoint },
    Target { name: "colmap", run: calibrations::colmap, seeds: seeds::colmap },
    Target { name: "glb", run: meshes::glb, seeds: seeds::glb },
    Target { name: "grippers", run: archives::grippers, seeds: seeds::grippers },
    Target { name: "jpeg", run: images::jpeg, seeds: seeds::jpeg },
    Target { name: "lz4", run: recordings::lz4, seeds: seeds::lz4 },
    Target { name: "manifest", run: archives::manifest, seeds: seeds::manifest },
    Target { name: "markers", run: markers::markers, seeds: seeds::markers },
    Target { name: "masks", run: archives::masks, seeds: seeds::masks },
    Target { name: "mcap", run: recordings::mcap, seeds: seeds::mcap },
    Target { name: "metadata", run: archives::metadata, seeds: seeds::metadata },
    Target { name: "npy", run: archives::npy, seeds: seeds::npy },
    Target { name: "obj", run: meshes::obj, seeds: seeds::obj },
    Target { name: "pickle", run: archives::pickle, seeds: seeds::pickle },
    Target { name: "ply", run: meshes::ply, seeds: seeds::ply },
    Target { name: "png", run: images::png, seeds: seeds::png },
    Target { name: "pth", run: archives::pth, seeds: seeds::pth },
    Target {
        name: "registration_message",
        run: requests::registration_message,
        seeds: seeds::registration_message,
    },
    Target { name: "report", run: requests::report, seeds: seeds::report },
    Target { name: "rollout_json", run: requests::rollout_json, seeds: seeds::rollout_json },
    Target {
        name: "rollout_message",
        run: requests::rollout_message,
        seeds: seeds::rollout_message,
    },
    Target { name: "ros_image", run: recordings::ros_image, seeds: seeds::ros_image },
    Target { name: "settings", run: requests::settings, seeds: seeds::settings },
    Target { name: "splats", run: splats::splats, seeds: seeds::splats },
    Target { name: "tar", run: archives::tar, seeds: seeds::tar },
    Target { name: "transforms", run: archives::transforms, seeds: seeds::transforms },
    #[cfg(feature = "uploads")]
    Target { name: "tus", run: requests::tus, seeds: seeds::tus },
    Target { name: "twin", run: twins::twin, seeds: seeds::twin },
    Target { name: "zip", run: archives::zip, seeds: seeds::zip },
    Target { name: "zstd", run: recordings::zstd, seeds: seeds::zstd },
];

/// Limits that keep one run within milliseconds and megabytes.
fn limits() -> bendtwin_capture::Limits {
    bendtwin_capture::Limits {
        total_bytes: 8 << 20,
        file_bytes: 4 << 20,
        archive_entries: 1000,
        ratio_from_bytes: 1 << 20,
        pickle_opcodes: 100_000,
        frames: 10_000,
        points: 10_000,
        controls: 100,
        sequences: 100,
        cameras: 8,
        recording_frames: 1000,
        image_pixels: 1 << 16,
        ..Default::default()
    }
}
