//! Energies of a state: what the conformance suite budgets and diagnostics report.

use std::sync::Arc;

use bendtwin_core::{Graph, Point};

use crate::{
    Model,
    cpu::{
        arithmetic::{LANES, Node, Real, dot, quad, sub},
        elements::{Rod, bend},
        parameters::Parameters,
        rollout::{nodes_of, twists_of},
        system::{Layout, System},
    },
    model::State,
};

/// Energies [J per unit mass scale].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Sum of m v²/2.
    pub kinetic: f64,
    /// Elastic energy: of springs, k (l - l0)² / (2 l0); of triplets, k (theta - theta0)² / 2; and
    /// of rods, k (twist - rest)² / 2 for the part between clamps.
    pub elastic: f64,
    /// Sum of -m g . x; zero at the origin.
    pub gravitational: f64,
}

impl Energy {
    /// All of it.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravitational
    }
}

/// Energies of a state, in double precision, with the control points at `controls` [m], shape [C,
/// 3]. `None` if the lengths do not fit the model or the model contradicts itself.
pub fn energy(model: &Model, state: &State, controls: &[Point]) -> Option<Energy> {
    Energies::new(model)?.of(state, controls)
}

/// A model arranged for the energies of its states: that takes ten times as long as those of one.
pub struct Energies {
    system: System<f64>,
    graph: Arc<Graph>,
}

impl Energies {
    /// `None` if the model contradicts itself.
    pub fn new(model: &Model) -> Option<Self> {
        crate::cpu::check::model(model).ok()?;
        let parameters = Parameters::<f64>::from_params(&model.params);
        let system = System::new(model, &Layout::new(&model.graph), parameters);
        Some(Self { system, graph: model.graph.clone() })
    }

    /// Energies of a state; see [`energy`].
    pub fn of(&self, state: &State, controls: &[Point]) -> Option<Energy> {
        let n = self.graph.node_count();
        let fits = state.positions.len() == n
            && state.velocities.len() == n
            && (state.twists.is_empty() || state.twists.len() == self.graph.rods.len())
            && controls.len() == self.graph.control_count();
        fits.then(|| {
            let mut nodes = nodes_of(state);
            nodes.extend(controls.iter().map(|&p| Node { x: quad(p), v: [0.0; 4] }));
            of_nodes(&self.system, &nodes, &twists_of(state, &self.graph))
        })
    }
}

/// Energies of endpoints, shape [N + C], and twists, shape [R].
pub(crate) fn of_nodes<T: Real>(system: &System<T>, nodes: &[Node<T>], twists: &[T]) -> Energy {
    let elastic = elastic(system, nodes) + twisting(system, twists);
    let mut energy = Energy { elastic, ..Energy::default() };
    for (node, m) in nodes.iter().zip(&system.masses) {
        let m = m.to_f64();
        energy.kinetic += 0.5 * m * dot(node.v, node.v).to_f64();
        energy.gravitational -= m * dot(system.gravity, node.x).to_f64();
    }
    energy
}

fn elastic<T: Real>(system: &System<T>, nodes: &[Node<T>]) -> f64 {
    let mut sum = 0.0;
    for strip in &system.springs.strips {
        for b in &system.springs.blocks[strip.blocks()] {
            for l in 0..LANES {
                let length = length(nodes, strip.owners[l], b.other[l]);
                let stretch = length - b.rest[l].to_f64();
                sum += 0.5 * b.rate[l].to_f64() * stretch * stretch;
            }
        }
    }
    for strip in &system.triplets.strips {
        for b in &system.triplets.blocks[strip.blocks()] {
            for l in 0..LANES {
                let arm = |e: u32| {
                    let d = sub(nodes[e as usize].x, nodes[strip.owners[l] as usize].x);
                    [d[0].to_f64(), d[1].to_f64(), d[2].to_f64()]
                };
                let deviation = bend::deviation(arm(b.i[l]), arm(b.k[l]), b.rest_bend[l].to_f64());
                sum += 0.5 * b.stiffness[l].to_f64() * deviation * deviation;
            }
        }
    }
    sum
}

fn twisting<T: Real>(system: &System<T>, twists: &[T]) -> f64 {
    let of = |(rod, twist): (&Rod<T>, &T)| {
        let deviation = twist.to_f64() - rod.rest_twist.to_f64();
        0.5 * rod.stiffness.to_f64() * deviation * deviation / rod.inverse_share.to_f64()
    };
    system.rods.rods.iter().zip(twists).map(of).sum()
}

fn length<T: Real>(nodes: &[Node<T>], i: u32, j: u32) -> f64 {
    let r = sub(nodes[j as usize].x, nodes[i as usize].x);
    dot(r, r).to_f64().sqrt()
}

/// Largest |l/l0 - 1| of any spring that has a rest length: between two nodes, and to a control
/// point.
pub(crate) fn max_strains<T: Real>(system: &System<T>, nodes: &[Node<T>]) -> [f64; 2] {
    let mut most = [0.0_f64; 2];
    for strip in &system.springs.strips {
        for b in &system.springs.blocks[strip.blocks()] {
            for l in (0..LANES).filter(|&l| b.rest[l] > T::ZERO) {
                let (i, j) = (strip.owners[l], b.other[l]);
                let strain = (length(nodes, i, j) / b.rest[l].to_f64() - 1.0).abs();
                let kind = &mut most[usize::from(i.max(j) as usize >= system.nodes)];
                *kind = kind.max(strain);
            }
        }
    }
    most
}
