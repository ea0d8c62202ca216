use bendtwin_capture::{MakeOptions, Scene, make};
use bendtwin_core::FitSettings;

use super::*;

fn with_task(test: impl FnOnce(&Task<'_>)) {
    let capture = make(Scene::Rope, &MakeOptions::tiny(1)).unwrap();
    let mut settings = FitSettings::default();
    settings.refine.rest_shape = true;
    test(&Task::new(&capture, &settings).unwrap());
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
fn parameters_survive_the_way_to_coordinates_and_back() {
    with_task(|task| {
        let coordinates = Coordinates::new(task, base());
        let theta = coordinates.start();
        assert_eq!(theta.len(), coordinates.len());
        let back = coordinates.params(&theta);
        let pairs = [
            (&back.spring_stiffness, &base().spring_stiffness),
            (&back.rest_angles_rad, &base().rest_angles_rad),
        ];
        for (a, b) in pairs {
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * b), "{a:?} {b:?}");
        }
        assert!(back.spring_dashpot[1] <= 1e-8, "zero stays next to zero");
        assert!((back.drag - 1.5).abs() < 1e-5);
    });
}

#[test]
fn the_chain_rule_matches_finite_differences() {
    with_task(|task| {
        let coordinates = Coordinates::new(task, base());
        let theta: Vec<f64> = coordinates.start().iter().map(|x| x - 0.01).collect();
        // A loss whose gradient by parameter is known: the weighted sum of all squares.
        let loss = |theta: &[f64]| {
            let p = coordinates.params(theta);
            let kinds = coordinates.sections.iter().flat_map(|(kind, _)| kind.values(&p).to_vec());
            kinds.map(|x| f64::from(x).powi(2)).sum::<f64>()
        };
        let p = coordinates.params(&theta);
        let mut slope = p.clone();
        for (kind, _) in &coordinates.sections {
            kind.values_mut(&mut slope).iter_mut().for_each(|x| *x *= 2.0);
        }
        let gradient = coordinates.gradient(&p, &slope);
        for i in 0..theta.len() {
            let step = |h: f64| {
                let mut moved = theta.clone();
                moved[i] += h;
                loss(&moved)
            };
            let (h, scale) = (1e-3, loss(&theta));
            let numeric = (step(h) - step(-h)) / (2.0 * h);
            assert!(
                (numeric - gradient[i]).abs() <= 1e-2 * gradient[i].abs() + 1e-3 * scale,
                "coordinate {i}: {numeric} against {}",
                gradient[i]
            );
        }
    });
}

#[test]
fn steps_end_at_the_bounds() {
    with_task(|task| {
        let coordinates = Coordinates::new(task, base());
        let mut theta = coordinates.start();
        let mut adam = crate::adam::Adam::new(coordinates.len());
        let decay = Decay { beta1: 0.0, beta2: 0.0 };
        let uphill = vec![-1.0; theta.len()];
        for _ in 0..100 {
            coordinates.step(&mut adam, &mut theta, &uphill, 1.0, decay);
        }
        let p = coordinates.params(&theta);
        assert!(p.spring_stiffness.iter().all(|&k| (k - MAX_SPRING_STIFFNESS).abs() < 1.0));
        assert!(p.rest_angles_rad.iter().all(|&a| a <= std::f32::consts::PI));
        assert!(p.rest_lengths_m[0] < 0.0123, "{}", p.rest_lengths_m[0]);
    });
}
