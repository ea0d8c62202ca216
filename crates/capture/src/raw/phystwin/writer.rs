//! Writes a recording as a PhysTwin case, before its data processing: for made recordings, and for
//! who wants to run the original on what was recorded in another format.

use std::{
    fs,
    io::{Cursor, Write},
    path::Path,
};

use bendtwin_mesh::{Mesh, Similarity, write_glb};
use serde_json::json;
use zip::{ZipWriter, write::SimpleFileOptions};

use super::{DEPTH_UNIT_M, MARKER, poses::CALIBRATION};
use crate::{
    Error,
    frame::Frame,
    npy,
    raw::{Camera, Distortion, MeshFile, Recording, Region, Tracks, encode},
};

/// Writes a recording as a PhysTwin case into a folder, which is made if it is not there; without
/// `calibrate.pkl` if its cameras have no poses.
///
/// # Errors
/// If a camera has a lens with distortion or moves, which the format cannot say; if a frame cannot
/// be read or a file not written.
pub fn write_case(recording: &Recording, folder: &Path) -> Result<(), Error> {
    export_case(recording, |name, bytes| {
        let path = folder.join(name);
        let failed = |source| Error::Io { at: path.display().to_string(), source };
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(failed)?;
        }
        fs::write(&path, bytes).map_err(failed)
    })
}

/// Hands every file of the case to `put`, with its name inside the case. Frame by frame, so that
/// memory stays flat.
///
/// # Errors
/// Those of [`write_case`], and what `put` returns.
pub fn export_case(
    recording: &Recording,
    mut put: impl FnMut(&str, Vec<u8>) -> Result<(), Error>,
) -> Result<(), Error> {
    let Some(turn) = Frame::from_up("-z").map(|frame| frame.rotation) else {
        return Err(Error::Axes("the case's axes are unknown".to_owned()));
    };
    let mut poses = Vec::new();
    let placed = recording.cameras.iter().any(|camera| !camera.poses.is_empty());
    for camera in recording.cameras.iter().filter(|_| placed) {
        poses.extend(matrix(camera, turn)?.into_iter().flatten());
    }
    let count = recording.cameras.len();
    if placed {
        put(CALIBRATION, pickled_list(&poses, count))?;
    }
    put(MARKER, metadata(recording).to_string().into_bytes())?;
    let (train, all) = (recording.train_frame_count, recording.frame_count);
    let split = json!({"frame_len": all, "train": [0, train], "test": [train, all]});
    put("split.json", split.to_string().into_bytes())?;
    if !recording.truth_tracks.is_empty() && all > 0 {
        let shape = [all, recording.truth_tracks.len() / all, 3];
        let turned = recording.truth_tracks.iter().flat_map(|p| turned(turn, *p));
        let values: Vec<f64> = turned.map(f64::from).collect();
        put("gt_track_3d.pkl", pickled(&shape, &values))?;
    }
    if let Some(mesh) = &recording.mesh {
        let (name, bytes) = shape(mesh, turn)?;
        put(name, bytes)?;
    }
    for index in 0..count {
        camera(recording, index, &mut put)?;
    }
    Ok(())
}

fn camera(
    recording: &Recording,
    index: usize,
    put: &mut impl FnMut(&str, Vec<u8>) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut frames = recording.source.frames(index)?;
    let parts = [("object", Region::Object), ("hand", Region::Manipulator)];
    let info = json!({"0": parts[0].0, "1": parts[1].0});
    put(&format!("mask/mask_info_{index}.json"), info.to_string().into_bytes())?;
    for frame in 0..recording.frame_count {
        if let Some(color) = frames.color(frame)? {
            put(&format!("color/{index}/{frame}.png"), encode::color(&color)?)?;
        }
        if let Some(depth) = frames.depth(frame)? {
            let bytes: Vec<u8> =
                encode::steps(&depth, DEPTH_UNIT_M).flat_map(u16::to_le_bytes).collect();
            let array = npy::write("<u2", &[depth.height, depth.width], &bytes);
            put(&format!("depth/{index}/{frame}.npy"), array)?;
        }
        for (part, (_, region)) in parts.iter().enumerate() {
            if let Some(mask) = frames.mask(frame, *region)? {
                put(&format!("mask/{index}/{part}/{frame}.png"), encode::mask(&mask)?)?;
            }
        }
    }
    if let Some(tracks) = frames.tracks()? {
        let bytes = archive(&tracks, recording.frame_count)
            .map_err(|source| Error::Io { at: "the archive of tracks".to_owned(), source })?;
        put(&format!("cotracker/{index}.npz"), bytes)?;
    }
    Ok(())
}

fn metadata(recording: &Recording) -> serde_json::Value {
    let matrix = |camera: &Camera| {
        let i = &camera.intrinsics;
        json!([[i.fx, 0.0, i.cx], [0.0, i.fy, i.cy], [0.0, 0.0, 1.0]])
    };
    let size = recording.cameras.first().map(|c| [c.width, c.height]);
    json!({
        "intrinsics": recording.cameras.iter().map(matrix).collect::<Vec<_>>(),
        "WH": size,
        "fps": recording.fps,
        "frame_num": recording.frame_count,
        "serial_numbers": recording.cameras.iter().map(|c| &c.name).collect::<Vec<_>>(),
    })
}

/// Camera to the case's world.
fn matrix(camera: &Camera, turn: [[f32; 3]; 3]) -> Result<[[f64; 4]; 4], Error> {
    let ([pose], Distortion::None) = (camera.poses.as_slice(), &camera.distortion) else {
        return Err(Error::Camera {
            camera: camera.name.clone(),
            fault: "a PhysTwin case holds cameras that stand and have no distortion: write a BendTwin bundle"
                .to_owned(),
        });
    };
    // The inverse of a rotation is its transpose.
    let back = |v: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|j| f64::from(turn[j][i]) * v[j]).sum())
    };
    let mut out = [[0.0; 4]; 4];
    out[3][3] = 1.0;
    for column in 0..4 {
        let v = match column {
            3 => pose.translation,
            _ => pose.rotation.map(|row| row[column]),
        };
        for (row, x) in back(v).into_iter().enumerate() {
            out[row][column] = x;
        }
    }
    Ok(out)
}

/// From the world to the case's.
fn turned(turn: [[f32; 3]; 3], p: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| (0..3).map(|j| turn[j][i] * p[j]).sum())
}

/// A mesh in its place becomes the matched shape, another one the generated shape.
fn shape(file: &MeshFile, turn: [[f32; 3]; 3]) -> Result<(&'static str, Vec<u8>), Error> {
    let read = || -> Result<Mesh, Error> {
        bendtwin_mesh::parse(&file.name, &file.bytes, &bendtwin_mesh::Limits::default())
            .map_err(|e| Error::Damaged { at: file.name.clone(), fault: e.to_string() })
    };
    let Some(to_world) = &file.to_world else {
        let is_glb = file.name.to_ascii_lowercase().ends_with(".glb");
        let bytes = if is_glb { file.bytes.clone() } else { write_glb(&read()?) };
        return Ok(("shape/object.glb", bytes));
    };
    let to_world = Similarity {
        rotation: to_world.rotation.map(|row| row.map(f64::from)),
        scale: f64::from(to_world.scale),
        translation: to_world.translation.map(f64::from),
    };
    let mut mesh = read()?.moved(&to_world);
    mesh.vertices.iter_mut().for_each(|v| *v = turned(turn, *v));
    Ok(("shape/matching/final_mesh.glb", write_glb(&mesh)))
}

/// Tracks as row, column, as CoTracker's are kept.
fn archive(tracks: &Tracks, frame_count: usize) -> std::io::Result<Vec<u8>> {
    let positions = tracks.points.iter().flat_map(|[x, y]| [y.to_le_bytes(), x.to_le_bytes()]);
    let positions: Vec<u8> = positions.flatten().collect();
    let flags: Vec<u8> = tracks.visible.iter().map(|v| u8::from(*v)).collect();
    let shape = [frame_count, tracks.count];
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, array) in [
        ("tracks.npy", npy::write("<f4", &[frame_count, tracks.count, 2], &positions)),
        ("visibility.npy", npy::write("|b1", &shape, &flags)),
    ] {
        zip.start_file(
            name,
            SimpleFileOptions::default().last_modified_time(zip::DateTime::default()),
        )?;
        zip.write_all(&array)?;
    }
    Ok(zip.finish()?.into_inner())
}

/// A list of `count` matrices of 4 x 4 as numpy pickles them.
fn pickled_list(values: &[f64], count: usize) -> Vec<u8> {
    let mut out = b"\x80\x03]".to_vec();
    for matrix in values.chunks(16).take(count) {
        out.extend(array_opcodes(&[4, 4], matrix));
        out.push(b'a');
    }
    out.push(b'.');
    out
}

/// An array as numpy pickles it.
fn pickled(shape: &[usize], values: &[f64]) -> Vec<u8> {
    [b"\x80\x03".to_vec(), array_opcodes(shape, values), b".".to_vec()].concat()
}

/// Opcodes of protocol 3 that leave a float64 array on the stack.
fn array_opcodes(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let number = |n: usize| [b"J".as_slice(), &(n as i32).to_le_bytes()].concat();
    let mut out =
        b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85C\x01b\x87R(K\x01("
            .to_vec();
    out.extend(shape.iter().flat_map(|n| number(*n)));
    out.extend(b"tcnumpy\ndtype\nX\x02\x00\x00\x00f8K\x00K\x01\x87R");
    out.extend(b"(K\x03X\x01\x00\x00\x00<NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb\x89B");
    out.extend(((values.len() * 8) as u32).to_le_bytes());
    out.extend(values.iter().flat_map(|x| x.to_le_bytes()));
    out.extend(b"tb");
    out
}
