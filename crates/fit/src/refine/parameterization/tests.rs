use bendtwin_core::FitSettings;
use bendtwin_engine::optimizer::{Bounds, Decay};
use bendtwin_synth::{MakeOptions, Scene, make};

use bendtwin_core::settings::DeviceKind;

use super::*;

fn with_task(rest_shape: bool, test: impl FnOnce(&Task<'_>)) {
    let capture = make(Scene::Rope, &MakeOptions::tiny(1)).unwrap();
    let mut settings = FitSettings::default();
    settings.refine.rest_shape = rest_shape;
    test(
        &Task::new(&capture, &settings, DeviceKind::Cpu, &bendtwin_core::CancelToken::default())
            .unwrap(),
    );
}

fn base() -> Params {
    Params {
        spring_stiffness: vec![100.0, 2000.0],
        spring_dashpot: vec![1.0, 0.0],
        rest_lengths_m: vec![0.01, 0.02],
        bend_stiffness: vec![0.5],
        bend_damping: vec![1e-3],
        rest_angles_rad: vec![std::f32::consts::PI],
        drag: 1.5,
        ..Params::default()
    }
}

#[test]
fn the_rest_shape_moves_only_if_asked_for() {
    for rest_shape in [false, true] {
        with_task(rest_shape, |task| {
            let parameterization = parameterization(task, base());
            let moves = |p| parameterization.sections().iter().any(|s| s.parameter == p);
            assert!(moves(Parameter::SpringStiffness) && moves(Parameter::Drag));
            assert_eq!(moves(Parameter::RestLength), rest_shape);
            assert_eq!(moves(Parameter::RestAngle), rest_shape);
        });
    }
}

#[test]
fn steps_end_at_the_bounds() {
    with_task(true, |task| {
        let parameterization = parameterization(task, base());
        let mut theta = parameterization.start();
        let mut adam = parameterization.at_rest(theta.clone()).adam;
        let decay = Decay { beta1: 0.0, beta2: 0.0, prior: 0.0 };
        let uphill = vec![-1.0; theta.len()];
        let (rates, start): (Vec<f64>, _) =
            (parameterization.rates().collect(), parameterization.start());
        for _ in 0..100 {
            let bounds = Bounds {
                kinds: &parameterization.kinds(),
                rates: &rates,
                bounds: parameterization.bounds(),
                start: &start,
            };
            adam.step(&mut theta, &uphill, 1.0, bounds, decay);
        }
        let p = parameterization.params(&theta);
        assert!(p.spring_stiffness.iter().all(|&k| (k - MAX_SPRING_STIFFNESS).abs() < 1.0));
        assert!(p.rest_angles_rad.iter().all(|&a| a <= std::f32::consts::PI));
        assert!(p.rest_lengths_m[0] < 0.0123, "{}", p.rest_lengths_m[0]);
    });
}
