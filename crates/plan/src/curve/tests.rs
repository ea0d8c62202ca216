use super::*;

const PLAN: [f64; 5] = [0.3, -0.2, 0.7, 0.1, 0.4];

/// The curve as rollouts draw it.
fn catmull_rom(p: &[f64], time: f64) -> f64 {
    let i = (time as usize).min(p.len() - 2);
    let t = time - i as f64;
    let (b, c) = (p[i], p[i + 1]);
    let a = if i > 0 { p[i - 1] } else { 2.0 * b - c };
    let d = if i + 2 < p.len() { p[i + 2] } else { 2.0 * c - b };
    let (slope, cubic) = (0.5 * (c - a), 0.5 * (d - a) + 1.5 * (b - c));
    b + t * (slope + t * (a - 2.5 * b + 2.0 * c - 0.5 * d + t * cubic))
}

#[test]
fn cubic_curves_are_those_of_rollouts() {
    for count in [2, 3, 5] {
        let path = Curve::Cubic.path(&PLAN[..count], 1, 11);
        for (frame, at) in path.iter().enumerate() {
            let expected = catmull_rom(&PLAN[..count], frame as f64 * (count - 1) as f64 / 11.0);
            assert!((at - expected).abs() < 1e-12, "{count} {frame}: {at} {expected}");
        }
    }
}

#[test]
fn a_shift_by_whole_knots_drops_them() {
    let at = even(PLAN.len(), 4.0);
    for curve in [Curve::Linear, Curve::Cubic, Curve::Hold] {
        let shifted = curve.shifted(&PLAN, 1, 2.0, &at);
        for (s, e) in shifted.iter().zip([0.7, 0.1, 0.4, 0.4, 0.4]) {
            assert!((s - e).abs() < 1e-12);
        }
    }
    let half = Curve::Linear.shifted(&PLAN, 1, 0.5, &at);
    assert!((half[0] - 0.05).abs() < 1e-12);
}

#[test]
fn knots_may_be_at_any_times() {
    let at = [0.0, 1.0, 4.0];
    let plan = [0.0, 1.0, 4.0];
    // All on one line: every curve but the one that holds is that line.
    for curve in [Curve::Linear, Curve::Cubic] {
        for (s, e) in curve.shifted(&plan, 1, 0.5, &at).iter().zip([0.5, 1.5, 4.0]) {
            assert!((s - e).abs() < 1e-12, "{curve:?}: {s} {e}");
        }
    }
    assert_eq!(Curve::Hold.shifted(&plan, 1, 1.5, &at), [1.0, 1.0, 4.0]);
}

#[test]
fn gradients_by_knots_agree_with_finite_differences() {
    let by_frame: Vec<f64> = (0..8).map(|f| f64::from(f).sin()).collect();
    let cost = |plan: &[f64], curve: Curve| -> f64 {
        curve.path(plan, 1, 7).iter().zip(&by_frame).map(|(x, g)| x * g).sum()
    };
    for curve in [Curve::Linear, Curve::Cubic, Curve::Hold] {
        let gradient = curve.gradient_by_knots(&by_frame, 1, PLAN.len());
        for (k, g) in gradient.iter().enumerate() {
            let (mut there, mut back) = (PLAN, PLAN);
            there[k] += 1e-4;
            back[k] -= 1e-4;
            let slope = (cost(&there, curve) - cost(&back, curve)) / 2e-4;
            assert!((g - slope).abs() < 1e-9, "{curve:?} {k}: {g} {slope}");
        }
    }
}
