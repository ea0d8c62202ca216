//! Grippers from a robot's transforms and joints.

use super::made::{Message, ROS, file, healthy, message, stamp, with_extras};
use crate::{
    Error, Limits,
    check::testing::FileMap,
    raw::{
        self, Recording,
        testing::{FRAMES, folder},
    },
};

const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
const RIGHT: &str = r#"{"name": "right", "poses": {"frame": "/right_tcp"},
    "widths": {"joints": ["finger_1", "finger_2"], "scale": 2, "offset_m": -0.01}}"#;

fn document(gripper: &str) -> Vec<u8> {
    format!(r#"{{"format": "bendtwin-grippers", "version": 1, "grippers": [{gripper}]}}"#)
        .into_bytes()
}

/// A robot whose base lies 1 m beside the cameras' world; its hand rises by 1 mm and its fingers close
/// by 1 mm each in every frame. It reports twice a frame, `late_ns` after the cameras.
fn robot(late_ns: i64) -> Vec<Message> {
    let base = [(stamp(0), "world", "base", [1.0, 0.0, 0.0], UPRIGHT)];
    let tool = [(stamp(0), "hand", "right_tcp", [0.0, 0.0, 0.1], UPRIGHT)];
    let mut all = vec![
        message("/tf_static", "TFMessage", stamp(0), ROS.transforms(&base)),
        message("/tf_static", "TFMessage", stamp(0), ROS.transforms(&tool)),
    ];
    for half in 0..2 * FRAMES {
        let (frames, ns) =
            (half as f64 / 2.0, stamp(0) + late_ns + half as i64 * (stamp(1) - stamp(0)) / 2);
        let hand = [(ns, "base", "hand", [0.0, 0.0, 0.2 + 0.001 * frames], UPRIGHT)];
        all.push(message("/tf", "TFMessage", ns, ROS.transforms(&hand)));
        let fingers = [
            ("finger_1", 0.03 - 0.001 * frames),
            ("arm_7", 1.5),
            ("finger_2", 0.03 - 0.001 * frames),
        ];
        all.push(message("/joint_states", "JointState", ns, ROS.joints(ns, &fingers)));
    }
    all
}

fn opened(files: &FileMap) -> Result<Recording, Error> {
    raw::open(folder(files).path(), &Limits::default())
}

fn beside(messages: &[Message], gripper: &str) -> Result<Recording, Error> {
    let files =
        [("a.mcap".to_owned(), file(messages)), ("grippers.json".to_owned(), document(gripper))];
    opened(&files.into_iter().collect())
}

fn expect_moves(recording: &Recording) {
    let [gripper] = recording.grippers.as_slice() else { panic!("{:?}", recording.grippers) };
    assert_eq!((gripper.name.as_str(), gripper.poses.len()), ("right", FRAMES));
    for (frame, (pose, width)) in gripper.poses.iter().zip(&gripper.widths_m).enumerate() {
        let risen = 0.001 * frame as f64;
        let wanted = [1.0, 0.0, 0.3 + risen];
        let at = pose.unwrap().translation;
        assert!(at.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-5), "{frame}: {at:?}");
        assert!((width - (2.0 * (0.06 - 2.0 * risen) - 0.01)).abs() < 1e-5, "{frame}: {width}");
    }
}

#[test]
fn frames_and_joints_become_grippers() {
    let messages = [healthy(), robot(0)].concat();
    expect_moves(&beside(&messages, RIGHT).unwrap());
    // The document attached to the file, in a folder and alone.
    let whole = with_extras(&messages, &[], &[("grippers.json", &document(RIGHT))]);
    let map: FileMap = [("a.mcap".to_owned(), whole)].into_iter().collect();
    expect_moves(&opened(&map).unwrap());
    let folder = folder(&map);
    let alone = raw::open(&folder.path().join("a.mcap"), &Limits::default()).unwrap();
    expect_moves(&alone);
    let taken = alone.sources.taken.iter().find(|taken| taken.part == "gripper").unwrap();
    assert_eq!(taken.form, "frame `/right_tcp`, joints finger_1, finger_2");
}

#[test]
fn what_was_reported_at_another_time_is_unknown() {
    let messages = [healthy(), robot(10_000_000_000)].concat();
    let error = beside(&messages, RIGHT).unwrap_err().to_string();
    assert!(error.contains("gripper `right` has no pose in any frame"), "{error}");
}

#[test]
fn unknown_names_are_answered_with_the_known_ones() {
    let messages = [healthy(), robot(0)].concat();
    let fault = |gripper: &str, words: &[&str]| {
        let error = beside(&messages, gripper).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    fault(r#"{"poses": {"frame": "left_tcp"}}"#, &["`left_tcp` and `world`", "base", "hand"]);
    let joints = r#"{"poses": {"frame": "hand"}, "widths": {"joints": ["finger"]}}"#;
    fault(joints, &["joint `finger`", "arm_7, finger_1, finger_2"]);
    fault(r#"{"poses": {"frames": "hand"}}"#, &["`poses` are a file", "section 15"]);
    let based = r#"{"poses": {"frame": "hand"}, "base": [0, 0, 0, 0, 0, 0, 1]}"#;
    fault(based, &["leave out `base`"]);
    let wide = r#"{"poses": {"frame": "hand"}, "widths": {"joints": ["arm_7"]}}"#;
    fault(wide, &["open by 1.5", "`scale` and `offset_m`"]);
    let apart = [
        robot(0),
        vec![message(
            "/tf",
            "TFMessage",
            stamp(0),
            ROS.transforms(&[(stamp(0), "mocap", "hand", [0.0; 3], UPRIGHT)]),
        )],
    ]
    .concat();
    let error = beside(&[healthy(), apart].concat(), RIGHT).unwrap_err().to_string();
    assert!(error.contains("`hand` has several parents"), "{error}");
    // A file beside an attachment has no folder.
    let document = document(r#"{"poses": "poses.npy"}"#);
    let whole = with_extras(&messages, &[], &[("grippers.json", &document)]);
    let folder = folder(&[("a.mcap".to_owned(), whole)].into_iter().collect());
    let error = raw::open(&folder.path().join("a.mcap"), &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("into one folder or archive"), "{error}");
}

#[test]
fn joints_of_two_topics_are_distinguished() {
    let fingers = [("finger_1", 0.5), ("finger_2", 0.5)];
    let other = message("/commands", "JointState", stamp(1), ROS.joints(stamp(1), &fingers));
    let messages = [healthy(), robot(0), vec![other]].concat();
    let error = beside(&messages, RIGHT).unwrap_err().to_string();
    assert!(error.contains("(/commands, /joint_states): name one (`topic`)"), "{error}");
    let of =
        |topic: &str| RIGHT.replace("\"scale\"", &format!("\"topic\": \"{topic}\", \"scale\""));
    expect_moves(&beside(&messages, &of("/joint_states")).unwrap());
    let error = beside(&messages, &of("/joints")).unwrap_err().to_string();
    assert!(error.contains("`/joints` has no joint `finger_1`"), "{error}");
}

#[test]
fn damaged_joints_refuse_nothing() {
    let mut messages = [healthy(), robot(0)].concat();
    for m in messages.iter_mut().filter(|m| m.kind == "JointState") {
        m.data.truncate(9);
    }
    assert!(beside(&messages, r#"{"poses": {"frame": "hand"}}"#).is_ok());
    let error = beside(&messages, RIGHT).unwrap_err().to_string();
    assert!(error.contains("joints with one are none"), "{error}");
}
