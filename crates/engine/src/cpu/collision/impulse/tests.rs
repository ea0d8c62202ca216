//! Contacts against their definition, and their adjoint against differences.

use super::{Approach, Contact, Law};
use crate::cpu::arithmetic::{Quad, dot, scale};

const LAW: Law<f64> = Law { restitution: 0.6, friction: 0.4 };

fn normal(raw: [f64; 3]) -> Quad<f64> {
    let q = [raw[0], raw[1], raw[2], 0.0];
    scale(q, 1.0 / dot(q, q).sqrt())
}

/// Velocities at the start and before contact, and a distance, in which every branch is taken:
/// sliding and sticking, an approach that the substep explains, partly explains and slows, and a
/// push.
fn cases() -> Vec<(Approach<f64>, Option<f64>)> {
    let u = |start: [f64; 3], now: [f64; 3]| Approach {
        start: [start[0], start[1], start[2], 0.0],
        now: [now[0], now[1], now[2], 0.0],
    };
    vec![
        (u([0.9, 0.2, -0.5], [0.9, 0.2, -0.7]), None),
        (u([0.01, 0.0, -0.5], [0.02, 0.01, -0.7]), None),
        (u([0.9, 0.2, 0.3], [0.9, 0.2, -0.7]), None),
        (u([0.02, 0.0, 0.3], [0.02, 0.03, -0.7]), None),
        (u([0.9, 0.2, -1.5], [0.9, 0.2, -0.7]), None),
        (u([0.02, 0.0, -1.5], [0.02, 0.05, -0.7]), None),
        (u([0.9, 0.2, 0.3], [0.9, 0.2, -0.7]), Some(-0.003)),
        (u([0.9, 0.2, 0.1], [0.9, 0.2, -0.7]), Some(-0.02)),
    ]
}

#[test]
fn what_the_substep_explains_does_not_bounce() {
    let n = [0.0, 0.0, 1.0, 0.0];
    let leaves = |start: f64, now: f64| {
        let u = Approach { start: [0.0, 0.0, start, 0.0], now: [0.0, 0.0, now, 0.0] };
        now + Contact::new(LAW, u, n, true, None).change[2]
    };
    assert_eq!(leaves(0.0, -3.0), 0.0, "pressed from rest");
    assert_eq!(leaves(2.0, -3.0), 0.0, "turned round within the substep");
    assert!((leaves(-1.0, -1.2) - 0.6).abs() < 1e-12, "in flight");
    assert!((leaves(-3.0, -1.0) - 0.6).abs() < 1e-12, "slowed within the substep");
}

#[test]
fn adjoints_are_differences() {
    let n0 = normal([0.1, -0.2, 1.0]);
    let b = [0.7, -0.4, 0.9, 0.0];
    for (i, (u0, inside)) in cases().into_iter().enumerate() {
        let value = |u: Approach<f64>, n: Quad<f64>, d: f64, law: Law<f64>| {
            dot(b, Contact::new(law, u, n, true, inside.map(|_| d)).change)
        };
        let d0 = inside.unwrap_or(0.0);
        let contact = Contact::new(LAW, u0, n0, true, inside);
        let g = contact.adjoint(LAW, u0, n0, d0, b);
        let step = 1e-6;
        let check = |what: &str, got: f64, plus: f64, minus: f64| {
            let expected = (plus - minus) / (2.0 * step);
            assert!((got - expected).abs() < 1e-7, "case {i}, {what}: {got}, expected {expected}");
        };
        for c in 0..3 {
            let moved = |q: Quad<f64>, by: f64| {
                let mut q = q;
                q[c] += by;
                q
            };
            let start = |by| Approach { start: moved(u0.start, by), ..u0 };
            let now = |by| Approach { now: moved(u0.now, by), ..u0 };
            let by_start = [step, -step].map(|by| value(start(by), n0, d0, LAW));
            check("start", g.start[c], by_start[0], by_start[1]);
            let by_now = [step, -step].map(|by| value(now(by), n0, d0, LAW));
            check("velocity", g.v[c], by_now[0], by_now[1]);
            let by_normal = [step, -step].map(|by| value(u0, moved(n0, by), d0, LAW));
            check("normal", g.normal[c], by_normal[0], by_normal[1]);
        }
        let law = |e: f64, mu: f64| Law { restitution: 0.6 + e, friction: 0.4 + mu };
        check(
            "restitution",
            g.restitution,
            value(u0, n0, d0, law(step, 0.0)),
            value(u0, n0, d0, law(-step, 0.0)),
        );
        check(
            "friction",
            g.friction,
            value(u0, n0, d0, law(0.0, step)),
            value(u0, n0, d0, law(0.0, -step)),
        );
        check("distance", g.distance, value(u0, n0, d0 + step, LAW), value(u0, n0, d0 - step, LAW));
    }
}
