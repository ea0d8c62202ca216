use super::*;
use crate::cpu::{
    arithmetic::{Portable, add_scaled, dot, scale, sub},
    elements::jacobian::assert_adjoint,
};

type V = Quad<f64>;

/// A rod of eleven nodes, which fills a block and begins another.
const NODES: usize = 11;

fn rod(parameters: [f64; 3], has_arm: bool) -> Rods<f64> {
    Rods::new(&[(0..NODES as u32).collect()], |_| has_arm, |_| Vec::new(), |_| parameters)
}

/// A bent and twisting curve with edges of different lengths, moving.
fn nodes() -> Vec<Node<f64>> {
    let at = |i: usize| {
        let t = 0.5 * i as f64;
        [t, (1.3 * t).sin(), 0.4 * t * t * (0.7 * t).cos(), 0.0]
    };
    let velocity = |i: usize| {
        let t = i as f64;
        [(2.1 * t).sin(), (1.7 * t).cos(), (3.3 * t).sin(), 0.0]
    };
    (0..NODES).map(|i| Node { x: at(i), v: velocity(i) }).collect()
}

fn lambda() -> Vec<V> {
    (0..NODES).map(|i| [(1.9 * i as f64).cos(), 0.3, (0.9 * i as f64).sin(), 0.0]).collect()
}

/// Forces and twist after a substep of `dt` that starts at `twist`.
fn step(rods: &Rods<f64>, dt: f64, nodes: &[Node<f64>], twist: f64) -> (Vec<V>, f64) {
    let (mut forces, mut twists) = (vec![[0.0; 4]; nodes.len()], [twist]);
    rod_forces(Portable, rods, dt, nodes, (&mut twists, &[]), &mut forces);
    (forces, twists[0])
}

/// Rate at which a rod's twist changes.
fn rate(nodes: &[Node<f64>], has_arm: bool) -> f64 {
    step(&rod([0.0; 3], has_arm), 1.0, nodes, 0.0).1
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], 0.0]
}

/// Carries a vector from one direction to another without turning it about either.
fn transport(vector: V, from: V, to: V) -> V {
    let (axis, cosine) = (cross(from, to), dot(from, to));
    let turned = add_scaled(scale(vector, cosine), 1.0, cross(axis, vector));
    add_scaled(turned, dot(axis, vector) / (1.0 + cosine), axis)
}

fn directions(nodes: &[Node<f64>]) -> Vec<V> {
    let edge = |pair: &[Node<f64>]| {
        let e = sub(pair[1].x, pair[0].x);
        scale(e, dot(e, e).sqrt().recip())
    };
    nodes.windows(2).map(edge).collect()
}

/// The rate is how fast the last clamp's frame, carried in time, turns about its direction against
/// the first clamp's, carried in time and then along the rod: what twists a rod, from its
/// definition alone.
#[test]
fn twist_is_the_angle_between_the_ways_of_parallel_transport() {
    let (start, h) = (nodes(), 1e-5);
    let moved = |by: f64| -> Vec<Node<f64>> {
        start.iter().map(|n| Node { x: add_scaled(n.x, by, n.v), v: n.v }).collect()
    };
    let along = |mut vector: V, directions: &[V]| {
        for pair in directions.windows(2) {
            vector = transport(vector, pair[0], pair[1]);
        }
        vector
    };
    let now = directions(&start);
    let (first, last) = (now[0], now[NODES - 2]);
    let any = cross(first, [0.0, 0.0, 1.0, 0.0]);
    let frame = scale(any, dot(any, any).sqrt().recip());
    let at_end = along(frame, &now);
    let angle = |by: f64| {
        let then = directions(&moved(by));
        let natural = along(transport(frame, first, then[0]), &then);
        let held = transport(at_end, last, then[NODES - 2]);
        dot(cross(held, natural), then[NODES - 2]).atan2(dot(held, natural))
    };
    let expected = (angle(h) - angle(-h)) / (2.0 * h);
    let got = rate(&start, false);
    assert!(expected.abs() > 0.1 && (got - expected).abs() < 1e-8, "{got} {expected}");
}

/// With an arm it is how fast the first clamp's frame, carried in time and then along the rod up to
/// the junction, turns against the arm about the edge between them.
#[test]
fn an_arm_holds_the_frame_where_it_begins() {
    let (start, h) = (nodes(), 1e-5);
    let first = directions(&start)[0];
    let any = cross(first, [0.0, 0.0, 1.0, 0.0]);
    let frame = scale(any, dot(any, any).sqrt().recip());
    let angle = |by: f64| {
        let moved: Vec<Node<f64>> =
            start.iter().map(|n| Node { x: add_scaled(n.x, by, n.v), v: n.v }).collect();
        let then = directions(&moved);
        let (along, arm) = then.split_at(NODES - 2);
        let mut natural = transport(frame, first, along[0]);
        for pair in along.windows(2) {
            natural = transport(natural, pair[0], pair[1]);
        }
        let axis = along[NODES - 3];
        let held = add_scaled(arm[0], -dot(arm[0], axis), axis);
        dot(cross(held, natural), axis).atan2(dot(held, natural))
    };
    let expected = (angle(h) - angle(-h)) / (2.0 * h);
    let got = rate(&start, true);
    assert!(expected.abs() > 0.1 && (got - expected).abs() < 1e-7, "{got} {expected}");
}

#[test]
fn forces_push_against_the_twist_and_damping_takes_power() {
    for has_arm in [false, true] {
        forces_push_against_the_twist(has_arm);
    }
}

fn forces_push_against_the_twist(has_arm: bool) {
    let nodes = nodes();
    let rate = rate(&nodes, has_arm);
    let rod = |parameters| rod(parameters, has_arm);
    let power = |rods: &Rods<f64>, twist: f64| -> f64 {
        let (forces, _) = step(rods, 0.0, &nodes, twist);
        forces.iter().zip(&nodes).map(|(f, n)| dot(*f, n.v)).sum()
    };
    // What the elastic torque does is what its energy k (twist - rest)²/2 loses.
    assert!((power(&rod([0.7, 0.0, 0.2]), 1.5) + 0.7 * 1.3 * rate).abs() < 1e-12);
    assert!((power(&rod([0.0, 0.3, 0.2]), 1.5) + 0.3 * rate * rate).abs() < 1e-12);
    let (forces, _) = step(&rod([0.7, 0.1, 0.2]), 0.0, &nodes, 1.5);
    let total = forces.iter().fold([0.0; 4], |sum, &f| add_scaled(sum, 1.0, f));
    assert!(dot(total, total) < 1e-24, "internal forces add up to nothing");
}

#[test]
fn the_adjoint_is_the_derivative() {
    for has_arm in [false, true] {
        adjoint_is_derivative(has_arm);
    }
}

fn adjoint_is_derivative(has_arm: bool) {
    let rod = |parameters| rod(parameters, has_arm);
    let (nodes, lambda, dt, twist, weight) = (nodes(), lambda(), 0.13, 0.4, 0.6);
    let parameters = [0.7, 0.1, -0.5];
    let value = |parameters: [f64; 3], nodes: &[Node<f64>], twist: f64| -> f64 {
        let (forces, after) = step(&rod(parameters), dt, nodes, twist);
        forces.iter().zip(&lambda).map(|(f, l)| dot(*f, *l)).sum::<f64>() + weight * after
    };
    let rods = rod(parameters);
    let mut adjoint = vec![Node::default(); NODES];
    let (mut twist_bar, mut gradient) = ([weight], [RodGradient::ZERO]);
    rod_adjoint(
        Portable,
        &rods,
        dt,
        &nodes,
        (&[twist], &[]),
        &lambda,
        &mut adjoint,
        (&mut twist_bar, &mut []),
        &mut gradient,
    );
    // The twist after the substep counts as the last coordinate of one more force.
    let with_twist = |nodes: &[Node<f64>]| {
        let (mut forces, after) = step(&rods, dt, nodes, twist);
        forces.push([weight * after, 0.0, 0.0, 0.0]);
        forces
    };
    let lambda: Vec<V> = lambda.iter().copied().chain([[1.0, 0.0, 0.0, 0.0]]).collect();
    assert_adjoint(&nodes, &lambda, &adjoint, 1e-6, with_twist);
    let h = 1e-6;
    let by = |change: [f64; 4]| {
        let at = |sign: f64| {
            let p = std::array::from_fn(|i| parameters[i] + sign * h * change[i]);
            value(p, &nodes, twist + sign * h * change[3])
        };
        (at(1.0) - at(-1.0)) / (2.0 * h)
    };
    let [g] = gradient;
    let got = [g.stiffness, g.damping, g.rest_twist, twist_bar[0]];
    for (i, got) in got.into_iter().enumerate() {
        let expected = by(std::array::from_fn(|k| f64::from(u8::from(k == i))));
        assert!((got - expected).abs() < 1e-8, "arm {has_arm}, variable {i}: {got} {expected}");
    }
}

/// No edge, a fold, a straight line: all numbers are finite, and there is no force without a turn.
#[test]
fn degenerate_rods_do_nothing() {
    let still = |x: f64| Node { x: [x, 0.0, 0.0, 0.0], v: [0.1, 0.2, 0.3, 0.0] };
    let lines = [[0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 0.0, 1.0], [0.0; 4], [0.0, 1.0, 2.0, 3.0]];
    for (line, has_arm) in lines.into_iter().flat_map(|line| [(line, false), (line, true)]) {
        let nodes: Vec<Node<f64>> = line.into_iter().map(still).collect();
        let rods = Rods::new(&[vec![0, 1, 2, 3]], |_| has_arm, |_| Vec::new(), |_| [1.0, 1.0, 3.0]);
        let (forces, twist) = step(&rods, 0.1, &nodes, 0.5);
        assert_eq!(forces.iter().flatten().fold(0.0_f64, |m, f| m.max(f.abs())), 0.0, "{line:?}");
        assert_eq!(twist, 0.5);
        let mut adjoint = vec![Node::default(); 4];
        let (mut twist_bar, mut gradient) = ([1.0], [RodGradient::ZERO]);
        let (twists, lambda) = ([0.5], vec![[1.0, -2.0, 0.5, 0.0]; 4]);
        rod_adjoint(
            Portable,
            &rods,
            0.1,
            &nodes,
            (&twists, &[]),
            &lambda,
            &mut adjoint,
            (&mut twist_bar, &mut []),
            &mut gradient,
        );
        let numbers = adjoint.iter().flat_map(|n| n.x.iter().chain(&n.v));
        assert!(numbers.chain(&twist_bar).all(|x| x.is_finite()), "{line:?}");
    }
}
