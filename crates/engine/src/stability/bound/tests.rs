use super::*;

fn star(arms: usize, stiffness: f64) -> Linear {
    let turn = std::f64::consts::TAU / arms as f64;
    let bar = |i: usize| Bar {
        ends: [0, i as u32 + 1],
        direction: [(turn * i as f64).cos(), (turn * i as f64).sin(), 0.0],
        along: stiffness,
        across: 0.0,
        damping: 0.0,
    };
    Linear {
        roots: vec![1.0; arms + 1],
        bars: (0..arms).map(bar).collect(),
        hinges: Vec::new(),
        twists: Vec::new(),
    }
}

#[test]
fn one_spring_is_bounded_by_what_it_is() {
    for bound in of(&star(1, 3.0), 0.5) {
        assert!((bound - 0.25 * 6.0).abs() < 1e-12, "{bound}");
    }
    assert_eq!(of(&star(3, 0.0), 0.5), [0.0; 2]);
}

/// The star's stiffest mode has k (1 + n / 2): a node among many springs sums up directions, not
/// weights.
#[test]
fn springs_that_point_everywhere_do_not_add_up() {
    let (exact, [coarse, fine]) = (1.0 + 6.0, of(&star(12, 1.0), 1.0));
    assert!(fine >= exact && fine < 1.0 + 12.0 * 0.75, "{fine}");
    assert!((coarse - 24.0).abs() < 1e-12, "{coarse}");
}

#[test]
fn what_overflows_is_not_below_anything() {
    assert!(!is_below(&star(3, f64::MAX), 1e3, 4.0));
    assert!(!is_below(&star(3, 0.0), f64::INFINITY, 4.0));
    assert!(is_below(&star(3, 0.0), 1.0, 4.0));
}
