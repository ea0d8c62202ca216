use super::{
    controls::{Motion, Paths},
    soft_min,
};

#[test]
fn a_soft_minimum_lies_between_least_and_mean() {
    let costs = [3.0, 1.0, 2.0];
    assert!((soft_min::value(&costs, 1e-3) - 1.0 - 1e-3 * 3f64.ln()).abs() < 1e-12);
    assert!((soft_min::value(&costs, 1e6) - 2.0).abs() < 1e-5);
    // Far below what exp() can hold.
    assert!((soft_min::value(&[-1e9, 1e9], 1.0) + 1e9 - 2f64.ln()).abs() < 1e-6);
    assert_eq!(soft_min::value(&[f64::INFINITY], 1.0), f64::INFINITY);
}

#[test]
fn shares_are_derivatives_of_the_soft_minimum() {
    let costs = [3.0, 1.0, 2.5];
    let shares = soft_min::shares(&costs, 0.7);
    for (i, share) in shares.iter().enumerate() {
        let moved = |by: f64| {
            let mut costs = costs;
            costs[i] += by;
            soft_min::value(&costs, 0.7)
        };
        let expected = (moved(1e-5) - moved(-1e-5)) / 2e-5;
        assert!((share - expected).abs() < 1e-8, "{share} {expected}");
    }
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

#[test]
fn path_and_speed_of_controls_are_as_defined() {
    // Two control points, two frames at 10 a second: 30 and 40 mm, then 0 and 50 mm.
    let controls = [
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.03, 0.0, 0.0],
        [1.0, 0.04, 0.0],
        [0.03, 0.0, 0.0],
        [1.03, 0.0, 0.0],
    ];
    let paths = Paths { controls: &controls, frames: 2, fps: 10.0 };
    let path = paths.values(Motion::Path);
    assert!((path[1] - 0.035).abs() < 1e-6 && (path[2] - 0.025).abs() < 1e-6, "{path:?}");
    let speed = paths.values(Motion::Speed { limit_m_s: 0.35 });
    assert!((speed[1] - 0.05f64.powi(2) / 4.0).abs() < 1e-6, "{speed:?}");
    assert!((speed[2] - 0.15f64.powi(2) / 4.0).abs() < 1e-6, "{speed:?}");
    assert_eq!((path[0], speed[0]), (0.0, 0.0));
    let empty = Paths { controls: &[], frames: 2, fps: 10.0 };
    assert_eq!(empty.values(Motion::Path), [0.0; 3]);
}

#[test]
fn gradients_of_path_and_speed_are_those_of_differences() {
    let controls = [[0.0; 3], [0.1, 0.02, 0.0], [0.1, 0.1, 0.3], [0.1, 0.1, 0.3]];
    for motion in [Motion::Path, Motion::Speed { limit_m_s: 0.5 }] {
        let mut gradient = [[0.0f32; 3]; 4];
        let paths = Paths { controls: &controls, frames: 3, fps: 10.0 };
        paths.add_gradient(motion, -2.0, &mut gradient);
        let cost = |controls: &[[f32; 3]]| -> f64 {
            let paths = Paths { controls, frames: 3, fps: 10.0 };
            -2.0 * paths.values(motion).iter().sum::<f64>()
        };
        // The last way has length zero, where there is no derivative of the path.
        for (i, k) in (0..2).flat_map(|i| (0..3).map(move |k| (i, k))) {
            let moved = |by: f32| {
                let mut controls = controls;
                controls[i][k] += by;
                cost(&controls)
            };
            let expected = (moved(1e-3) - moved(-1e-3)) / 2e-3;
            let error = (f64::from(gradient[i][k]) - expected).abs();
            assert!(error < 1e-2 * expected.abs() + 1e-3, "{motion:?} {i} {k}: {expected}");
        }
    }
}
