use bendtwin_engine::Device;

use super::*;
use crate::scene::SceneName;

fn device(kind: &str, name: &str) -> Device {
    Device { kind: kind.into(), name: name.into(), lanes: 1 }
}

/// 507 nodes, 9,866 springs of which 1,500 are to control points: 18,232 half-springs.
#[test]
fn a_gpus_bound_is_the_hand_count() {
    let bound = IssueBound::of(&device("cuda", "NVIDIA H200")).unwrap();
    let scene = Scene::new(SceneName::N500, false).unwrap();
    let instructions = (18_232.0 * 26.0 + 507.0 * 24.0) / 32.0;
    let expected = instructions / (132.0 * 4.0 * 1.98e9);
    assert!((bound.forward_s(&scene) / expected - 1.0).abs() < 1e-9);
    assert!(bound.gradient_s(&scene).unwrap() > 2.0 * expected);
}

#[test]
fn bending_costs_and_its_gradient_is_not_counted() {
    let bound = IssueBound::of(&device("cuda", "NVIDIA H100 80GB HBM3")).unwrap();
    let [axial, bent] = [false, true].map(|b| Scene::new(SceneName::Rope, b).unwrap());
    assert!(bound.forward_s(&bent) > 1.1 * bound.forward_s(&axial));
    assert_eq!(bound.gradient_s(&bent), None);
}

#[test]
fn an_unknown_device_has_no_bound() {
    assert_eq!(IssueBound::of(&device("cuda", "NVIDIA Something")), None);
    assert_eq!(IssueBound::of(&device("tpu", "H200")), None);
}

#[test]
fn a_cpus_rate_is_measured() {
    let Some(bound) = IssueBound::of(&device("cpu", "this one")) else { return };
    assert!(bound.per_second > 1e7, "{bound:?}");
    assert!(bound.how.contains("measured"));
}
