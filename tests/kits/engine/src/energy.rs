//! Energies, momenta and forces in double precision, from their definitions alone.

use std::f64::consts::PI;

use bendtwin_core::Point;
use bendtwin_engine::model::State;

use crate::scene::{Scene, cross, difference, dot, norm};

type Point64 = [f64; 3];

/// All endpoints of a scene in `f64`: nodes of `state`, then the first row of controls.
pub(crate) fn endpoints(scene: &Scene, state: &State) -> Vec<Point64> {
    let controls = scene.controls.iter().take(scene.graph.control_count());
    state.positions.iter().chain(controls).map(|p| p.map(f64::from)).collect()
}

fn minus(a: Point64, b: Point64) -> Point64 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Angle of a triplet [rad].
pub(crate) fn angle(points: &[Point64], [i, j, k]: [u32; 3]) -> f64 {
    let at = points[j as usize];
    let (u, w) = (minus(points[i as usize], at), minus(points[k as usize], at));
    norm(cross(u, w)).atan2(dot(u, w))
}

/// Length of a spring [m].
pub(crate) fn length(points: &[Point64], [a, b]: [u32; 2]) -> f64 {
    norm(minus(points[b as usize], points[a as usize]))
}

/// The coordinate that a triplet's energy is quadratic in [rad]: -sqrt((pi - angle)² + epsilon²)
/// with epsilon half of the rest angle's distance from pi, so that a bent triplet passes smoothly
/// through straight.
fn bend(angle: f64, rest: f64) -> f64 {
    -(PI - angle).hypot(0.5 * (PI - rest))
}

/// Sum of k (l - l0)² / (2 l0) over springs and k_theta (q - q0)² / 2 over triplets, q by [`bend`]
/// [J].
pub(crate) fn elastic(scene: &Scene, points: &[Point64]) -> f64 {
    let p = &scene.params;
    let springs = scene.graph.springs.iter().enumerate().map(|(e, &ends)| {
        let l0 = f64::from(p.rest_lengths_m[e]);
        f64::from(p.spring_stiffness[e]) * (length(points, ends) - l0).powi(2) / (2.0 * l0)
    });
    let triplets = scene.graph.triplets.iter().enumerate().map(|(t, &ends)| {
        let rest = f64::from(p.rest_angles_rad[t]);
        let bent = bend(angle(points, ends), rest) - bend(rest, rest);
        f64::from(p.bend_stiffness[t]) * bent * bent / 2.0
    });
    springs.sum::<f64>() + triplets.sum::<f64>()
}

/// Elastic force on every node [N]: central differences of [`elastic`] with a step of 1 µm.
pub(crate) fn elastic_forces(scene: &Scene, state: &State) -> Vec<Point64> {
    let h = 1e-6;
    let mut points = endpoints(scene, state);
    let mut forces = vec![[0.0; 3]; state.positions.len()];
    for (i, force) in forces.iter_mut().enumerate() {
        for axis in 0..3 {
            let here = points[i][axis];
            points[i][axis] = here + h;
            let above = elastic(scene, &points);
            points[i][axis] = here - h;
            let below = elastic(scene, &points);
            points[i][axis] = here;
            force[axis] = -(above - below) / (2.0 * h);
        }
    }
    forces
}

/// Power that the dampers take out [W]: gamma (dl/dt)² over springs and c_b (dq/dt)² over triplets,
/// q by [`bend`], the rates by central differences along the velocities.
pub(crate) fn dissipation(scene: &Scene, state: &State) -> f64 {
    let h = 1e-6;
    let points = endpoints(scene, state);
    let moved = |sign: f64| -> Vec<Point64> {
        let mut moved = points.clone();
        for (p, v) in moved.iter_mut().zip(&state.velocities) {
            (0..3).for_each(|a| p[a] += sign * h * f64::from(v[a]));
        }
        moved
    };
    let (after, before) = (moved(1.0), moved(-1.0));
    let p = &scene.params;
    let springs = scene.graph.springs.iter().zip(&p.spring_dashpot).map(|(&ends, &gamma)| {
        let rate = (length(&after, ends) - length(&before, ends)) / (2.0 * h);
        f64::from(gamma) * rate * rate
    });
    let triplets = scene.graph.triplets.iter().enumerate().map(|(t, &ends)| {
        let (rest, damping) = (f64::from(p.rest_angles_rad[t]), p.bend_damping[t]);
        let at = |points: &[Point64]| bend(angle(points, ends), rest);
        let rate = (at(&after) - at(&before)) / (2.0 * h);
        f64::from(damping) * rate * rate
    });
    springs.sum::<f64>() + triplets.sum::<f64>()
}

/// Kinetic energy [J].
pub(crate) fn kinetic(scene: &Scene, state: &State) -> f64 {
    let of = |(v, m): (&Point, &f32)| {
        let v = v.map(f64::from);
        f64::from(*m) * dot(v, v) / 2.0
    };
    state.velocities.iter().zip(&scene.graph.masses).map(of).sum()
}

/// Linear [kg m/s] and angular momentum about the origin [kg m²/s].
pub(crate) fn momentum(scene: &Scene, state: &State) -> (Point64, Point64) {
    let (mut linear, mut angular) = ([0.0; 3], [0.0; 3]);
    for ((x, v), m) in state.positions.iter().zip(&state.velocities).zip(&scene.graph.masses) {
        let p = v.map(|v| f64::from(v) * f64::from(*m));
        let turn = cross(difference(*x, [0.0; 3]), p);
        (0..3).for_each(|a| {
            linear[a] += p[a];
            angular[a] += turn[a];
        });
    }
    (linear, angular)
}
