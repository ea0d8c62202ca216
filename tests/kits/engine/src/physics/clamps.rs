//! Clamps of rods that open and close: what stays of a twist, and how a hand turns what it holds.

use std::sync::Arc;

use bendtwin_core::Point;
use bendtwin_engine::{
    Backend,
    model::State,
    world::{Attachment, Grasp, IDENTITY, Phase, Pose, Region},
};

use crate::{
    differences::{Check, matches_differences},
    expect::{Outcome, close, ensure},
    physics::grasps::pins,
    physics::twist::{branched_cable, cable},
    scene::{Scene, cross, difference, dot, norm, pose},
};

fn nodes(of: &[u32]) -> Region {
    Region::Nodes(Arc::new(of.to_vec()))
}

fn controls(of: &[u32]) -> Region {
    Region::Controls(Arc::new(of.to_vec()))
}

/// A [`cable`] that resists twist, in gravity, with both clamps in hands that stand still: grasp 0 is
/// that of the near one, grasp 1 of the far one.
fn held_cable(frames: usize, closed: [fn(usize) -> bool; 2]) -> Scene {
    let mut scene = cable();
    scene.params.twist_stiffness[0] = 0.05;
    scene.params.spring_dashpot.fill(1.0);
    scene.params.drag = 5.0;
    scene.environment.gravity = [0.0, 0.0, -9.81];
    scene.last(frames);
    let body = scene.body(|_| IDENTITY);
    scene.grasp(pins(body, controls(&[0, 1])), closed[0]);
    scene.grasp(pins(body, controls(&[2, 3])), closed[1]);
    scene
}

/// Turn by an angle about a unit axis through a point.
fn turn(about: Point, axis: [f64; 3], angle: f64) -> Pose {
    let (s, c) = angle.sin_cos();
    let at = about.map(f64::from);
    let turned = |v: [f64; 3]| -> [f64; 3] {
        let (across, along) = (cross(axis, v), dot(axis, v) * (1.0 - c));
        std::array::from_fn(|i| c * v[i] + s * across[i] + along * axis[i])
    };
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(turned);
    let shift = turned(at);
    std::array::from_fn(|i| {
        let row = [columns[0][i], columns[1][i], columns[2][i], at[i] - shift[i]];
        row.map(|x| x as f32)
    })
}

fn along(scene: &Scene, a: usize, b: usize) -> [f64; 3] {
    let edge = difference(scene.graph.rest_positions[b], scene.graph.rest_positions[a]);
    let length = norm(edge);
    edge.map(|x| x / length)
}

fn twist(state: &State) -> f64 {
    state.twists.first().map_or(f64::NAN, |&x| f64::from(x))
}

/// An end that a clamp releases falls, and is not twisted any more; the other end stays where it is
/// held. A rollout that is cut anywhere resumes bit for bit.
pub(crate) fn an_opened_clamp_lets_the_twist_out(backend: &dyn Backend) -> Outcome {
    let mut scene = held_cable(20, [|_| true, |f| f < 10]);
    scene.params.rest_twists_rad[0] = 0.25;
    scene.initial.twists = vec![2.0];
    let states = scene.states(backend)?;
    ensure(states.last() == Some(&scene.end(backend)?), || "it resumes differently".into())?;
    for (f, state) in states.iter().enumerate() {
        if f <= 10 {
            ensure(twist(state) > 1.0, || format!("twist {} in frame {f}", twist(state)))?;
            close(
                "its end",
                norm(difference(state.positions[9], states[0].positions[9])),
                0.0,
                1e-6,
            )?;
        } else {
            close("twist of a free end", twist(state), 0.25, 0.0)?;
        }
        close(
            "the other",
            norm(difference(state.positions[0], states[0].positions[0])),
            0.0,
            1e-6,
        )?;
    }
    let fallen = states[20].positions[9][2] - states[10].positions[9][2];
    // 0.1 s of free fall are 49 mm.
    ensure(fallen < -0.01, || format!("the free end moved by {fallen} m"))
}

/// A hand that closes on the middle of a cable while the clamp behind it opens leaves everything
/// before it unchanged at that moment: twist, positions, velocities and energy between the clamps
/// are continuous. The hand holds the cable's direction there.
pub(crate) fn a_hand_takes_a_cable_anywhere(backend: &dyn Backend) -> Outcome {
    let mut scene = held_cable(30, [|_| true, |f| f < 10]);
    scene.initial.twists = vec![1.5];
    let body = scene.body(|_| IDENTITY);
    scene.grasp(pins(body, nodes(&[5, 6])), |f| f >= 10);
    let states = scene.states(backend)?;
    ensure(states.last() == Some(&scene.end(backend)?), || "it resumes differently".into())?;
    let (before, after) = (&states[10], &states[11]);
    let jump = (twist(after) - twist(before)).abs();
    let usual = (twist(before) - twist(&states[9])).abs().max(1e-3);
    ensure(jump < 20.0 * usual, || format!("twist jumps by {jump} where {usual} is usual"))?;
    ensure(twist(after) > 1.0, || format!("twist is {}", twist(after)))?;
    for state in &states[11..] {
        for node in [5, 6] {
            let moved = norm(difference(state.positions[node], before.positions[node]));
            close("a held node", moved, 0.0, 1e-6)?;
        }
    }
    let tail = states[30].positions[9][2] - before.positions[9][2];
    ensure(tail < -0.01, || format!("the tail moved by {tail} m"))?;
    ensure(states[30].grasping.phases[1..] == [Phase::Open, Phase::Closed], || {
        format!("{:?}", states[30].grasping.phases)
    })
}

/// A hand that turns about the edge that it holds twists the rod by the same angle, at the far end
/// against the sense along the rod, at the near end with it, whether it holds by springs or by
/// pins. A hand in the middle twists the part between it and the clamp, which is shorter in
/// proportion.
pub(crate) fn a_hand_rolls_what_it_holds(backend: &dyn Backend) -> Outcome {
    let (angle, frames) = (1.2, 10);
    let springs = Attachment::Spring { stiffness: 200.0, damping: 1.0 };
    // The hand's nodes, the clamp that opens, the expected twist.
    let cases = [
        ([8, 9], 1, -angle, Attachment::Pin),
        ([8, 9], 1, -angle, springs),
        ([0, 1], 0, angle, Attachment::Pin),
        // Edges have equal lengths, so 4 of 8 inner nodes are half of the rod.
        ([4, 5], 1, -2.0 * angle, Attachment::Pin),
    ];
    for (held, opens, expected, attachment) in cases {
        let twisted = |angle: f64| -> Result<f64, String> {
            let mut scene = cable();
            scene.last(frames);
            let still = scene.body(|_| IDENTITY);
            for (g, of) in [[0, 1], [2, 3]].iter().enumerate() {
                scene.grasp(pins(still, controls(of)), |_| g != opens);
            }
            let [a, b] = held;
            let (about, axis) = (scene.graph.rest_positions[a], along(&scene, a, b));
            let path = |f: usize| turn(about, axis, angle * f as f64 / frames as f64);
            let hand = scene.body(path);
            scene.grasp(Grasp { attachment, ..pins(hand, nodes(&held.map(|i| i as u32))) }, |_| {
                true
            });
            Ok(twist(&scene.end(backend)?))
        };
        let turned = twisted(angle)? - twisted(0.0)?;
        close(&format!("twist by nodes {held:?}"), turned, expected, 2e-3)?;
    }
    Ok(())
}

/// If two hands turn a whole cable as one body about any axis, it is not twisted: their rolls
/// cancel the turns of the nodes.
pub(crate) fn hands_that_turn_a_cable_do_not_twist_it(backend: &dyn Backend) -> Outcome {
    let mut scene = cable();
    scene.last(20);
    let still = scene.body(|_| IDENTITY);
    scene.grasp(pins(still, controls(&[0, 1, 2, 3])), |_| false);
    let axis = [0.36, 0.48, 0.8];
    for half in [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]] {
        let body = scene.body(|f| turn([0.1, 0.0, 0.2], axis, 0.05 * f as f64));
        scene.grasp(pins(body, nodes(&half)), |_| true);
    }
    scene.initial.twists = vec![0.5];
    let end = scene.end(backend)?;
    let moved = norm(difference(end.positions[7], scene.initial.positions[7]));
    ensure(moved > 0.1, || format!("node 7 moved by {moved} m"))?;
    close("twist", twist(&end), 0.5, 2e-3)
}

/// Where the span of a twisted rod grows, the twist spreads over it and loses energy, and nothing
/// moves at that moment; where all hands open, the twist is lost.
pub(crate) fn twist_spreads_over_a_longer_span(backend: &dyn Backend) -> Outcome {
    let mut scene = cable();
    scene.params.bend_stiffness.fill(0.0);
    scene.last(12);
    let still = scene.body(|_| IDENTITY);
    scene.grasp(pins(still, controls(&[0, 1])), |f| f < 9);
    scene.grasp(pins(still, controls(&[2, 3])), |_| false);
    scene.grasp(pins(still, nodes(&[4, 5])), |f| f < 9);
    scene.grasp(pins(still, nodes(&[8, 9])), |f| (6..9).contains(&f));
    scene.initial.twists = vec![1.0];
    let states = scene.states(backend)?;
    ensure(states.last() == Some(&scene.end(backend)?), || "it resumes differently".into())?;
    // Nothing resists or moves, so only hands change the twist.
    for (f, state) in states[..10].iter().enumerate() {
        let moved = state.positions.iter().zip(&states[0].positions);
        let moved = moved.map(|(a, b)| norm(difference(*a, *b))).fold(0.0, f64::max);
        close(&format!("way in {f} frames, twist {}", twist(state)), moved, 0.0, 1e-6)?;
    }
    close("twist of a part", twist(&states[6]), 1.0, 1e-5)?;
    close("twist of all of it", twist(&states[9]), 0.5, 1e-5)?;
    close("twist of nothing", twist(&states[12]), 0.0, 0.0)
}

/// Through clamps that open and hands that take a cable, with and without a branch at its end, move
/// and turn it: to 1 %.
pub(crate) fn gradients_through_regrasps(backend: &dyn Backend) -> Outcome {
    for (seed, mut scene) in [(0, cable()), (1, cable()), (2, branched_cable())] {
        let branches = seed == 2;
        scene.params.twist_stiffness[0] = 0.3;
        scene.params.twist_damping[0] = 3e-2;
        scene.params.rest_twists_rad[0] = -0.4;
        scene.params.spring_dashpot.fill(1.0);
        scene.params.bend_damping.fill(1e-3);
        scene.params.rest_angles_rad.fill(2.8);
        scene.params.drag = 1.0;
        scene.initial.twists = vec![1.5];
        scene.initial.velocities.fill([0.3, 0.1, 0.0]);
        scene.last(12);
        let still = scene.body(|_| IDENTITY);
        let axis = [0.36, 0.48, 0.8];
        let about = scene.graph.rest_positions[5];
        let hand = scene.body(|f| {
            let mut pose = turn(about, axis, 0.08 * f as f64);
            pose[1][3] += 0.002 * f as f32;
            pose
        });
        let other = scene.body(|f| pose([0.0, 0.0, 0.001 * f as f64], -0.05 * f as f64));
        if branches {
            // The near clamp opens, and a hand takes the cable farther along.
            scene.grasp(pins(still, controls(&[0, 1])), |f| f < 4);
            scene.grasp(pins(hand, nodes(&[3, 4])), |f| f >= 4);
        } else if seed == 0 {
            // The far clamp opens, a hand takes the middle, another one the tail later.
            scene.grasp(pins(still, controls(&[2, 3])), |f| f < 4);
            scene.grasp(pins(hand, nodes(&[5, 6])), |f| f >= 4);
            scene.grasp(pins(other, nodes(&[8, 9])), |f| f >= 8);
        } else {
            // Both hands hold by the nodes alone, one by springs.
            let attachment = Attachment::Spring { stiffness: 200.0, damping: 1.0 };
            scene.grasp(pins(still, controls(&[0, 1, 2, 3])), |f| f < 3);
            scene.grasp(Grasp { attachment, ..pins(hand, nodes(&[1, 2])) }, |f| f >= 3);
            scene.grasp(pins(other, nodes(&[7, 8])), |f| f >= 3);
        }
        scene.track_all();
        let must_matter =
            &["twist stiffness", "twist damping", "initial twists", "poses", "initial positions"];
        matches_differences(backend, &scene, &Check { seed, tolerance: 1e-2, must_matter })?;
    }
    Ok(())
}
