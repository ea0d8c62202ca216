use super::*;

const LAW: Law<f64> = Law { restitution: 0.3, friction: 0.6 };

fn layer() -> Layer<f64> {
    Layer::new(2e-3, 1e-3)
}

/// Every derivative agrees with central differences to 1e-6 of its size, above, in and below the
/// layer, approaching and leaving.
#[test]
fn the_adjoint_matches_differences() {
    let n = [0.36, 0.48, 0.8, 0.0];
    let bar = [0.7, -0.4, 1.1, 0.0];
    for h in [-3e-3, -0.9e-3, -2e-4, 4e-4, 0.9e-3] {
        for u in [[0.2, -0.1, -0.3, 0.0], [0.01, 0.02, 0.05, 0.0], [0.0, 0.0, -1e-3, 0.0]] {
            let value = |x: &[f64; 9]| {
                let law = Law { restitution: x[7], friction: x[8] };
                let (u, n) = ([x[0], x[1], x[2], 0.0], [x[3], x[4], x[5], 0.0]);
                dot(layer().change(law, x[6], u, n), bar)
            };
            let at = [u[0], u[1], u[2], n[0], n[1], n[2], h, LAW.restitution, LAW.friction];
            let a = layer().change_adjoint(LAW, h, u, n, bar);
            let got = [
                a.v[0],
                a.v[1],
                a.v[2],
                a.normal[0],
                a.normal[1],
                a.normal[2],
                a.distance,
                a.restitution,
                a.friction,
            ];
            for (i, got) in got.into_iter().enumerate() {
                let step = if i == 6 { 1e-9 } else { 1e-6 };
                let moved = |by: f64| {
                    let mut x = at;
                    x[i] += by;
                    value(&x)
                };
                let expected = (moved(step) - moved(-step)) / (2.0 * step);
                let tolerance = 1e-6 * (expected.abs() + 1e-2);
                assert!((got - expected).abs() < tolerance, "{h} {u:?} {i}: {got} {expected}");
            }
        }
    }
}

/// A node under gravity comes to rest about half the width deep, on any path, and an impact returns
/// no energy.
#[test]
fn a_node_settles_half_the_width_deep() {
    for (speed, dt) in [(0.0, 1e-3), (-1.0, 1e-3), (-1.0, 5e-5), (0.5, 1e-4)] {
        let layer = Layer::<f64>::new(1e-3, dt);
        let law = Law { restitution: 0.0, friction: 0.5 };
        let (mut x, mut v) = (2e-3, [0.3, 0.0, speed, 0.0]);
        let n = [0.0, 0.0, 1.0, 0.0];
        for _ in 0..(1.0 / dt) as usize {
            v[2] -= 9.81 * dt;
            if layer.reaches(x) {
                v = add(v, layer.change(law, x, v, n));
            }
            x += dt * v[2];
        }
        assert!((x + 0.5e-3).abs() < 5e-5, "{x}");
        assert!(v[2].abs() < 1e-3 && v[0].abs() < 1e-3, "{v:?}");
    }
}

/// No force outside the layer, and no jump of the change at its edges.
#[test]
fn the_layer_ends_smoothly() {
    assert!(!layer().reaches(1.0001e-3));
    let n = [0.0, 0.0, 1.0, 0.0];
    let u = [0.3, 0.0, -0.2, 0.0];
    assert!(dot(layer().change(LAW, 0.9999e-3, u, n), n).abs() < 1e-8);
    let [above, below] = [-0.99999e-3, -1.00001e-3].map(|h| layer().change(LAW, h, u, n));
    for c in 0..3 {
        assert!((above[c] - below[c]).abs() < 1e-6);
    }
}
