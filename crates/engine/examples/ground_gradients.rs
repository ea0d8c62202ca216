//! Compares gradients by controls with central differences, for twins that lie on the ground, with
//! impacts and with smooth contact:
//!
//! ```sh
//! cargo run -p bendtwin-engine --example ground_gradients -- 15 rope.twin bar_wave.twin
//! ```
//!
//! The first argument is the number of frames. The ground is put at the lowest node's height, the
//! twin settles for 20 frames, and its control points then move to the side. The loss is the mean
//! squared distance of all nodes to where they started, shifted by 5 cm. Everything is in double
//! precision; what is compared are the derivatives in random directions of all controls, as the
//! cosine between the two lists.

use std::sync::Arc;

use bendtwin_core::{Plane, Twin};
use bendtwin_engine::{
    Model, Objective, PointLoss, Term, objective::WeightedTerm, reference::Reference,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

type Failure = Box<dyn std::error::Error>;

/// Random directions.
const DIRECTIONS: usize = 8;
/// Step of every coordinate of a control point [m].
const STEP_M: f64 = 1e-5;
/// Frames in which a twin settles on the ground.
const SETTLING: usize = 20;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let frames: usize =
        arguments.next().ok_or("usage: ground_gradients FRAMES TWIN...")?.parse()?;
    println!("twin | width mm | cosine | |gradient| / |difference|");
    for path in arguments {
        let model = on_the_ground(&Twin::decode(&std::fs::read(&path)?)?);
        for smoothing_m in [0.0, 1e-3, 2e-3, 5e-3] {
            let (cosine, ratio) = compare(&model, frames, smoothing_m)?;
            println!("{path} | {:.0} | {cosine:.4} | {ratio:.3}", f64::from(smoothing_m) * 1e3);
        }
    }
    Ok(())
}

/// The twin's model with the ground at its lowest node.
fn on_the_ground(twin: &Twin) -> Model {
    let mut model = Model::from(twin);
    let up = model.environment.ground.map_or([0.0, 0.0, 1.0], |g| g.normal);
    let height = |p: &[f32; 3]| p[0] * up[0] + p[1] * up[1] + p[2] * up[2];
    let lowest = model.graph.rest_positions.iter().map(height).fold(f32::INFINITY, f32::min);
    model.environment.ground = Some(Plane { normal: up, offset_m: lowest });
    model
}

/// Cosine between derivatives and differences in random directions, and the ratio of their norms.
fn compare(model: &Model, frames: usize, smoothing_m: f32) -> Result<(f64, f64), Failure> {
    let mut settling = Reference::new(model, SETTLING)?;
    settling.world.smoothing_m = smoothing_m;
    let state = settling.roll_out()?.pop().ok_or("no state")?;
    let mut run = Reference::new(model, frames)?;
    run.world.smoothing_m = smoothing_m;
    let shifted = |p: &[f64; 3]| [p[0] as f32 + 0.05, p[1] as f32, p[2] as f32];
    let objective = Objective {
        groups: vec!["track".into()],
        terms: Arc::new(vec![WeightedTerm {
            frame: frames,
            weight: 1.0,
            group: 0,
            term: Term::Track {
                nodes: (0..state.positions.len() as u32).collect(),
                targets: state.positions.iter().map(shifted).collect(),
                loss: PointLoss::SquaredDistance,
            },
        }]),
    };
    (run.positions, run.velocities, run.twists) = (state.positions, state.velocities, state.twists);
    let controls = model.graph.control_count();
    for (row, p) in run.controls.iter_mut().enumerate() {
        p[0] += 0.002 * (row / controls.max(1)) as f64;
    }
    let gradient = run.gradient(&objective, 0)?.controls;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut both, mut exact, mut finite) = (0.0, 0.0, 0.0);
    for _ in 0..DIRECTIONS {
        let direction: Vec<[f64; 3]> = (0..run.controls.len())
            .map(|row| {
                // The first row belongs to the initial state.
                let size = if row < controls { 0.0 } else { 1.0 };
                std::array::from_fn(|_| size * (2.0 * rng.random::<f64>() - 1.0))
            })
            .collect();
        let at = |by: f64| -> Result<f64, Failure> {
            let mut moved = run.clone();
            for (p, d) in moved.controls.iter_mut().zip(&direction) {
                *p = std::array::from_fn(|c| p[c] + by * d[c]);
            }
            Ok(moved.loss(&objective)?.total)
        };
        let difference = (at(STEP_M)? - at(-STEP_M)?) / (2.0 * STEP_M);
        let pairs = gradient.iter().flatten().zip(direction.iter().flatten());
        let derivative: f64 = pairs.map(|(g, d)| g * d).sum();
        both += derivative * difference;
        exact += derivative * derivative;
        finite += difference * difference;
    }
    Ok((both / (exact * finite).sqrt(), (exact / finite).sqrt()))
}
