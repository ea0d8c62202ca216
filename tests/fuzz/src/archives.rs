//! Captures of tracked points: archives, and the files in them.

use std::io::Cursor;

use bendtwin_capture::{
    Error,
    npy::Floats,
    phystwin::results::{SearchResult, TrainResult},
    raw::DepthImage,
    read_bytes, write_bundle,
};
use bendtwin_core::Capture;
use bendtwin_hostile::{archives, samples, torch_files};

use crate::{limits, recordings};

/// An archive: opened, read as tracked points, and else as a recording.
pub fn zip(data: &[u8]) {
    expect_sound(data);
}

/// A tar archive, plain or compressed.
pub fn tar(data: &[u8]) {
    expect_sound(data);
}

/// The pickle of a PhysTwin case.
pub fn case(data: &[u8]) {
    expect_sound(&archives::with(samples::case(), "final_data.pkl", data.to_vec()));
}

/// `capture.json`, beside the arrays of tracked points and beside images.
pub fn manifest(data: &[u8]) {
    expect_sound(&archives::with(samples::observation(), "capture.json", data.to_vec()));
    recordings::expect_sound(&archives::with(samples::raw_bundle(), "capture.json", data.to_vec()));
}

/// `transforms.json` of nerfstudio, beside images.
pub fn transforms(data: &[u8]) {
    let mut files = samples::raw_bundle();
    files.remove("capture.json");
    recordings::expect_sound(&archives::with(files, "transforms.json", data.to_vec()));
}

/// `grippers.json`, beside images.
pub fn grippers(data: &[u8]) {
    recordings::expect_sound(&archives::with(
        samples::raw_bundle(),
        "grippers.json",
        data.to_vec(),
    ));
}

/// Masks of a camera, of all frames and of one.
pub fn masks(data: &[u8]) {
    for archive in bendtwin_hostile::masks::capture(data.to_vec()) {
        recordings::expect_sound(&archive);
    }
}

/// `metadata.json` of a raw PhysTwin case, beside images.
pub fn metadata(data: &[u8]) {
    recordings::expect_sound(&archives::with(samples::raw_case(), "metadata.json", data.to_vec()));
}

/// An array of numpy, also as depth on the grids of an ordinary and of a flat image.
pub fn npy(data: &[u8]) {
    let limits = limits();
    for size in [samples::SIZE, [8, 1]] {
        if let Ok(depth) = DepthImage::decode("fuzz.npy", data, 0.001, size, &limits) {
            assert_eq!(depth.pixels.len(), size[0] * size[1]);
            assert!(depth.pixels.iter().all(|m| m.is_finite() && *m >= 0.0));
        }
    }
    let Ok(array) = Floats::decode("fuzz.npy", data, &limits) else { return };
    assert_eq!(array.values.len(), array.shape.iter().product::<usize>());
    assert!(array.values.len() as u64 * 4 <= limits.total_bytes);
    let written = array.encode();
    let again = Floats::decode("again.npy", &written, &limits).expect("what was written is read");
    // Compared as bytes, because NaN is no equal of itself.
    assert_eq!((again.shape == array.shape, again.encode()), (true, written));
}

/// A training of PhysTwin: an archive of torch, and the pickle in one.
pub fn pth(data: &[u8]) {
    let limits = limits();
    for archive in [data, &torch_files::with(data)] {
        let Ok(result) = TrainResult::decode("fuzz.pth", archive, &limits) else { continue };
        assert!(result.stiffness.len() as u64 * 4 <= limits.total_bytes);
        assert!(result.stiffness.iter().all(|k| k.is_finite() && *k >= 0.0));
        assert!(result.object_spring_count.is_none_or(|count| count <= result.stiffness.len()));
    }
}

/// A pickle of arrays, or of the numbers of PhysTwin's search.
pub fn pickle(data: &[u8]) {
    let limits = limits();
    if let Ok(result) = SearchResult::decode("fuzz.pkl", data, &limits) {
        let numbers = [result.stiffness, result.object_radius_m, result.drag, result.dashpot];
        assert!(numbers.iter().all(|x| x.is_finite() && *x >= 0.0));
    }
    let Ok(arrays) = Floats::unpickle("fuzz.pkl", data, &limits) else { return };
    let count: usize = arrays.iter().map(|array| array.values.len()).sum();
    assert!(count as u64 * 4 <= limits.total_bytes);
    for array in &arrays {
        assert_eq!(array.values.len(), array.shape.iter().product::<usize>());
    }
}

/// Reads an archive; what it gives is within the limits, and stays the same when it is written.
fn expect_sound(archive: &[u8]) {
    let limits = limits();
    let capture = match read_bytes("fuzz", archive, &limits) {
        Ok(capture) => capture,
        Err(Error::RawOnly(_)) => return recordings::expect_sound(archive),
        Err(_) => return,
    };
    assert!(capture.object.point_count <= limits.points);
    assert!(capture.sequences.len() <= limits.sequences);
    assert!(capture.sequences.iter().all(|s| s.frame_count <= limits.frames));
    let written = write(&capture);
    // Flags and defaults are written out, which may take more than was read.
    let ample = bendtwin_capture::Limits::default();
    let again = read_bytes("fuzz", &written, &ample).expect("what was written is read");
    assert_eq!(write(&again), written);
}

fn write(capture: &Capture) -> Vec<u8> {
    let written = write_bundle(capture, Cursor::new(Vec::new()));
    written.expect("what was read can be written").into_inner()
}
