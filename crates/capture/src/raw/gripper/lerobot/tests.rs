use std::sync::Arc;

use parquet::{
    basic::Compression,
    data_type::{FloatType, Int64Type},
    file::{properties::WriterProperties, writer::SerializedFileWriter},
    schema::parser::parse_message_type,
};
use proptest::prelude::*;

use super::{super::*, *};
use crate::{Limits, check::testing::pack};

/// Columns as LeRobot writes them.
const SCHEMA: &str = "message schema {
    optional group observation.state (LIST) { repeated group list { optional float element; } }
    optional float timestamp;
    optional int64 frame_index;
    optional int64 episode_index;
}";

/// A file of three episodes of 20 rows at 10 Hz. The state is x, y, z, roll, pitch, yaw, opening.
fn dataset(compression: Compression) -> Vec<u8> {
    let properties = WriterProperties::builder().set_compression(compression).build();
    let schema = Arc::new(parse_message_type(SCHEMA).unwrap());
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties)).unwrap();
    let rows: Vec<(i64, usize)> = (0..3).flat_map(|e| (0..20).map(move |row| (e, row))).collect();
    let state = |(episode, row): (i64, usize)| {
        let time = row as f32 * 0.1;
        [0.1 * episode as f32, 0.0, 0.2 + 0.1 * time, 0.0, 0.0, time, 1.0 - 0.5 * time]
    };
    let states: Vec<f32> = rows.iter().flat_map(|row| state(*row)).collect();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    let repeated: Vec<i16> = (0..states.len()).map(|i| i16::from(i % 7 > 0)).collect();
    let defined = vec![3; states.len()];
    column.typed::<FloatType>().write_batch(&states, Some(&defined), Some(&repeated)).unwrap();
    column.close().unwrap();
    let defined = vec![1; rows.len()];
    let times: Vec<f32> = rows.iter().map(|(_, row)| *row as f32 * 0.1).collect();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<FloatType>().write_batch(&times, Some(&defined), None).unwrap();
    column.close().unwrap();
    for number in [|row: &(i64, usize)| row.1 as i64, |row: &(i64, usize)| row.0] {
        let numbers: Vec<i64> = rows.iter().map(number).collect();
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<Int64Type>().write_batch(&numbers, Some(&defined), None).unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.into_inner().unwrap()
}

fn found(gripper: &str, dataset: Vec<u8>) -> Result<Gripper, Error> {
    let document =
        format!(r#"{{"format": "bendtwin-grippers", "version": 1, "grippers": [{gripper}]}}"#);
    let files = [(DOCUMENT.to_owned(), document.into_bytes()), ("a.parquet".to_owned(), dataset)];
    let archive = pack(&files.into_iter().collect());
    let mut files = Files::from_bytes("case.zip", &archive, &Limits::default())?;
    let frame = Frame::from_up("+z").unwrap();
    // At another rate than the robot's.
    let times_s = times_s(30, 20.0);
    let setting = Setting { times_s: &times_s, frame: &frame, motion: None };
    find(&mut files, &setting, &mut Sources::default()).map(|mut all| all.remove(0))
}

const SECOND: &str = r#"{
    "poses": {"lerobot": {"file": "a.parquet", "episode": 1, "elements": [0, 1, 2, 3, 4, 5], "start_s": 0.8},
              "rotation": "roll_pitch_yaw"},
    "widths": {"lerobot": {"file": "a.parquet", "episode": 1, "elements": [6], "start_s": 0.8}, "scale": 0.08},
    "base": [0, 1, 0, 0, 0, 0, 1]}"#;

#[test]
fn an_episode_is_sampled_at_the_times_of_the_frames() {
    for compression in [Compression::UNCOMPRESSED, Compression::SNAPPY] {
        let gripper = found(SECOND, dataset(compression)).unwrap();
        for frame in 0..30 {
            let time = 0.8 + frame as f64 / 20.0;
            // The episode lasts 1.9 s.
            if time > 1.9 + 0.5 {
                assert!(gripper.poses[frame].is_none() && gripper.widths_m[frame].is_nan());
                continue;
            }
            let time = time.min(1.9);
            let pose = gripper.poses[frame].unwrap();
            let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-5, "{frame}: {a}, not {b}");
            [0.1, 1.0, 0.2 + 0.1 * time]
                .iter()
                .zip(pose.translation)
                .for_each(|(a, b)| near(b, *a));
            near(pose.rotation[0][0], time.cos());
            near(pose.rotation[1][0], time.sin());
            near(gripper.widths_m[frame], 0.08 * (1.0 - 0.5 * time));
        }
    }
}

#[test]
fn contradictions_are_named() {
    let fault = |from: &str, to: &str, words: &str| {
        let changed = SECOND.replace(from, to);
        assert_ne!(changed, SECOND);
        let error = found(&changed, dataset(Compression::SNAPPY)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    fault(r#""episode": 1, "#, "", "several episodes");
    fault(r#""episode": 1"#, r#""episode": 7"#, "no row of episode 7; it has 0, 1, 2");
    fault("[6]", "[7]", "has 7 elements, of which 7");
    fault("4, 5]", "4]", "has 5 `elements` for its pose: name 6");
    fault("roll_pitch_yaw", "quaternion_xyzw", "name 7");
    fault("roll_pitch_yaw", "euler", "`poses` are a file");
    fault(
        r#""episode": 1"#,
        r#""episode": 1, "column": "action""#,
        "no column `action`; it has observation.state, timestamp",
    );
    fault("0.8}", "1e300}", "`start_s`");
    let time = r#""episode": 1, "column": "timestamp""#;
    fault(r#""episode": 1"#, time, "`timestamp` has 1 elements, of which");
    fault("[0, 1, 0, 0, 0, 0, 1]", "[0, 1, 0, null, 0, 0, 0, 1]", "`0` is no pose");
    fault("[0, 1, 0, 0, 0, 0, 1]", "[0, 1, 0]", "the base of gripper `0` is no pose");
    let error = found(SECOND, b"PAR1PAR1".to_vec()).unwrap_err().to_string();
    assert!(error.contains("`a.parquet`") && error.contains("Parquet"), "{error}");
}

#[test]
fn rotations_are_the_same_in_every_form() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let yaw = std::f64::consts::FRAC_PI_2;
    let forms: [(Rotation, &[f64]); 4] = [
        (Rotation::QuaternionXyzw, &[0.0, 0.0, half, half]),
        (Rotation::QuaternionWxyz, &[2.0, 0.0, 0.0, 2.0]),
        (Rotation::Vector, &[0.0, 0.0, yaw]),
        (Rotation::RollPitchYaw, &[0.0, 0.0, yaw]),
    ];
    for (form, numbers) in forms {
        assert_eq!(form.numbers(), numbers.len());
        let quaternion = form.quaternion(numbers);
        let wanted = [0.0, 0.0, half, half];
        assert!(
            quaternion.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12),
            "{quaternion:?}"
        );
    }
    // Yaw after pitch after roll: x is carried to y by roll, to -z by pitch.
    let turn = |rpy: [f64; 3]| {
        Pose::from_quaternion(Rotation::RollPitchYaw.quaternion(&rpy), [0.0; 3]).rotation
    };
    let mixed = turn([0.3, -0.4, 0.5]);
    let by_axis = [turn([0.0, 0.0, 0.5]), turn([0.0, -0.4, 0.0]), turn([0.3, 0.0, 0.0])];
    let [yaw, pitch, roll] = by_axis.map(|rotation| Pose { rotation, ..Pose::IDENTITY });
    let wanted = yaw.after(&pitch).after(&roll).rotation;
    let off = mixed.iter().flatten().zip(wanted.iter().flatten()).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    /// Reading ends, no matter which bytes of a file are damaged.
    #[test]
    fn damage_ends_in_an_error_or_in_poses(
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in proptest::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = dataset(Compression::SNAPPY);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let _ = found(SECOND, bytes);
    }
}
