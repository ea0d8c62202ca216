//! The ground: restitution, time of impact, Coulomb friction.

use bendtwin_core::{Point, Timing};
use bendtwin_engine::{
    Backend,
    backend::{Diagnose, Outputs},
};

use crate::{
    expect::{Outcome, close, ensure},
    scene::{Scene, difference, dot},
};

const G: f64 = 9.81;

fn scaled(direction: [f64; 3], by: f64) -> Point {
    direction.map(|d| (d * by) as f32)
}

/// A node falling on a frictionless plane from half a metre rises to e² of its height at each
/// bounce, on level ground through the origin and on any other plane. Apexes to 0.5 % of the
/// first height: a fall's last substep of 0.1 ms is 0.03 % of its speed, and each bounce adds one.
/// The first apex after the bounce comes at t_fall (1 + e) within 2 ms, the flat top of a
/// parabola seen at 1 ms. Nothing ever passes the ground by more than f32 rounding (1 µm).
pub(crate) fn bouncing_node_loses_restitution_squared(backend: &dyn Backend) -> Outcome {
    let (h0, e) = (0.5_f64, 0.7_f64);
    for (up, offset) in [([0.0, 0.0, 1.0], 0.0), ([0.6, 0.0, 0.8], 0.3), ([0.0, -1.0, 0.0], -0.2)] {
        let mut scene = Scene::of(&[scaled(up, offset + h0)]);
        scene.environment.gravity = scaled(up, -G);
        scene.ground(scaled(up, 1.0), offset as f32, e as f32, 0.0);
        scene.timing = Timing { fps: 1000.0, substeps: 10 };
        scene.last(1500);
        let rollout = scene.roll_out(backend)?;
        let height = |p: &Point| dot(difference(*p, [0.0; 3]), up) - offset;
        let heights: Vec<f64> = rollout.positions.iter().map(height).collect();
        let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
        ensure(lowest >= -1e-6, || format!("the node sinks {:.2e} m below the ground", -lowest))?;
        let apexes: Vec<(usize, f64)> = (1..heights.len() - 1)
            .filter(|&f| heights[f] > heights[f - 1] && heights[f] >= heights[f + 1])
            .map(|f| (f, heights[f]))
            .collect();
        ensure(apexes.len() >= 3, || format!("only {} bounces in 1.5 s", apexes.len()))?;
        for (bounce, (_, apex)) in apexes.iter().take(3).enumerate() {
            let expected = h0 * e.powi(2 * (bounce as i32 + 1));
            close(&format!("height after bounce {}", bounce + 1), *apex, expected, 5e-3 * h0)?;
        }
        let fall = (2.0 * h0 / G).sqrt();
        close("time of the first apex", apexes[0].0 as f64 * 1e-3, fall * (1.0 + e), 2e-3)?;
    }
    Ok(())
}

/// A node sliding on level ground stops after v0²/(2 mu g): without restitution to 0.5 % (one
/// substep's path is 0.06 %), with and without restitution, which what slides does not need.
pub(crate) fn sliding_node_stops_by_coulomb_friction(backend: &dyn Backend) -> Outcome {
    let (v0, mu) = (1.0_f64, 0.3_f64);
    for restitution in [0.0, 0.5] {
        let tolerance = 5e-3;
        let mut scene = Scene::of(&[[0.0; 3]]);
        scene.environment.gravity[2] = -G as f32;
        scene.ground([0.0, 0.0, 1.0], 0.0, restitution, mu as f32);
        scene.timing = Timing { fps: 100.0, substeps: 100 };
        scene.initial.velocities[0] = [0.6, 0.8, 0.0];
        scene.last(60);
        let end = scene.end(backend)?;
        let path = (v0 * v0) / (2.0 * mu * G);
        let got = difference(end.positions[0], [0.0; 3]);
        close("stopping distance along x", got[0], 0.6 * path, tolerance * path)?;
        close("stopping distance along y", got[1], 0.8 * path, tolerance * path)?;
        close("height of the sliding node", got[2], 0.0, 1e-5)?;
    }
    Ok(())
}

/// On a slope below the angle of friction a node at rest stays (to 1 µm in a second); above it,
/// it slides with g (sin - mu cos), to 1 %.
pub(crate) fn friction_holds_on_a_slope(backend: &dyn Backend) -> Outcome {
    let mu = 0.5_f64;
    for slope in [0.3_f64, 0.8] {
        // The plane stays level and gravity leans, so that heights stay near zero.
        let mut scene = Scene::of(&[[0.0; 3]]);
        scene.environment.gravity = scaled([slope.sin(), 0.0, -slope.cos()], G);
        scene.ground([0.0, 0.0, 1.0], 0.0, 0.0, mu as f32);
        scene.timing = Timing { fps: 100.0, substeps: 100 };
        scene.last(100);
        let moved = f64::from(scene.end(backend)?.positions[0][0]);
        let slides = slope.tan() > mu;
        let pull = G * (slope.sin() - mu * slope.cos());
        let (expected, tolerance) = if slides { (pull / 2.0, 0.01 * pull) } else { (0.0, 1e-6) };
        close(&format!("slip on a slope of {slope} rad"), moved, expected, tolerance)?;
    }
    Ok(())
}

/// A sheet that lies on the ground reports that it is at rest, though gravity pushes its nodes into
/// the ground in every substep: below 0.1 mm/s after a second, of the nodes and of a rollout from
/// there.
pub(crate) fn what_lies_still_reports_no_speed(backend: &dyn Backend) -> Outcome {
    let points: Vec<Point> =
        (0..16).map(|i| [0.05 * (i % 4) as f32, 0.05 * (i / 4) as f32, 0.0]).collect();
    let mut scene = Scene::of(&points);
    for i in 0..16_u32 {
        let right = (i % 4 < 3).then_some(i + 1);
        let up = (i < 12).then_some(i + 4);
        right.into_iter().chain(up).for_each(|j| scene.spring([i, j], 20.0, 1.0));
    }
    scene.environment.gravity[2] = -G as f32;
    scene.ground([0.0, 0.0, 1.0], 0.0, 0.3, 0.5);
    scene.params.drag = 1.0;
    scene.timing = Timing { fps: 30.0, substeps: 100 };
    scene.last(30);
    scene.initial = scene.end(backend)?;
    scene.last(10);
    let outputs = Outputs { every: 1, velocities: true, diagnose: Diagnose::All, ..Outputs::NONE };
    let rollout = scene.roll_out_raw(backend, &outputs)?;
    let speed = |v: &Point| dot(v.map(f64::from), v.map(f64::from)).sqrt();
    let fastest = rollout.velocities.iter().map(speed).fold(0.0, f64::max);
    ensure(rollout.velocities.len() == 160, || "velocities are missing".into())?;
    close("speed of a node at rest", fastest, 0.0, 1e-4)?;
    let reported = rollout.diagnostics.map_or(f64::NAN, |d| f64::from(d.max_speed_m_s));
    close("the largest speed", reported, 0.0, 1e-4)
}

/// In a layer of smooth contact a node comes to rest half the width deep, to 5 % of the width, and
/// one that slides stops after v0²/(2 mu g), to 3 %.
pub(crate) fn smooth_contact_is_near_the_hard_one(backend: &dyn Backend) -> Outcome {
    let (width, v0, mu) = (1e-3_f32, 1.0_f64, 0.3_f64);
    let mut scene = Scene::of(&[[0.0, 0.0, 0.03], [1.0, 0.0, -0.5 * width]]);
    scene.environment.gravity[2] = -G as f32;
    scene.ground([0.0, 0.0, 1.0], 0.0, 0.0, mu as f32);
    scene.timing = Timing { fps: 100.0, substeps: 100 };
    scene.world.smoothing_m = width;
    scene.initial.velocities[1] = [0.6, 0.8, 0.0];
    scene.last(60);
    let end = scene.end(backend)?;
    let w = f64::from(width);
    close("depth", f64::from(end.positions[0][2]), -0.5 * w, 0.05 * w)?;
    let way = difference(end.positions[1], scene.initial.positions[1]);
    let way = dot([way[0], way[1], 0.0], [0.6, 0.8, 0.0]);
    let expected = v0 * v0 / (2.0 * mu * G);
    close("way", way, expected, 0.03 * expected)
}
