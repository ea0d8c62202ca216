use super::*;
use crate::testing::TestScene;

fn identity() -> Identity {
    let recording = TestScene { frames: 2, ..TestScene::default() }.recording();
    Identity::of(&recording, &[None, None], &IngestSettings::default())
}

#[test]
fn a_checkpoint_is_read_back() {
    let mut checkpoint = Checkpoint::default();
    checkpoint.units.push(UnitSurvey { missing_frames: 3, ..UnitSurvey::default() });
    let bytes = checkpoint.to_bytes(&identity()).unwrap();
    assert_eq!(Checkpoint::from_bytes(&bytes, &identity(), 2, 4).unwrap(), checkpoint);
    for wrong in [&bytes[..bytes.len() - 1], &bytes[..3], &bytes[..6], b"other"] {
        let error = Checkpoint::from_bytes(wrong, &identity(), 2, 4).unwrap_err();
        assert!(matches!(error, Error::Checkpoint(_)), "{error}");
    }
    assert!(Checkpoint::from_bytes(&bytes, &identity(), 2, 0).is_err());
}

#[test]
fn inputs_that_change_the_result_change_the_identity() {
    let scene = || TestScene { frames: 2, ..TestScene::default() }.recording();
    let settings = IngestSettings::default();
    let mut other = scene();
    other.cameras[1].intrinsics.cx += 1e-9;
    assert_ne!(Identity::of(&other, &[None, None], &settings), identity());
    let tracks = raw::Tracks { count: 1, points: vec![[0.0; 2]; 2], visible: vec![true; 2] };
    assert_ne!(Identity::of(&scene(), &[None, Some(tracks)], &settings), identity());
    let coarse = IngestSettings { spacing_m: 0.01, ..settings };
    assert_ne!(Identity::of(&scene(), &[None, None], &coarse), identity());
}
