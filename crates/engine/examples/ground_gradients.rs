//! Compares gradients by knots with central differences, for twins that lie on the ground, with
//! impacts and with smooth contact:
//!
//! ```sh
//! bendtwin capture make rope DIR/rope.zip
//! cargo lab suite studies/ground.json --data DIR --out OUT
//! cargo run --release -p bendtwin-engine --example ground_gradients -- 15 OUT/twins/*/*/0.twin
//! ```
//!
//! The first argument is the number of frames. The ground is at the height of the twin's lowest node,
//! with a friction of at least 0.5. The twin settles in the contact that it is then measured in: its
//! hands come down by 5 mm a frame until a fifth of its nodes touches the ground or they are 1 cm
//! above it, and stay there for 20 frames. Each hand is then moved by four knots, which are
//! interpolated linearly: 2 mm a frame to the side, as much upwards, or half as much downwards. The
//! loss is the mean squared distance, at the end, of the nodes that touch the ground at the start to
//! where they were then, shifted to the side by 5 cm. Everything is in double precision.
//!
//! Derivatives by all coordinates of the last three knots are compared with differences of the same
//! loss between a step to either side, which are mean derivatives over twice the step: a step of 1 mm
//! is what a planner may take. A row has the width of the layer; the nodes that touch the
//! ground at the start, the mean over frames and motions of those that do, and of those among them
//! that slide faster than 1 cm/s; the cosines between derivatives and differences for the three
//! motions, for either step; the ratio of norms that is farthest from 1; and the largest growth of a
//! gradient: its largest norm at a frame's end by that at the last one.

use std::sync::Arc;

use bendtwin_core::{Plane, Twin, geometry::dot};
use bendtwin_engine::{
    Model, Objective, PointLoss, PointSet, Term,
    objective::WeightedTerm,
    reference::{Point64, Reference, ReferenceState},
};

type Failure = Box<dyn std::error::Error>;

/// Widths of the layer of smooth contact [m].
const WIDTHS_M: [f32; 4] = [0.0, 1e-3, 2e-3, 5e-3];
/// Steps of a coordinate of a knot [m].
const STEPS_M: [f64; 2] = [1e-4, 1e-3];
/// Frames in which a twin settles on the ground after its hands have come down.
const SETTLING: usize = 20;
/// Most frames in which they do, and their way in each [m].
const COMING_DOWN: (usize, f64) = (100, 0.005);
/// Height above the ground to which hands come down [m].
const HAND_M: f64 = 0.01;
/// Least friction of the ground.
const FRICTION: f32 = 0.5;
/// Way of a hand in a frame [m].
const WAY_M: f64 = 0.002;
/// Way from the start to the target [m].
const TARGET_M: f64 = 0.05;
/// Knots, the first of which does not move.
const KNOTS: usize = 4;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let frames: usize =
        arguments.next().ok_or("usage: ground_gradients FRAMES TWIN...")?.parse()?;
    println!(
        "width mm | touch, mean, slide | cosines at {STEPS_M:?} m: aside, up, down | ratio | growth"
    );
    for path in arguments {
        let twin = Twin::decode(&std::fs::read(&path)?)?;
        println!("{path}: {} nodes", twin.graph.node_count());
        for width_m in WIDTHS_M {
            println!("{}", Scene::new(&twin, frames, width_m)?.row()?);
        }
    }
    Ok(())
}

/// The comparison for one motion.
struct Compared {
    /// Cosine and ratio of norms, for each step.
    by_step: [(f64, f64); STEPS_M.len()],
    /// Nodes in contact, and those that slide.
    contacts: [f64; 2],
    growth: f64,
}

/// A twin that lies on the ground.
struct Scene {
    knots: Knots,
    up: Point64,
    aside: Point64,
    /// Distance of the ground from the origin along its normal [m].
    offset: f64,
    /// At rest where the hands are, for the frames to be measured.
    run: Reference,
    /// Nodes that touch the ground at the start.
    touching: Vec<u32>,
    objective: Objective,
}

impl Scene {
    fn new(twin: &Twin, frames: usize, width_m: f32) -> Result<Self, Failure> {
        let model = on_the_ground(twin);
        let ground = model.environment.ground.ok_or("no ground")?;
        let (up, offset) = (ground.normal.map(f64::from), f64::from(ground.offset_m));
        let (start, controls) = settled(&model, width_m)?;
        let mut run = Reference::new(&model, frames)?;
        run.world.smoothing_m = width_m;
        run.controls = controls.repeat(frames + 1);
        let axis = if up[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let across = along(up, &axis);
        let aside: Point64 = std::array::from_fn(|c| axis[c] - across * up[c]);
        let low = |(_, x): &(u32, &Point64)| touches(width_m, along(up, x) - offset);
        let touching: Vec<u32> =
            (0..).zip(&start.positions).filter(low).map(|(node, _)| node).collect();
        let objective = shifted(&start.positions, &touching, aside, frames);
        (run.positions, run.velocities) = (start.positions, start.velocities);
        run.twists = start.twists;
        let knots = Knots { hands: twin.hands(), frames };
        Ok(Self { knots, up, aside, offset, run, touching, objective })
    }

    /// The row of the table.
    fn row(&self) -> Result<String, Failure> {
        let ways = [self.aside, self.up, self.up.map(|x| -0.5 * x)];
        let all = ways.into_iter().map(|way| self.compare(way)).collect::<Result<Vec<_>, _>>()?;
        let mean = |k: usize| all.iter().map(|c| c.contacts[k]).sum::<f64>() / all.len() as f64;
        let cosines = (0..STEPS_M.len()).map(|step| {
            let of: Vec<String> = all.iter().map(|c| format!("{:.3}", c.by_step[step].0)).collect();
            of.join(" ")
        });
        let cosines: Vec<String> = cosines.collect();
        let ratios = all.iter().flat_map(|c| c.by_step).map(|(_, ratio)| ratio);
        let worst = ratios.max_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs())).unwrap_or(1.0);
        let growth = all.iter().map(|c| c.growth).fold(0.0, f64::max);
        Ok(format!(
            "{:.0} | {}, {:.0}, {:.0} | {} | {worst:.2} | {growth:.1}",
            1e3 * self.run.world.smoothing_m,
            self.touching.len(),
            mean(0),
            mean(1),
            cosines.join("; ")
        ))
    }

    /// Derivatives and differences for hands that move this way in each frame.
    fn compare(&self, way: Point64) -> Result<Compared, Failure> {
        let mut run = self.run.clone();
        let controls = self.knots.hands.len();
        for (row, p) in run.controls.iter_mut().enumerate() {
            let by = WAY_M * (row / controls) as f64;
            *p = std::array::from_fn(|c| p[c] + by * way[c]);
        }
        let gradient = run.gradient(&self.objective, 0)?;
        let derivatives = self.knots.derivatives(&gradient.controls);
        let mut by_step = [(0.0, 0.0); STEPS_M.len()];
        for (found, step) in by_step.iter_mut().zip(STEPS_M) {
            let difference = |variable: usize| -> Result<f64, Failure> {
                let loss = |by: f64| self.knots.moved(&run, variable, by).loss(&self.objective);
                Ok((loss(step)?.total - loss(-step)?.total) / (2.0 * step))
            };
            let differences: Vec<f64> =
                (0..derivatives.len()).map(difference).collect::<Result<_, _>>()?;
            let size = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
            let both: f64 = derivatives.iter().zip(&differences).map(|(a, b)| a * b).sum();
            let (exact, finite) = (size(&derivatives), size(&differences));
            *found = (both / (exact * finite), exact / finite);
        }
        let largest = gradient.norms.iter().copied().fold(0.0, f64::max);
        let growth = largest / gradient.norms[self.knots.frames];
        Ok(Compared { by_step, contacts: self.contacts(&run)?, growth })
    }

    /// Nodes in contact and those among them that slide, means over frames.
    fn contacts(&self, run: &Reference) -> Result<[f64; 2], Failure> {
        let mut counts = [0.0; 2];
        for state in run.roll_out()?.iter().skip(1) {
            for (x, v) in state.positions.iter().zip(&state.velocities) {
                let rises = along(self.up, v);
                let flat = v.iter().zip(self.up).map(|(v, n)| (v - rises * n).powi(2)).sum::<f64>();
                if touches(run.world.smoothing_m, along(self.up, x) - self.offset) {
                    counts[0] += 1.0 / self.knots.frames as f64;
                    counts[1] += f64::from(flat.sqrt() > 0.01) / self.knots.frames as f64;
                }
            }
        }
        Ok(counts)
    }
}

/// Paths of hands: each is moved as a whole by knots spread evenly over the frames. The variables are
/// the coordinates of all knots but the first, hand by hand.
struct Knots {
    hands: Vec<u32>,
    frames: usize,
}

impl Knots {
    /// Share of a variable in a coordinate of a control point in a row of the controls.
    fn weight(&self, variable: usize, row: usize, axis: usize) -> f64 {
        let (frame, control) = (row / self.hands.len(), row % self.hands.len());
        let (hand, knot) = (variable / 3 / (KNOTS - 1), variable / 3 % (KNOTS - 1) + 1);
        if variable % 3 != axis || self.hands[control] as usize != hand {
            return 0.0;
        }
        let at = (frame * (KNOTS - 1)) as f64 / self.frames as f64;
        (1.0 - (at - knot as f64).abs()).max(0.0)
    }

    /// Derivatives by the variables from those by control positions.
    fn derivatives(&self, controls: &[Point64]) -> Vec<f64> {
        let hands = self.hands.iter().max().map_or(0, |last| *last as usize + 1);
        let derivative = |variable: usize| -> f64 {
            let rows = controls.iter().enumerate();
            rows.flat_map(|(row, g)| (0..3).map(move |axis| (row, axis, g[axis])))
                .map(|(row, axis, g)| g * self.weight(variable, row, axis))
                .sum()
        };
        (0..hands * (KNOTS - 1) * 3).map(derivative).collect()
    }

    /// The simulation with one variable moved.
    fn moved(&self, from: &Reference, variable: usize, by: f64) -> Reference {
        let mut moved = from.clone();
        for (row, p) in moved.controls.iter_mut().enumerate() {
            for (axis, x) in p.iter_mut().enumerate() {
                *x += by * self.weight(variable, row, axis);
            }
        }
        moved
    }
}

/// The twin's model with the ground at its lowest node.
fn on_the_ground(twin: &Twin) -> Model {
    let mut model = Model::from(twin);
    let normal = model.environment.ground.map_or([0.0, 0.0, 1.0], |g| g.normal);
    let heights = model.graph.rest_positions.iter().map(|p| dot(normal, *p));
    let offset_m = heights.fold(f32::INFINITY, f32::min);
    model.environment.ground = Some(Plane { normal, offset_m });
    let friction = &mut model.params.contact.ground_friction;
    *friction = friction.max(FRICTION);
    model
}

/// State and control points of a model that has settled, with its hands near the ground.
fn settled(model: &Model, width_m: f32) -> Result<(ReferenceState, Vec<Point64>), Failure> {
    let ground = model.environment.ground.ok_or("no ground")?;
    let (up, offset) = (ground.normal.map(f64::from), f64::from(ground.offset_m));
    let mut run = Reference::new(model, 1)?;
    run.world.smoothing_m = width_m;
    let controls = model.graph.control_count();
    let mut at = run.controls.split_off(controls);
    let (mut coming_down, mut settling) = (0..COMING_DOWN.0, 0..SETTLING);
    loop {
        let low = |x: &Point64| touches(width_m, along(up, x) - offset);
        let touching = run.positions.iter().filter(|x| low(x)).count();
        let lowest = at.iter().map(|p| along(up, p) - offset).fold(f64::INFINITY, f64::min);
        let is_high = lowest > HAND_M && 5 * touching < run.positions.len();
        let before = at.clone();
        if is_high && coming_down.next().is_some() {
            at.iter_mut().for_each(|p| *p = std::array::from_fn(|c| p[c] - COMING_DOWN.1 * up[c]));
        } else if settling.next().is_none() {
            let Reference { positions, velocities, twists, .. } = run;
            return Ok((ReferenceState { positions, velocities, twists }, at));
        }
        run.controls = [before, at.clone()].concat();
        let state = run.roll_out()?.pop().ok_or("no state")?;
        (run.positions, run.velocities) = (state.positions, state.velocities);
        run.twists = state.twists;
    }
}

/// True if a node at this height is in the layer of smooth contact, or within 1 mm.
fn touches(width_m: f32, height: f64) -> bool {
    height < (0.5 * f64::from(width_m)).max(1e-3)
}

fn along(up: Point64, p: &Point64) -> f64 {
    p.iter().zip(up).map(|(x, n)| x * n).sum()
}

/// Mean squared distance of some nodes at the end to where they are, shifted.
fn shifted(positions: &[Point64], nodes: &[u32], way: Point64, frames: usize) -> Objective {
    let target = |node: &u32| {
        let p = positions[*node as usize];
        std::array::from_fn(|c| (p[c] + TARGET_M * way[c]) as f32)
    };
    let term = Term::Track {
        of: PointSet::Nodes,
        points: nodes.to_vec(),
        targets: nodes.iter().map(target).collect(),
        loss: PointLoss::SquaredDistance,
    };
    Objective {
        groups: vec!["track".into()],
        terms: Arc::new(vec![WeightedTerm { frame: frames, weight: 1.0, group: 0, term }]),
    }
}
