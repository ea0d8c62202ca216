use bendtwin_core::Problem;
use proptest::prelude::*;

use super::*;

fn identity(digest: &str) -> Identity {
    Identity {
        capture_digest: digest.into(),
        settings: FitSettings::default(),
        backend: "cpu".into(),
    }
}

fn checkpoint() -> Checkpoint {
    let search = CmaEs::new(vec![0.5; 3], 0.2, 0, 7);
    Checkpoint {
        models: vec![ModelFitState::Search(search)],
        chosen: vec![ChosenStart { model: 1, losses: vec![f64::INFINITY, 0.25] }],
        generations: Some(7),
        spent_s: 2.5,
        trainings: vec![vec![1, 2, 3]],
    }
}

#[test]
fn survives_the_way_to_bytes_and_back() {
    let bytes = checkpoint().to_bytes(&identity("a")).unwrap();
    assert_eq!(Checkpoint::from_bytes(&bytes, &identity("a")).unwrap(), checkpoint());
}

#[test]
fn belongs_to_one_fit_only() {
    let bytes = checkpoint().to_bytes(&identity("a")).unwrap();
    let error = Checkpoint::from_bytes(&bytes, &identity("b")).unwrap_err();
    assert_eq!(error.reason(), "CHECKPOINT_OF_ANOTHER_FIT");
}

#[test]
fn another_version_is_refused_by_its_number() {
    let mut bytes = checkpoint().to_bytes(&identity("a")).unwrap();
    bytes[4] = 99;
    let error = Checkpoint::from_bytes(&bytes, &identity("a")).unwrap_err();
    assert!(error.to_string().contains("version 99"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn damaged_bytes_are_errors(cut in 0_usize..200, at: usize, value: u8) {
        let whole = checkpoint().to_bytes(&identity("a")).unwrap();
        prop_assert!(Checkpoint::from_bytes(&whole[..cut.min(whole.len() - 1)], &identity("a")).is_err());
        let mut bytes = whole;
        let at = at % bytes.len();
        bytes[at] = value;
        // It must not panic on any bytes.
        let _ = Checkpoint::from_bytes(&bytes, &identity("a"));
    }
}
