//! Objectives on the device.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
};

use bendtwin_engine::{
    Error, Objective, PointLoss, PointSet, Term,
    objective::{ForceBy, WeightedTerm},
};
use cudarc::driver::CudaStream;

use crate::device::{
    args::{self, ObjectiveArgs, Piece},
    memory::Buffer,
    specialization::{TARGETS_EACH, THREADS},
};

/// Targets kept at a time (a few hundred megabytes): a fit asks for the same ones again and again.
const KEPT_TARGETS: usize = 1 << 24;
/// A region that is meant for all nodes, a term at the skin, and the kinds of terms that seek the nearest
/// points of targets; see `kernels/objective.cuh`.
const ALL_NODES: u32 = 1;
const SKIN: u32 = 1;
const CHAMFER: u32 = 0;
const COVERAGE: u32 = 10;
/// Targets that a block seeks the nearest points of.
const PIECE: u32 = TARGETS_EACH * THREADS;
/// Objectives kept at a time.
const KEPT: usize = 256;

/// An objective's terms, ordered by frame.
pub(crate) struct DeviceObjective {
    /// Keeps the address that it is known by.
    terms: Arc<Vec<WeightedTerm>>,
    on_device: Buffer<args::Term>,
    frame_terms: Buffer<u32>,
    pieces: Buffer<Piece>,
    targets: Buffer<[f32; 3]>,
    target_points: Buffer<u32>,
    /// Index in the objective of the term of each piece.
    pub(crate) order: Vec<u32>,
    skin_frames: Buffer<u32>,
    pub(crate) target_count: usize,
    /// True if a term measures strains.
    pub(crate) has_strains: bool,
    frames: usize,
}

/// The objectives that a queue has seen lately.
#[derive(Default)]
pub(crate) struct Objectives(Mutex<HashMap<(usize, usize), Arc<DeviceObjective>>>);

impl Objectives {
    /// The device's copy of a checked objective of a rollout with the given number of frames.
    pub(crate) fn get(
        &self,
        stream: &Arc<CudaStream>,
        objective: &Objective,
        frames: usize,
    ) -> Result<Arc<DeviceObjective>, Error> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (Arc::as_ptr(&objective.terms) as usize, frames);
        if let Some(found) = kept.get(&key) {
            return Ok(found.clone());
        }
        let made = Arc::new(DeviceObjective::new(stream, &objective.terms, frames)?);
        let targets = kept.values().map(|o| o.target_count).sum::<usize>() + made.target_count;
        if kept.len() >= KEPT || targets > KEPT_TARGETS {
            kept.clear();
        }
        kept.insert(key, made.clone());
        Ok(made)
    }
}

impl DeviceObjective {
    fn new(
        stream: &Arc<CudaStream>,
        terms: &Arc<Vec<WeightedTerm>>,
        frames: usize,
    ) -> Result<Self, Error> {
        let mut order: Vec<u32> = (0..terms.len() as u32).collect();
        order.sort_by_key(|&t| terms[t as usize].frame);
        let (mut targets, mut target_points, mut on_device) = (Vec::new(), Vec::new(), Vec::new());
        let mut frame_terms = vec![0_u32; frames + 2];
        let skin_frames = skin_frames(terms);
        for &t in &order {
            let weighted = &terms[t as usize];
            frame_terms[weighted.frame + 1] += 1;
            let first = targets.len() as u32;
            let mut term = args::Term {
                frame: weighted.frame as u32,
                first,
                weight: weighted.weight,
                ..args::Term::default()
            };
            match &weighted.term {
                Term::Chamfer { targets: own, .. } => {
                    term.kind = CHAMFER;
                    targets.extend_from_slice(own);
                    target_points.resize(targets.len(), 0);
                }
                Term::Track { points, targets: own, loss, .. } => {
                    term.kind = 1;
                    (term.loss, term.beta) = match *loss {
                        PointLoss::SmoothL1 { beta_m } => (0, beta_m),
                        PointLoss::Distance => (1, 0.0),
                        PointLoss::SquaredDistance => (2, 0.0),
                    };
                    targets.extend_from_slice(own);
                    target_points.extend_from_slice(points);
                }
                Term::Acceleration => term.kind = 2,
                Term::Strain { limit } => (term.kind, term.beta) = (3, *limit),
                Term::Above { nodes, normal, offset_m } => {
                    (term.kind, term.beta, term.low) = (4, *offset_m, *normal);
                    region(nodes.as_ref(), &mut term, &mut targets, &mut target_points);
                }
                Term::Within { nodes, low, high } => {
                    (term.kind, term.low, term.high) = (5, *low, *high);
                    region(nodes.as_ref(), &mut term, &mut targets, &mut target_points);
                }
                Term::Clearance { collider, margin_m } => {
                    (term.kind, term.part, term.beta) = (6, *collider, *margin_m);
                }
                Term::Force { by, limit } => {
                    (term.kind, term.beta) = (7, *limit);
                    (term.loss, term.part) = match *by {
                        ForceBy::Controls => (0, 0),
                        ForceBy::Control(c) => (1, c),
                        ForceBy::Grasp(g) => (2, g),
                        ForceBy::Ground => (3, 0),
                        ForceBy::Collider(k) => (4, k),
                    };
                }
                Term::Order { points, direction, gap_m, .. } => {
                    (term.kind, term.beta, term.low) = (8, *gap_m, *direction);
                    listed(points, &mut targets, &mut target_points);
                }
                Term::Winding { points, origin, direction, turns, .. } => {
                    (term.kind, term.beta) = (9, *turns);
                    (term.low, term.high) = (*origin, *direction);
                    listed(points, &mut targets, &mut target_points);
                }
                Term::Coverage { targets: own, reach_m, .. } => {
                    (term.kind, term.beta) = (COVERAGE, *reach_m);
                    targets.extend_from_slice(own);
                    target_points.resize(targets.len(), 0);
                }
            }
            if is_at_skin(weighted) {
                term.of = SKIN;
                // The row of its frame.
                term.part = skin_frames.partition_point(|&f| f < term.frame) as u32;
            }
            term.count = targets.len() as u32 - first;
            on_device.push(term);
        }
        let pieces = pieces(&on_device);
        for f in 0..=frames {
            frame_terms[f + 1] += frame_terms[f];
        }
        Ok(Self {
            on_device: Buffer::of(stream, &on_device)?,
            frame_terms: Buffer::of(stream, &frame_terms)?,
            targets: Buffer::of(stream, &targets)?,
            target_points: Buffer::of(stream, &target_points)?,
            skin_frames: Buffer::of(stream, &skin_frames)?,
            target_count: targets.len(),
            has_strains: terms.iter().any(|t| matches!(t.term, Term::Strain { .. })),
            terms: terms.clone(),
            order: pieces.iter().map(|p| order[p.term as usize]).collect(),
            pieces: Buffer::of(stream, &pieces)?,
            frames,
        })
    }

    /// Arguments of an instance's objective; `nearest` has room for its targets, `values` for its
    /// pieces.
    pub(crate) fn args(&self, nodes: usize, surface: usize) -> ObjectiveArgs {
        ObjectiveArgs {
            terms: self.on_device.address(),
            frame_terms: self.frame_terms.address(),
            targets: self.targets.address(),
            target_points: self.target_points.address(),
            pieces: self.pieces.address(),
            skin_frames: self.skin_frames.address(),
            node_count: nodes as u32,
            surface_count: surface as u32,
            frame_count: self.frames as u32,
            term_count: self.on_device.len() as u32,
            piece_count: self.pieces.len() as u32,
            skin_frame_count: self.skin_frames.len() as u32,
            ..ObjectiveArgs::default()
        }
    }

    /// Number of frames with terms at the skin.
    pub(crate) fn skin_frame_count(&self) -> usize {
        self.skin_frames.len()
    }

    /// Weighted sums by group of values in this order.
    pub(crate) fn groups(&self, values: &[f64], groups: usize) -> Vec<f64> {
        let mut sums = vec![0.0; groups];
        // Added up in the objective's order within a frame, as terms are ordered by frame here.
        for (&t, value) in self.order.iter().zip(values) {
            sums[self.terms[t as usize].group] += value;
        }
        sums
    }

    /// Groups by frame, shape [F + 1, groups].
    pub(crate) fn frame_groups(&self, values: &[f64], groups: usize) -> Vec<f64> {
        let mut sums = vec![0.0; (self.frames + 1) * groups];
        for (&t, value) in self.order.iter().zip(values) {
            let term = &self.terms[t as usize];
            sums[term.frame * groups + term.group] += value;
        }
        sums
    }
}

/// Pieces of terms, in their order.
fn pieces(terms: &[args::Term]) -> Vec<Piece> {
    let of = |(index, term): (u32, &args::Term)| {
        let seeks_nearest = matches!(term.kind, CHAMFER | COVERAGE);
        let count = if seeks_nearest { term.count } else { 0 };
        let firsts = (0..count.max(1)).step_by(PIECE as usize);
        firsts.map(move |first| Piece { term: index, first })
    };
    (0..).zip(terms).flat_map(of).collect()
}

/// True for a term that is about points of the skin.
fn is_at_skin(term: &WeightedTerm) -> bool {
    match &term.term {
        Term::Chamfer { of, .. }
        | Term::Track { of, .. }
        | Term::Order { of, .. }
        | Term::Winding { of, .. }
        | Term::Coverage { of, .. } => *of == PointSet::Skin,
        Term::Acceleration
        | Term::Strain { .. }
        | Term::Above { .. }
        | Term::Within { .. }
        | Term::Clearance { .. }
        | Term::Force { .. } => false,
    }
}

/// Frames with terms at the skin, ascending.
pub(crate) fn skin_frames(terms: &[WeightedTerm]) -> Vec<u32> {
    let at_skin = terms.iter().filter(|t| is_at_skin(t));
    let mut frames: Vec<u32> = at_skin.map(|t| t.frame as u32).collect();
    frames.sort_unstable();
    frames.dedup();
    frames
}

/// Appends a region's nodes to the points of targets, or marks that it is for all.
fn region(
    nodes: Option<&Arc<Vec<u32>>>,
    term: &mut args::Term,
    targets: &mut Vec<[f32; 3]>,
    target_points: &mut Vec<u32>,
) {
    match nodes {
        None => term.loss = ALL_NODES,
        Some(some) => listed(some, targets, target_points),
    }
}

/// Appends points to those of targets; one array is as long as the other.
fn listed(points: &[u32], targets: &mut Vec<[f32; 3]>, target_points: &mut Vec<u32>) {
    target_points.extend_from_slice(points);
    targets.resize(target_points.len(), [0.0; 3]);
}
