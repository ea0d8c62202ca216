use super::*;
use crate::{Limits, check::testing::pack};

fn found(document: &str, frames: usize) -> Result<Vec<Gripper>, Error> {
    let limits = Limits::default();
    let rows = [0.1_f64, 0.2, 0.3, 0.0, 0.0, 0.0, 2.0].repeat(2);
    let data: Vec<u8> = rows.iter().flat_map(|x| x.to_le_bytes()).collect();
    let poses = crate::npy::write("<f8", &[2, 7], &data);
    let files =
        [(DOCUMENT.to_owned(), document.as_bytes().to_vec()), ("poses.npy".to_owned(), poses)];
    let archive = pack(&files.into_iter().collect());
    let mut files = Files::from_bytes("case.zip", &archive, &limits)?;
    let frame = Frame::from_up("-z").unwrap();
    let times_s = times_s(frames, 30.0);
    let setting = Setting { times_s: &times_s, frame: &frame, motion: None };
    find(&mut files, &setting, &mut Sources::default())
}

fn document(gripper: &str) -> String {
    format!(r#"{{"format": "bendtwin-grippers", "version": 1, "grippers": [{gripper}]}}"#)
}

#[test]
fn poses_come_from_a_file_or_the_document() {
    let read =
        found(&document(r#"{"name": "left", "poses": "poses.npy", "widths": [0.04, null]}"#), 2);
    let gripper = read.unwrap().remove(0);
    // The world of the case points down.
    let pose = gripper.poses[1].unwrap();
    assert_eq!(pose.translation.map(|x| (x * 1e6).round() / 1e6), [0.1, -0.2, -0.3]);
    assert_eq!(pose.rotation[2][2], -1.0);
    assert!(gripper.widths_m[0] == 0.04 && gripper.widths_m[1].is_nan());
    let rows = r#"{"poses": [[0, 0, 1, 0, 0, 0, 1], [null, 0, 0, 0, 0, 0, 1]]}"#;
    let gripper = found(&document(rows), 2).unwrap().remove(0);
    assert_eq!((gripper.name.as_str(), gripper.poses[1]), ("0", None));
    assert!(gripper.widths_m.is_empty());
}

#[test]
fn axes_may_have_other_names() {
    let rows = r#"{"poses": [[0, 0, 0, 0, 0, 0, 1]], "axes": {"approach": "+x", "opening": "-y"}}"#;
    let pose = found(&document(rows), 1).unwrap().remove(0).poses[0].unwrap();
    // What points out of the gripper, z here, is x of the recorded pose; the world is turned about x.
    assert_eq!(pose.rotation.map(|row| row[2]), [1.0, 0.0, 0.0]);
    assert_eq!(pose.rotation.map(|row| row[1]), [0.0, 1.0, 0.0]);
}

#[test]
fn contradictions_are_named() {
    let fault = |gripper: &str, words: &str| {
        let error = found(&document(gripper), 2).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    fault(r#"{"poses": [[0, 0, 0, 0, 0, 0, 1]]}"#, "2 rows, one a frame");
    fault(r#"{"poses": "../poses.npy"}"#, "no relative path");
    fault(r#"{"poses": "poses.npy", "widths": [40, 40]}"#, "open by 40");
    fault(r#"{"poses": "poses.npy", "widths": [0.04]}"#, "1 widths for 2 frames");
    fault(
        r#"{"poses": "poses.npy", "axes": {"approach": "z", "opening": "-z"}}"#,
        "two different axes",
    );
    fault(r#"{"poses": "poses.npy", "axes": {"approach": "q", "opening": "y"}}"#, "must be one of");
    fault(r#"{"poses": [[0, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 1]]}"#, "not finite");
    fault(r#"{"poses": [[null, 0, 0, 0, 0, 0, 1], [null, 0, 0, 0, 0, 0, 1]]}"#, "no pose");
    assert!(found("{}", 2).is_err());
}
