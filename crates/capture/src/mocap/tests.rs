use std::path::Path;

use super::*;
use crate::check::testing::pack;

const DESCRIPTION: &str = r#"{"object": "C1", "fps": 100, "units": "m", "up_axis": "+z",
    "gravity": [0, 0, -9.81], "sequences": {"train": ["a", "b"], "eval": ["c"]},
    "metric": {"definition": "z of data clipped to >=0.002001 m (floor)"}}"#;

fn floats(shape: &[usize], at: impl Fn(usize) -> f32) -> Vec<u8> {
    let count = shape.iter().product();
    let bytes: Vec<u8> = (0..count).flat_map(|i| at(i).to_le_bytes()).collect();
    npy::write("<f4", shape, &bytes)
}

fn integers(shape: &[usize], numbers: &[i32]) -> Vec<u8> {
    let bytes: Vec<u8> = numbers.iter().flat_map(|i| i.to_le_bytes()).collect();
    npy::write("<i4", shape, &bytes)
}

fn write(folder: &Path, controlled: &[i32]) -> std::path::PathBuf {
    let wave = |i: usize| 0.05 * (i as f32 * 0.7).sin() + 0.02;
    let files = [
        ("train.npy".to_owned(), floats(&[2, 5, 4, 3], wave)),
        ("eval.npy".to_owned(), floats(&[1, 5, 4, 3], wave)),
        ("rest_vertices.npy".to_owned(), floats(&[4, 3], |i| i as f32)),
        ("edges.npy".to_owned(), integers(&[3, 2], &[0, 1, 1, 2, 2, 3])),
        ("controlled.npy".to_owned(), integers(&[controlled.len()], controlled)),
    ];
    let npz = folder.join("C1.npz");
    std::fs::write(&npz, pack(&files.into())).unwrap();
    std::fs::write(folder.join("C1.json"), DESCRIPTION).unwrap();
    npz
}

#[test]
fn held_vertices_become_pins() {
    let folder = tempfile::tempdir().unwrap();
    let npz = write(folder.path(), &[0, 3]);
    let capture = crate::read(&npz, &Limits::default()).unwrap();
    assert_eq!(capture.name, "C1");
    assert_eq!(capture.object.edges, [[0, 1], [1, 2], [2, 3]]);
    assert_eq!(capture.object.pins[1], HeldPoint { point: 3, control: 1 });
    assert_eq!(capture.object.rest_points[1], [3.0, 4.0, 5.0]);
    let names: Vec<&str> = capture.sequences.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["train a", "train b", "eval c"]);
    assert_eq!(capture.sequences[0].train_frame_count, 5);
    assert!(capture.sequences[2].is_held_out());
    for sequence in &capture.sequences {
        assert_eq!(sequence.start_frames, 2);
        assert_eq!(sequence.controls_at(4)[1], sequence.points_at(4)[3]);
        assert!(sequence.points.iter().all(|p| p[2] >= FLOOR_M));
    }
    assert_eq!(capture.environment.ground.unwrap().offset_m, FLOOR_M);
}

/// An archive of both files, as a client sends them, or a folder that has them.
#[test]
fn both_files_may_lie_in_an_archive_or_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let npz = write(folder.path(), &[0, 3]);
    let alone = crate::read(&npz, &Limits::default()).unwrap();
    let of = |name: &str| (name.to_owned(), std::fs::read(folder.path().join(name)).unwrap());
    let archive = pack(&[of("C1.npz"), of("C1.json")].into());
    let packed = crate::read_bytes("DLO4", &archive, &Limits::default()).unwrap();
    assert_eq!(packed, alone);
    assert_eq!(crate::read(folder.path(), &Limits::default()).unwrap(), alone);
    let read = crate::files_read(folder.path(), &Limits::default()).unwrap();
    assert_eq!(read.files, ["C1.json", "C1.npz"]);
    assert!(read.format.contains("motion capture"), "{}", read.format);
    // What is unpacked is bounded as in any archive.
    let little = Limits { total_bytes: 1_000, ..Limits::default() };
    assert!(crate::read_bytes("DLO4", &archive, &little).is_err());
    // The choice between two is left open; and arrays alone are no capture.
    let (_, bytes) = of("C1.npz");
    let two = [of("C1.npz"), of("C1.json"), ("C2.npz".to_owned(), bytes.clone())];
    assert!(crate::read_bytes("two", &pack(&two.into()), &Limits::default()).is_err());
    let lone = pack(&[("C1.npz".to_owned(), bytes)].into());
    let error = crate::read_bytes("DLO4", &lone, &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("with its .json"), "{error}");
}

#[test]
fn the_description_is_needed_and_indices_must_exist() {
    let folder = tempfile::tempdir().unwrap();
    let npz = write(folder.path(), &[0, 4]);
    let error = crate::read(&npz, &Limits::default()).unwrap_err();
    assert!(matches!(error, Error::PinRange { point: 4, .. }), "{error}");
    std::fs::remove_file(folder.path().join("C1.json")).unwrap();
    let error = crate::read(&npz, &Limits::default()).unwrap_err();
    assert!(matches!(error, Error::MissingFile(_)), "{error}");
}
