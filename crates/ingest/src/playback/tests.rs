use bendtwin_capture::raw;
use bendtwin_core::CancelToken;
use bendtwin_synth::{FilmOptions, MakeOptions, Scene, film, make};
use serde_json::Value;

use super::*;

/// A playback that was written, taken apart.
struct Parsed {
    head: Value,
    data: Vec<u8>,
}

impl Parsed {
    fn of(capture: &Capture, recorded: &[Option<Recording>]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("playback");
        let mut reported = Vec::new();
        let played = Played { name: &capture.name, capture: Some(capture), recorded, doubt: &[] };
        write_playback(played, &path, &mut |share| reported.push(share)).unwrap();
        assert!(reported.is_sorted() && reported.last() == Some(&1.0), "{reported:?}");
        Self::read(&path)
    }

    fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        assert_eq!(&bytes[..8], PLAYBACK_MAGIC);
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((number(8), number(12) % 8), (1, 0));
        let end = 16 + number(12);
        let head = serde_json::from_slice(&bytes[16..end]).unwrap();
        Self { head, data: bytes[end..].to_vec() }
    }

    fn range(&self, at: &str) -> &[u8] {
        let range = self.head.pointer(at).unwrap();
        let [first, length] = [0, 1].map(|i| range[i].as_u64().unwrap() as usize);
        &self.data[first..first + length]
    }
}

fn rope() -> Capture {
    make(Scene::Rope, &MakeOptions::tiny(1)).unwrap()
}

#[test]
fn a_capture_of_points_has_its_motion_and_no_images() {
    let capture = rope();
    let parsed = Parsed::of(&capture, &[]);
    let sequence = &capture.sequences[0];
    let (frames, points) = (sequence.frame_count, capture.object.point_count);
    let entry = &parsed.head["sequences"][0];
    assert_eq!(entry["motion"]["point_count"], points);
    assert_eq!((&entry["frame_count"], &entry["cameras"]), (&frames.into(), &Value::Array(vec![])));
    assert_eq!(entry["train_frame_count"], sequence.train_frame_count);
    let at = |name: &str| format!("/sequences/0/motion/{name}");
    let numbers = parsed.range(&at("points"));
    assert_eq!(numbers.len(), 6 * frames * points);
    assert_eq!(parsed.range(&at("visible")).len(), frames * points.div_ceil(8));
    let controls = parsed.range(&at("controls"));
    assert_eq!(controls.len(), 6 * frames * sequence.control_count());
    // The last control point of the last frame is where it was.
    let scale = entry["motion"]["scale_m"].as_f64().unwrap();
    let last = sequence.controls.last().unwrap();
    for (axis, bytes) in controls[controls.len() - 6..].chunks(2).enumerate() {
        let number = f64::from(i16::from_le_bytes([bytes[0], bytes[1]]));
        let metres = entry["motion"]["origin"][axis].as_f64().unwrap() + scale * number;
        assert!((metres - f64::from(last[axis])).abs() < scale, "{metres} {last:?}");
    }
    assert_eq!(parsed.data.len() % 2, 0);
}

#[test]
fn a_recording_of_cameras_has_images_that_decode() {
    let recording = film(Scene::Toy, &FilmOptions::tiny(1)).unwrap();
    let observed = bendtwin_lift::lift(
        &recording,
        &Default::default(),
        None,
        &mut (),
        &CancelToken::default(),
    );
    let capture = observed.unwrap().capture;
    let parsed = Parsed::of(&capture, &[Some(recording.clone())]);
    let cameras = parsed.head["sequences"][0]["cameras"].as_array().unwrap();
    assert_eq!(cameras.len(), recording.cameras.len());
    for (index, (entry, camera)) in cameras.iter().zip(&recording.cameras).enumerate() {
        let at = |name: &str| format!("/sequences/0/cameras/{index}/{name}");
        assert_eq!(entry["intrinsics"]["fx"], camera.intrinsics.fx);
        let poses = parsed.range(&at("poses"));
        assert_eq!(poses.len(), 48);
        let z = f32::from_le_bytes(poses[44..48].try_into().unwrap());
        assert!((f64::from(z) - camera.poses[0].translation[2]).abs() < 1e-6);
        let lengths = entry["images"]["lengths"].as_array().unwrap();
        assert_eq!(lengths.len(), recording.frame_count);
        let files = parsed.range(&at("images/bytes"));
        let total: u64 = lengths.iter().map(|n| n.as_u64().unwrap()).sum();
        assert_eq!(files.len() as u64, total);
        assert!(files.starts_with(&[0xff, 0xd8]) && files.ends_with(&[0xff, 0xd9]));
    }
}

#[test]
fn the_bound_holds_for_long_and_for_many_sequences() {
    let mut capture = rope();
    let sequence = capture.sequences[0].clone();
    let size = |most| motion::bytes(&sequence, capture.object.point_count, most);
    assert_eq!(Plan::new(&capture), Plan { sequences: 1, most: MAX_POINTS });
    let few = MOTION_BYTES / size(MAX_POINTS);
    capture.sequences = vec![sequence.clone(); 3 * few];
    let plan = Plan::new(&capture);
    assert!(plan.sequences == 3 * few && plan.most < capture.object.point_count, "{plan:?}");
    assert!(3 * few * size(plan.most) <= MOTION_BYTES);
    // Not even a point of each.
    let all = MOTION_BYTES / size(1);
    capture.sequences = vec![Sequence { name: "n".repeat(300), ..sequence }; all + 2];
    assert_eq!(Plan::new(&capture), Plan { sequences: all, most: 1 });
    let parsed = Parsed::of(&capture, &[]);
    assert_eq!(parsed.head["left_out"], 2);
    assert_eq!(parsed.head["sequences"][0]["name"].as_str().unwrap().len(), 200);
    assert!(parsed.data.len() <= MOTION_BYTES);
}

#[test]
fn a_recording_without_points_has_its_images_and_masks() {
    let mut recording = film(Scene::Toy, &FilmOptions::tiny(1)).unwrap();
    recording.cameras[1].poses.clear();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("playback");
    let doubt = [vec![Some(0.25), None]];
    let recorded = [Some(recording.clone())];
    let played = Played { name: "toy", capture: None, recorded: &recorded, doubt: &doubt };
    write_playback(played, &path, &mut |_| {}).unwrap();
    let parsed = Parsed::read(&path);
    let sequence = &parsed.head["sequences"][0];
    assert_eq!(sequence["motion"]["point_count"], 0);
    let camera = &sequence["cameras"][0];
    assert_eq!(camera["doubt"], serde_json::json!([0.25, null]));
    assert!(sequence["cameras"][1]["doubt"].is_null());
    assert_eq!(sequence["cameras"][1]["poses"][1], 0, "it is not calibrated");
    // The runs of the first image have as many pixels of the object as its mask.
    let first = camera["masks"]["lengths"][0].as_u64().unwrap() as usize;
    let (mut pixels, mut object, mut number, mut shift) = (0, 0, 0_u64, 0);
    for byte in &parsed.range("/sequences/0/cameras/0/masks/bytes")[..first] {
        number |= u64::from(byte & 0x7f) << shift;
        shift += 7;
        if byte & 0x80 == 0 {
            pixels += number / 4;
            object += if number % 4 == 1 { number / 4 } else { 0 };
            (number, shift) = (0, 0);
        }
    }
    let camera = &recording.cameras[0];
    assert_eq!(pixels as usize, camera.width * camera.height);
    let mut frames = recording.source.frames(0).unwrap();
    let mut count = |region| {
        let mask = frames.mask(0, region).unwrap().unwrap();
        mask.pixels.into_iter().collect::<Vec<bool>>()
    };
    let (wanted, hand) = (count(raw::Region::Object), count(raw::Region::Manipulator));
    let shown = wanted.iter().zip(&hand).filter(|(object, hand)| **object && !**hand).count();
    assert_eq!(object as usize, shown);
}
