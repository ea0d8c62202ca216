//! Writes a bundle. Equal captures give equal bytes: entries come in a fixed
//! order and carry no time.

use std::{
    io::{Seek, Write},
    path::Path,
};

use bendtwin_core::{Capture, Point, Sequence};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use super::{
    arrays,
    manifest::{Ground, MARKER, Manifest, SequenceEntry},
    reader::seen_twice,
};
use crate::{Error, check::structure::validate, npy, several};

/// Writes a capture as a bundle ZIP, several recordings of an object as as many bundles in one;
/// returns the writer at its end. Flags that equal their defaults are left out, so motion capture
/// stays small.
///
/// # Errors
/// If the capture contradicts itself or writing fails.
pub fn write_bundle<W: Write + Seek>(capture: &Capture, out: W) -> Result<W, Error> {
    let zip = write_bundle_to(capture, out)?;
    zip.finish().map_err(|e| failed("the archive's directory", e.into()))
}

/// [`write_bundle`], to an archive that takes more files.
pub(crate) fn write_bundle_to<W: Write + Seek>(
    capture: &Capture,
    out: W,
) -> Result<ZipWriter<W>, Error> {
    validate(capture)?;
    let mut zip = ZipWriter::new(out);
    // The reference lies in the root, where readers that know a single recording find it.
    write_recording(&mut zip, capture, "")?;
    if !capture.others.is_empty() {
        let folder = |index: usize| match index {
            0 => several::ROOT.to_owned(),
            index => format!("recording-{index:04}"),
        };
        let named = capture.recordings().enumerate().map(|(i, r)| (folder(i), r.name.as_str()));
        let marker = several::MARKER;
        let document = several::document(named).map_err(|e| failed(marker, e.into()))?;
        put(&mut zip, marker, &document)?;
        for (index, recording) in capture.recordings().enumerate().skip(1) {
            write_recording(&mut zip, recording, &format!("{}/", folder(index)))?;
        }
    }
    Ok(zip)
}

/// Adds a file to an archive.
pub(crate) fn put<W: Write + Seek>(
    zip: &mut ZipWriter<W>,
    name: &str,
    bytes: &[u8],
) -> Result<(), Error> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(zip::DateTime::default());
    zip.start_file(name, options).map_err(|e| failed(name, e.into()))?;
    zip.write_all(bytes).map_err(|e| failed(name, e))
}

/// Writes one recording as a bundle in a folder.
fn write_recording<W: Write + Seek>(
    zip: &mut ZipWriter<W>,
    capture: &Capture,
    at: &str,
) -> Result<(), Error> {
    let mut put = |name: &str, bytes: &[u8]| put(zip, &format!("{at}{name}"), bytes);
    let manifest =
        serde_json::to_vec_pretty(&manifest(capture)).map_err(|e| failed(MARKER, e.into()))?;
    put(MARKER, &manifest)?;

    let object = &capture.object;
    for (name, points) in [
        (arrays::COLORS, &object.colors),
        (arrays::SURFACE, &object.completed_surface),
        (arrays::INTERIOR, &object.interior),
        (arrays::REST, &object.rest_points),
    ] {
        if !points.is_empty() {
            put(name, &points_npy(&[points.len(), 3], points))?;
        }
    }
    let pins: Vec<[u32; 2]> = object.pins.iter().map(|p| [p.point, p.control]).collect();
    for (name, pairs) in [(arrays::EDGES, &object.edges), (arrays::PINS, &pins)] {
        if !pairs.is_empty() {
            let bytes: Vec<u8> = pairs.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
            put(name, &npy::write("<u4", &[pairs.len(), 2], &bytes))?;
        }
    }
    if !object.control_hands.is_empty() {
        let hands = &object.control_hands;
        let bytes: Vec<u8> = hands.iter().flat_map(|hand| hand.to_le_bytes()).collect();
        put(arrays::HANDS, &npy::write("<u4", &[hands.len()], &bytes))?;
    }
    for (index, sequence) in capture.sequences.iter().enumerate() {
        let folder = folder(capture, index);
        let path = |name: &str| {
            if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") }
        };
        let (frames, points) = (sequence.frame_count, object.point_count);
        put(&path(arrays::POINTS), &points_npy(&[frames, points, 3], &sequence.points))?;
        if !visible_by_default(sequence) {
            put(&path(arrays::VISIBLE), &flags_npy(&[frames, points], &sequence.visible))?;
        }
        if sequence.motion_valid != seen_twice(&sequence.visible, points) {
            put(&path(arrays::MOTION), &flags_npy(&[frames, points], &sequence.motion_valid))?;
        }
        for (name, count, tracks) in [
            (arrays::CONTROLS, sequence.control_count(), &sequence.controls),
            (arrays::TRUTH, sequence.truth_count(), &sequence.truth_tracks),
        ] {
            if !tracks.is_empty() {
                put(&path(name), &points_npy(&[frames, count, 3], tracks))?;
            }
        }
    }
    Ok(())
}

/// Writes a capture as a bundle ZIP at a path.
///
/// # Errors
/// Those of [`write_bundle`].
pub fn write_bundle_file(capture: &Capture, path: &Path) -> Result<(), Error> {
    let at = path.display().to_string();
    let file = std::fs::File::create(path).map_err(|e| failed(&at, e))?;
    let file = write_bundle(capture, std::io::BufWriter::new(file))?;
    file.into_inner().map_err(|e| failed(&at, e.into_error()))?;
    Ok(())
}

fn failed(at: &str, source: std::io::Error) -> Error {
    Error::Io { at: at.to_owned(), source }
}

/// A lone sequence lies in the root.
fn folder(capture: &Capture, index: usize) -> String {
    if capture.sequences.len() == 1 { String::new() } else { format!("sequences/{index:04}") }
}

fn manifest(capture: &Capture) -> Manifest {
    let environment = &capture.environment;
    let entry = |(index, sequence): (usize, &Sequence)| SequenceEntry {
        name: sequence.name.clone(),
        folder: folder(capture, index),
        train_frame_count: i64::try_from(sequence.train_frame_count).unwrap_or(i64::MAX),
        start_frames: sequence.start_frames,
    };
    Manifest {
        mass_kg: capture.object.mass_kg,
        sequences: capture.sequences.iter().enumerate().map(entry).collect(),
        ..Manifest::in_world(
            &capture.name,
            capture.fps,
            environment.gravity,
            environment.ground.map(|g| Ground { normal: g.normal, offset: g.offset_m }),
            capture.source_to_world,
        )
    }
}

fn visible_by_default(sequence: &Sequence) -> bool {
    let finite = sequence.points.iter().map(|p| p.iter().all(|x| x.is_finite()));
    finite.zip(&sequence.visible).all(|(finite, visible)| finite == *visible)
}

fn points_npy(shape: &[usize], points: &[Point]) -> Vec<u8> {
    let bytes: Vec<u8> = points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    npy::write("<f4", shape, &bytes)
}

fn flags_npy(shape: &[usize], flags: &[bool]) -> Vec<u8> {
    let bytes: Vec<u8> = flags.iter().map(|f| u8::from(*f)).collect();
    npy::write("|b1", shape, &bytes)
}
