use std::fmt::Write as _;

use bendtwin_core::Severity;

use super::*;
use crate::{Opened, check::testing::pack, check_path, open, read_bytes};

/// Written by the packages `c3d` and `ezc3d`: `tests/markers/make.py`.
const C3D: [(&str, &[u8]); 2] = [
    ("c3d", include_bytes!("../../../tests/markers/c3d_package.c3d")),
    ("ezc3d", include_bytes!("../../../tests/markers/ezc3d.c3d")),
];

fn opened(name: &str, bytes: &[u8]) -> (Capture, Remarks) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    match open(&path, &Limits::default()).unwrap() {
        Opened::Observed(capture, remarks) => (capture, remarks),
        _ => panic!("{name} is not observed"),
    }
}

fn lines(remarks: &Remarks) -> String {
    remarks.sources.lines().collect::<Vec<_>>().join("\n")
}

fn near(p: Point, q: Point) -> bool {
    p.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn c3d_of_two_writers_is_one_capture() {
    for (writer, bytes) in C3D {
        // The name does not say what it is: a server stores files without one.
        let (capture, remarks) = opened("upload", bytes);
        let sequence = &capture.sequences[0];
        assert_eq!((capture.fps, sequence.frame_count), (100.0, 20), "{writer}");
        assert_eq!((capture.object.point_count, sequence.control_count()), (6, 3), "{writer}");
        assert!(
            near(sequence.points_at(4)[0], [0.0, 0.104, 0.5]),
            "{:?}",
            sequence.points_at(4)[0]
        );
        assert!(near(sequence.controls_at(19)[2], [0.02, 0.109, 0.52]));
        let hidden: Vec<usize> = (0..20).filter(|f| !sequence.visible_at(*f)[2]).collect();
        assert_eq!(hidden, [5, 6, 7], "{writer}");
        assert!(sequence.points.iter().flatten().all(|x| x.is_finite()));
        assert_eq!(capture.object.edges.len(), 5, "a rope is a chain");
        assert_eq!(capture.environment.ground.unwrap().offset_m, 0.0);
        let text = lines(&remarks);
        for part in [
            "6 markers (rope1, rope2",
            "C3D, 100 fps, mm, +z up, by POINT:Y_SCREEN",
            "hand: 3 markers",
        ] {
            assert!(text.contains(part), "{writer}: {text}");
        }
    }
}

/// A file as Motive exports it: a rope of eight markers in a marker set, a gripper as a rigid body with
/// its markers as seen and as solved, and a marker that nobody labelled. Metres with y up.
fn motive(units: &str, with_gripper: bool) -> String {
    let scale = if units == "Millimeters" { 1000.0 } else { 1.0 };
    let mut things: Vec<(String, String, usize)> =
        (0..8).map(|i| ("Marker".to_owned(), format!("rope:M{i:02}"), 3)).collect();
    things.push(("Marker".to_owned(), "Unlabeled 2041".to_owned(), 3));
    if with_gripper {
        things.push(("Rigid Body".to_owned(), "Gripper 1".to_owned(), 7));
        for i in 1..=3 {
            things.push(("Rigid Body Marker".to_owned(), format!("Gripper 1:Marker {i}"), 3));
            things.push(("Marker".to_owned(), format!("Gripper 1:Marker {i}"), 3));
        }
    }
    let mut text = format!(
        "Format Version,1.23,Take Name,\"Take, 1\",Capture Frame Rate,120.000000,Export Frame Rate,60.000000,\
         Rotation Type,Quaternion,Length Units,{units},Coordinate Space,Global\r\n\r\n"
    );
    let mut row = |first: &str, second: &str, cell: &dyn Fn(usize, usize) -> String| {
        let cells: String = things
            .iter()
            .enumerate()
            .flat_map(|(thing, (_, _, columns))| (0..*columns).map(move |c| (thing, c)))
            .map(|(thing, column)| format!(",{}", cell(thing, column)))
            .collect();
        let _ = write!(text, "{first},{second}{cells}\r\n");
    };
    row("", "Type", &|thing, _| things[thing].0.clone());
    row("", "Name", &|thing, _| format!("\"{}\"", things[thing].1));
    row("", "ID", &|thing, _| format!("\"{thing:X}\""));
    let is_rotation = |thing: usize, column: usize| things[thing].2 == 7 && column < 4;
    row("", "", &|thing, column| {
        if is_rotation(thing, column) { "Rotation" } else { "Position" }.to_owned()
    });
    row("Frame", "Time (Seconds)", &|thing, column| {
        let axes = if things[thing].2 == 7 {
            &["X", "Y", "Z", "W", "X", "Y", "Z"][..]
        } else {
            &["X", "Y", "Z"]
        };
        axes[column].to_owned()
    });
    for frame in 0..30 {
        let bend = 0.3 + 0.1 * f64::from(frame);
        row(&frame.to_string(), &format!("{:.6}", f64::from(frame) / 60.0), &|thing, column| {
            let angle = bend * 0.05 * thing as f64;
            let p = match thing {
                0..8 => [angle.sin() / bend, 0.4 + (1.0 - angle.cos()) / bend, 0.2],
                8 if frame % 2 == 1 => return String::new(),
                // Markers that were seen have gaps, the body's own solution has none.
                _ if things[thing].0 == "Marker" && frame > 20 => return String::new(),
                _ => [0.01 * thing as f64, 0.4, 0.2],
            };
            match (things[thing].2, column) {
                (7, 0..3) => "0.0".to_owned(),
                (7, 3) => "1.0".to_owned(),
                (7, _) => format!("{:.6}", scale * p[column - 4]),
                _ => format!("{:.6}", scale * p[column]),
            }
        });
    }
    text
}

#[test]
fn csv_of_motive_has_its_rigid_bodies_as_control_points() {
    for units in ["Meters", "Millimeters"] {
        let (capture, remarks) = opened("take.csv", motive(units, true).as_bytes());
        let sequence = &capture.sequences[0];
        assert_eq!((capture.fps, sequence.frame_count), (60.0, 30));
        assert_eq!((capture.object.point_count, sequence.control_count()), (8, 3));
        // Y points up.
        assert!(near(sequence.points_at(0)[0], [0.0, -0.2, 0.4]), "{:?}", sequence.points_at(0)[0]);
        assert!(near(sequence.controls_at(25)[0], sequence.controls_at(0)[0]));
        let text = lines(&remarks);
        for part in [
            "object: 8 markers (rope:M00",
            "CSV of OptiTrack Motive, 60 fps",
            "+y up, as Motive has it",
            "hand: 3 markers (Gripper 1:Marker 1",
            "left out: Unlabeled 2041: it has no label",
            "left out: Gripper 1:Marker 1: the body's own solution",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
        assert!(remarks.findings.is_empty(), "{:?}", remarks.findings);
    }
}

#[test]
fn a_body_without_markers_has_points_around_its_pivot() {
    let text = motive("Meters", true).replace("Gripper 1:Marker", "Unlabeled");
    let (capture, remarks) = opened("take.csv", text.as_bytes());
    let controls = capture.sequences[0].controls_at(3);
    assert_eq!(controls.len(), 4, "{}", lines(&remarks));
    assert!(near(controls[1], [controls[0][0] + 0.02, controls[0][1], controls[0][2]]));
    // The body's y is up in the world's z.
    assert!(near(controls[2], [controls[0][0], controls[0][1], controls[0][2] + 0.02]));
}

#[test]
fn what_holds_the_object_may_be_declared() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("take.csv");
    std::fs::write(&path, motive("Meters", false)).unwrap();
    let report = check_path(&path, &Limits::default());
    let codes: Vec<(&str, Severity)> =
        report.findings.iter().map(|f| (f.code.as_str(), f.severity)).collect();
    assert_eq!(codes, [("HELD_MARKERS_UNKNOWN", Severity::Warning)], "{report:?}");
    let advice = &report.findings[0].advice;
    assert!(advice.contains("take.json") && advice.contains("cameras.md#grippers"), "{advice}");
    assert!(described(&path).is_none());

    std::fs::write(path.with_extension("json"), r#"{"held": ["M00", "rope:M07"]}"#).unwrap();
    let (capture, remarks) = read_file(&path, &Limits::default()).unwrap();
    assert_eq!(capture.object.pins.iter().map(|p| p.point).collect::<Vec<_>>(), [0, 7]);
    assert_eq!(capture.sequences[0].controls_at(9)[1], capture.sequences[0].points_at(9)[7]);
    assert!(remarks.findings.is_empty());
    assert_eq!(described(&path).unwrap().files, ["take.csv", "take.json"]);
    let report = check_path(&path, &Limits::default());
    assert!(report.findings.is_empty(), "{:?}", report.findings);

    for (document, word) in [
        (r#"{"held": ["M99"]}"#, "M99"),
        (r#"{"helt": ["M00"]}"#, "helt"),
        (r#"{"units": "inch"}"#, "inch"),
        (r#"{"up_axis": "up"}"#, "up_axis"),
    ] {
        std::fs::write(path.with_extension("json"), document).unwrap();
        let error = read_file(&path, &Limits::default()).unwrap_err().to_string();
        assert!(error.contains(word), "{document}: {error}");
    }
}

/// A TRC file of a rope and a hand in millimetres; `up` is the axis that points up.
fn trc(up: usize) -> String {
    let mut text = "PathFileType\t4\t(X/Y/Z)\trope.trc\n\
                    DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n\
                    50.00\t50.00\t12\t6\tmm\t50.00\t1\t12\n\
                    Frame#\tTime"
        .to_owned();
    let names = ["r1", "r2", "r3", "r4", "r5", "L.Hand"];
    names.iter().for_each(|name| text += &format!("\t{name}\t\t"));
    text += "\n\t\t";
    (1..=6).for_each(|i| text += &format!("X{i}\tY{i}\tZ{i}\t"));
    text += "\n\n";
    for frame in 0..12 {
        text += &format!("{}\t{:.4}", frame + 1, f64::from(frame) / 50.0);
        for i in 0..6 {
            let bend = 0.5 + 0.3 * f64::from(frame);
            let angle = bend * 0.06 * f64::from(i);
            let mut p = [-300.0; 3];
            p[(up + 1) % 3] = 1000.0 * angle.sin() / bend - 200.0;
            p[up] = 250.0 + 1000.0 * (1.0 - angle.cos()) / bend;
            if i == 1 && frame == 4 {
                text += "\t\t\t";
            } else {
                p.iter().for_each(|x| text += &format!("\t{x:.5}"));
            }
        }
        text += "\n";
    }
    text
}

#[test]
fn trc_has_y_up_unless_its_points_say_otherwise() {
    for (up, words) in
        [(1, "+y up, as is usual"), (2, "+z up, since points lie above the ground so")]
    {
        let (capture, remarks) = opened("rope.trc", trc(up).as_bytes());
        let sequence = &capture.sequences[0];
        assert_eq!((capture.fps, sequence.frame_count), (50.0, 12));
        assert_eq!((capture.object.point_count, sequence.control_count()), (5, 1));
        assert!(
            (sequence.points_at(0)[0][2] - 0.25).abs() < 1e-5,
            "{:?}",
            sequence.points_at(0)[0]
        );
        assert!(!sequence.visible_at(4)[1] && sequence.visible_at(5)[1]);
        assert!(lines(&remarks).contains(words), "{}", lines(&remarks));
    }
}

#[test]
fn a_file_may_lie_in_a_folder_or_an_archive() {
    let (_, bytes) = C3D[0];
    let alone = opened("rope.c3d", bytes).0;
    let archive = pack(&[("rope.c3d".to_owned(), bytes.to_vec())].into());
    let packed = read_bytes("rope", &archive, &Limits::default()).unwrap();
    assert_eq!(packed, alone);
    assert_eq!(read_bytes("rope", bytes, &Limits::default()).unwrap(), alone);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("rope.c3d"), bytes).unwrap();
    let read = crate::files_read(folder.path(), &Limits::default()).unwrap();
    assert_eq!(read.files, ["rope.c3d"]);
    assert!(read.format.contains("C3D"));
    // The choice between two is left open.
    std::fs::write(folder.path().join("take.csv"), motive("Meters", true)).unwrap();
    let error = open(folder.path(), &Limits::default()).unwrap_err();
    assert!(matches!(error, Error::Several(_)), "{error}");
    // Another CSV file is no capture.
    let other = tempfile::tempdir().unwrap();
    std::fs::write(other.path().join("notes.csv"), "a,b\n1,2\n").unwrap();
    let error = open(other.path(), &Limits::default()).unwrap_err();
    assert!(matches!(error, Error::UnknownKind { .. }), "{error}");
}

#[test]
fn damage_and_limits_are_refused() {
    let (_, bytes) = C3D[0];
    for length in [514, 1000, 1500, bytes.len() - 1200] {
        assert!(read_bytes("cut", &bytes[..length], &Limits::default()).is_err(), "{length}");
    }
    let text = motive("Meters", true);
    for (name, bytes) in [("c3d", bytes), ("csv", text.as_bytes()), ("trc", trc(1).as_bytes())] {
        let reason = |limits: Limits| {
            use bendtwin_core::Problem as _;
            read_bytes("small", bytes, &limits).unwrap_err().reason()
        };
        let most = Limits::default();
        assert_eq!(reason(Limits { frames: 5, ..most.clone() }), "CAPTURE_TOO_MANY", "{name}");
        assert_eq!(reason(Limits { points: 4, ..most.clone() }), "CAPTURE_TOO_MANY", "{name}");
        assert_eq!(reason(Limits { controls: 0, ..most.clone() }), "CAPTURE_TOO_MANY", "{name}");
        assert_eq!(reason(Limits { total_bytes: 1000, ..most }), "CAPTURE_TOO_LARGE", "{name}");
    }
    for text in [
        "Format Version,1.23\n",
        "PathFileType\t4\nx\ny\nz\n",
        "PathFileType\n\n\nFrame#\tTime\tr1\n",
        &text.replace("Meters", "Feet"),
        &trc(1)
            .replace("50.00\t12\t", "50.00\t900\t")
            .replace("50.00\t50.00\t12", "50.00\t50.00\t900"),
    ] {
        assert!(read_bytes("wrong", text.as_bytes(), &Limits::default()).is_err(), "{text:.80}");
    }
}

#[test]
fn lines_of_separators_are_charged_before_they_are_taken_apart() {
    let limits = Limits { total_bytes: 100_000, ..Limits::default() };
    let text = format!("PathFileType\t4\n{}\n30\nFrame#\tTime\n", "\t".repeat(1000));
    let read = trc::read("a.trc", &text, &limits, &mut Budget::new(&limits));
    assert!(matches!(read, Err(Error::TooLarge { .. })));
    let text = format!("Format Version,1.23\n{}\n", ",".repeat(1000));
    let read = csv::read("a.csv", &text, &limits, &mut Budget::new(&limits));
    assert!(matches!(read, Err(Error::TooLarge { .. })));
    let limits = Limits { frames: 2, ..Limits::default() };
    let text = format!("PathFileType\n\n\nFrame#\tTime\ta\n{}", "1\t0\t1\t2\t3\n".repeat(3));
    let read = trc::read("a.trc", &text, &limits, &mut Budget::new(&limits));
    assert!(matches!(read, Err(Error::TooMany { .. })));
}
