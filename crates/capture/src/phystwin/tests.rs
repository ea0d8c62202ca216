use std::path::Path;

use super::json;
use crate::{Limits, read};

#[derive(Debug, serde::Deserialize)]
#[expect(dead_code, reason = "only its form is of interest")]
struct Document {
    fps: f64,
    cameras: Vec<Camera>,
}

#[derive(Debug, serde::Deserialize)]
#[expect(dead_code, reason = "only its form is of interest")]
struct Camera {
    size: [usize; 2],
}

#[test]
fn a_fault_of_a_document_is_named_with_its_field() {
    let fault = |text: &str| json::<Document>(text.as_bytes(), "a.json").unwrap_err().to_string();
    for (text, words) in [
        (r#"{"fps": [30], "cameras": []}"#, "`fps`: invalid type: sequence, expected f64"),
        (r#"{"fps": 30, "cameras": [{"size": [8, -6]}]}"#, "`cameras[0].size[1]`: invalid value"),
        (r#"{"fps": 30}"#, "missing field `cameras`"),
        (r#"{"fps": 30, "cameras": [{}]}"#, "`cameras[0]`: missing field `size`"),
        (r#"{"fps": 30, "#, "EOF while parsing a value at line 1 column 12"),
        (r#"{"fps": 30, "cameras": []} x"#, "trailing characters at line 1 column 28"),
    ] {
        let found = fault(text);
        assert!(found.contains(words), "{found} lacks {words}");
        assert!(words.contains("line") || !found.contains("column"), "{found}");
    }
}

#[test]
fn a_case_is_turned_to_z_up() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/case");
    let capture = read(&folder, &Limits::default()).unwrap();
    let sequence = &capture.sequences[0];
    assert_eq!(
        (sequence.frame_count, capture.object.point_count, sequence.control_count()),
        (6, 24, 4)
    );
    assert_eq!((sequence.train_frame_count, sequence.truth_count(), capture.fps), (4, 3, 30.0));
    assert_eq!(capture.source_to_world, [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]);
    // Point 0 of frame 0 is (0, 0, -0.06) in the file.
    let [x, y, z] = sequence.points_at(0)[0];
    assert_eq!((x, y.abs()), (0.0, 0.0));
    assert!((z - 0.06).abs() < 1e-6);
    assert!(sequence.points.iter().zip(&sequence.visible).all(|(p, v)| !v || p[2] > 0.0));
}

#[test]
fn motion_flags_move_to_the_frame_that_they_lead_to() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/case");
    let capture = read(&folder, &Limits::default()).unwrap();
    let sequence = &capture.sequences[0];
    assert!(sequence.motion_valid_at(0).iter().all(|v| !v));
    // Point 5 is hidden in frame 3 only.
    let flags: Vec<bool> = (0..6).map(|f| sequence.motion_valid_at(f)[5]).collect();
    assert_eq!(flags, [false, true, true, false, false, true]);
}
