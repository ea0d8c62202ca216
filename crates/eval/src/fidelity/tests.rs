use super::*;
use crate::scene;

fn measure(twin: &Twin, capture: &Capture) -> Result<Option<FastVariant>, Error> {
    let backend = bendtwin_engine::cpu_with_threads(1);
    fast_variant(&*backend, twin, capture, &CancelToken::default())
}

#[test]
fn a_soft_twin_needs_far_fewer_substeps() {
    let capture = scene::chain(6, 40, 30, [0.0, 0.0, 0.005]);
    let mut twin = scene::chain_twin(6);
    twin.timing.substeps = 200;
    let fast = measure(&twin, &capture).unwrap().unwrap();
    assert!(fast.substeps <= 40, "{fast:?}");
    assert!(fast.mean_deviation_m > 0.0 && fast.mean_deviation_m <= TOLERANCE_M, "{fast:?}");
    assert!(fast.max_deviation_m >= fast.mean_deviation_m && fast.mean_travel_m > 0.01);
    assert_eq!(measure(&twin, &capture).unwrap(), Some(fast), "the same again");
}

#[test]
fn a_capture_in_which_nothing_moves_vouches_for_no_softening() {
    let capture = scene::chain(6, 40, 30, [0.0; 3]);
    let mut twin = scene::chain_twin(6);
    twin.params.spring_stiffness.fill(1e3);
    let needed = stable_substeps(&Model::from(&twin)).needed;
    twin.timing.substeps = 4 * needed;
    let fast = measure(&twin, &capture).unwrap().unwrap();
    assert!(fast.rate_limit.is_none() && fast.substeps >= needed, "{fast:?}");
}

#[test]
fn nothing_to_follow_is_no_variant_and_another_capture_an_error() {
    let capture = scene::chain(5, 1, 1, [0.0; 3]);
    assert_eq!(measure(&scene::chain_twin(5), &capture).unwrap(), None);
    let capture = scene::chain(4, 30, 20, [0.0; 3]);
    assert!(matches!(measure(&scene::chain_twin(6), &capture), Err(Error::Mismatch(_))));
}
