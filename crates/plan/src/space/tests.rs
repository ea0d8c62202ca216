use super::*;

fn near(a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

/// Three points over three knots that do not move as one.
fn trajectories() -> Vec<f64> {
    (0..27).map(|i| 0.1 * f64::from(i) + (0.7 * f64::from(i)).sin()).collect()
}

fn poses() -> Vec<f64> {
    let rows = [0.0, 1.5, 3.0, 4.5].into_iter().flat_map(|turn| {
        let about = exponential([0.0, turn, 0.0]);
        let tilted = product(about, unit([0.3, 0.0, 0.1, 0.9]));
        [[turn, 0.0, 0.2].to_vec(), tilted.to_vec(), [0.0, turn, 0.0].to_vec(), about.to_vec()]
    });
    rows.flatten().collect()
}

fn spaces() -> Vec<(Space, Vec<f64>)> {
    let points = |groups: &[usize]| {
        let start = trajectories()[..9].to_vec();
        (Space::new(start, &Movement::Points(groups.to_vec())), trajectories())
    };
    let grippers = |m: Movement| (Space::new(poses()[..14].to_vec(), &m), poses());
    vec![
        points(&[0, 0, 0]),
        points(&[0, 1, 0]),
        points(&[0, 1, 2]),
        grippers(Movement::Translation),
        grippers(Movement::Rigid),
    ]
}

#[test]
fn a_nominal_plan_comes_back_and_its_coordinates_are_means() {
    let dims = [3, 6, 9, 6, 12];
    for ((mut space, actions), dims) in spaces().into_iter().zip(dims) {
        assert_eq!(space.dims(), dims);
        let displacements = space.displacements(&actions);
        near(&space.displaced(&displacements), &actions);
        let knots = space.around(displacements);
        assert_eq!(knots[..dims], vec![0.0; dims]);
        near(&space.actions(&knots), &actions);
    }
    let (mut space, actions) = spaces().remove(0);
    let knots = space.around(space.displacements(&actions));
    let mean = (0..3).map(|c| actions[9 + 3 * c] - actions[3 * c]).sum::<f64>() / 3.0;
    assert!((knots[3] - mean).abs() < 1e-12);
    let moved: Vec<f64> = knots.iter().map(|x| x + 0.5).collect();
    near(&space.actions(&moved), &actions.iter().map(|x| x + 0.5).collect::<Vec<_>>());
}

#[test]
fn rotations_may_exceed_half_a_turn() {
    let (mut space, actions) = spaces().remove(4);
    let knots = space.around(space.displacements(&actions));
    for (k, turn) in [0.0, 1.5, 3.0, 4.5].into_iter().enumerate() {
        near(&knots[12 * k + 3..12 * k + 6], &[0.0, turn, 0.0]);
    }
}

#[test]
fn a_space_of_translations_keeps_rotations() {
    let (mut space, actions) = spaces().remove(3);
    let mut knots = space.around(space.displacements(&actions));
    knots[6] += 1.0;
    let moved = space.actions(&knots);
    assert!((moved[14] - actions[14] - 1.0).abs() < 1e-12);
    near(&moved[15..], &actions[15..]);
}

#[test]
fn gradients_agree_with_finite_differences() {
    for (mut space, actions) in spaces() {
        let mut knots = space.around(space.displacements(&actions));
        knots.iter_mut().enumerate().for_each(|(i, x)| *x += 0.2 * (i as f64).cos());
        let by_actions: Vec<f64> = (0..actions.len()).map(|i| (i as f64).sin()).collect();
        let cost = |knots: &[f64]| -> f64 {
            space.actions(knots).iter().zip(&by_actions).map(|(x, g)| x * g).sum()
        };
        let gradient = space.gradient(&knots, &by_actions);
        for i in 0..knots.len() {
            let at = |by: f64| {
                let mut moved = knots.clone();
                moved[i] += by;
                cost(&moved)
            };
            let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
            assert!((gradient[i] - slope).abs() < 1e-6, "{i}: {} {slope}", gradient[i]);
        }
    }
}
