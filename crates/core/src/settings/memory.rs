//! Memory of a fit, estimated from its settings and from the size of its capture alone, so that a
//! fit that no worker has room for is refused before it begins.
//!
//! With P points, F frames, N nodes, C control points, E springs, T triplets, K models (starts, and
//! again as many to compare with), S sequences a step, L lanes (instances that are computed at
//! once), V pixels of views and G Gaussians, in bytes:
//!
//! | part | formula |
//! |---|---|
//! | capture | 2 F (14 P + 12 C) |
//! | targets | 2 F (12 P + 16 N + 12 C + 500), twice where steps have windows |
//! | candidate | 96 E + 112 T + 200 N |
//! | generation | candidates up to [`GENERATION_BYTES`], and 2 L at least; L (200 E + 320 T) to build them |
//! | run | K ((280 + 8 S) (3 E + 3 T + 5) + 2 candidates) |
//! | gradients, where they are computed in the worker's own memory | L (32 F (N + C) + tape + 200 E + 220 T + 400 N), tape 48 (N + C) a substep, up to 64 MiB |
//! | views | 6 V |
//! | appearance, where there are views and Gaussians | 2,500 G |
//!
//! The sum is that of a process, capture, targets and views, and the largest of the search
//! (generation), the refinement (run and gradients) and the appearance. Tests compare it with what
//! fits take.

use super::{Conditions, DeviceKind, FitSettings, GradientWindow};
use crate::capture::Subject;

/// Candidates of a generation loaded together, if one slice of them fits [bytes].
pub const GENERATION_BYTES: u64 = 256 << 20;
/// A worker before its first fit, and what does not grow with anything.
const PROCESS_BYTES: u64 = 64 << 20;
/// Largest tape of a gradient.
const TAPE_BYTES: u64 = 64 << 20;
/// Most triplets with one centre: those of the nearest sixteen neighbours with a reference.
const MOST_TRIPLETS: u64 = 15;
/// Largest numbers of neighbours that a search of the topology tries, if the settings have fewer.
const SEARCHED_NEIGHBOURS: u64 = 50;
const SEARCHED_CONTROL_NEIGHBOURS: u64 = 80;
/// Springs of a hand that reaches no node.
const LEAST_CONTROL_SPRINGS: u64 = 4;
/// A pixel of a view: colour, label and depth.
const VIEW_PIXEL_BYTES: u64 = 6;
/// A Gaussian in training: its parameters and their moments, where it is carried and projected, its
/// gradients, the list of the tiles that it touches, and a checkpoint beside them.
const GAUSSIAN_BYTES: u64 = 2_500;

/// A node in the distillation of a planner's twin: 40 windows of 31 frames of its motion, and of that
/// which is compared with it.
const DISTILLED_NODE_BYTES: u64 = 2 * 40 * 31 * 12;

/// Size of a capture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CaptureSize {
    /// Tracked points P.
    pub points: u64,
    /// Points of the completed surface.
    pub completed: u64,
    /// Points inside.
    pub interior: u64,
    /// Control points C.
    pub controls: u64,
    /// Frames F of all sequences.
    pub frames: u64,
    /// Frames of the longest sequence.
    pub longest: u64,
    /// Number of sequences.
    pub sequences: u64,
    /// Known edges; 0 for a body, whose springs are found by radius.
    pub edges: u64,
    /// Pixels V of all views; 0 for a capture without images.
    pub view_pixels: u64,
}

/// Size of a graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GraphSize {
    /// Nodes N.
    pub nodes: u64,
    /// Springs E.
    pub springs: u64,
    /// Triplets T.
    pub triplets: u64,
    /// Control points C.
    pub controls: u64,
}

/// The device that a fit computes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lanes {
    /// Instances computed together.
    pub count: u64,
    /// True if they take the worker's own memory, false if the device has its own.
    pub on_host: bool,
}

/// Threads that build candidates for a device with its own memory, at most.
const HOST_THREADS: u64 = 16;

/// Memory of a fit by its parts [bytes].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Estimate {
    /// The capture.
    pub capture: u64,
    /// Targets of the loss.
    pub targets: u64,
    /// The search.
    pub search: u64,
    /// The refinement.
    pub refinement: u64,
    /// Views of the recording.
    pub views: u64,
    /// The training of Gaussians.
    pub appearance: u64,
    /// The distillation of a planner's twin.
    pub planner: u64,
}

impl Estimate {
    /// All of it.
    pub fn total(&self) -> u64 {
        let stages = self.search.max(self.refinement).max(self.appearance).max(self.planner);
        let parts = [PROCESS_BYTES, self.capture, self.targets, self.views, stages];
        parts.into_iter().fold(0, u64::saturating_add)
    }
}

impl GraphSize {
    /// The largest graph that a fit may build by settings without open ones. The number of
    /// neighbours within the radius is not known here.
    pub fn largest(settings: &FitSettings, capture: &CaptureSize) -> Self {
        let of_starts = settings.of_starts().map(|settings| Self::of_start(&settings, capture));
        of_starts.fold(Self::default(), Self::or_larger)
    }

    /// The sizes that hold both graphs.
    #[must_use]
    pub fn or_larger(self, other: Self) -> Self {
        Self {
            nodes: self.nodes.max(other.nodes),
            springs: self.springs.max(other.springs),
            triplets: self.triplets.max(other.triplets),
            controls: self.controls.max(other.controls),
        }
    }

    fn of_start(settings: &FitSettings, capture: &CaptureSize) -> Self {
        let (graph, topology) = (&settings.graph, settings.search.topology);
        let searched = |value: usize, up_to: u64| {
            if topology { (value as u64).max(up_to) } else { value as u64 }
        };
        let controls = capture.controls;
        let (nodes, body_springs, triplets_each) = if capture.edges > 0 {
            (capture.points, capture.edges, 2)
        } else {
            let interior = if graph.interior == Some(false) { 0 } else { capture.interior };
            let pool = capture.points.saturating_add(capture.completed).saturating_add(interior);
            let kept = (pool as f64 * graph.sampling_ratio.clamp(0.0, 1.0)).ceil() as u64;
            let most = graph.max_nodes.map_or(u64::MAX, |most| most as u64);
            let nodes = kept.min(most).clamp(1, pool.max(1));
            let each = searched(graph.max_neighbours.unwrap_or(usize::MAX), SEARCHED_NEIGHBOURS);
            (nodes, nodes.saturating_mul(each.min(nodes - 1)), MOST_TRIPLETS)
        };
        let held = searched(graph.control_neighbours, SEARCHED_CONTROL_NEIGHBOURS)
            .max(LEAST_CONTROL_SPRINGS)
            .min(nodes);
        let triplets = triplets_each.min(graph.max_triplets as u64);
        Self {
            nodes,
            springs: body_springs.saturating_add(controls.saturating_mul(held)),
            triplets: if settings.bending { nodes.saturating_mul(triplets) } else { 0 },
            controls,
        }
    }

    /// A loaded candidate with its own graph [bytes].
    pub fn candidate_bytes(&self) -> u64 {
        sum([(96, self.springs), (112, self.triplets), (200, self.nodes)])
    }
}

/// Sum of products.
fn sum<const N: usize>(terms: [(u64, u64); N]) -> u64 {
    terms.into_iter().fold(0, |all, (a, b)| all.saturating_add(a.saturating_mul(b)))
}

impl CaptureSize {
    /// Conditions of a fit of such a capture on a device.
    pub fn conditions(&self, lanes: Lanes) -> Conditions {
        Conditions {
            subject: if self.edges > 0 { Subject::Cable } else { Subject::Body },
            device: if lanes.on_host { DeviceKind::Cpu } else { DeviceKind::Gpu },
            sequences: self.sequences.try_into().unwrap_or(usize::MAX),
            // No memory depends on it.
            is_weighed: false,
        }
    }
}

/// Memory of a fit by settings without open ones.
pub fn estimate(
    settings: &FitSettings,
    capture: &CaptureSize,
    graph: &GraphSize,
    lanes: Lanes,
) -> Estimate {
    let &CaptureSize { points, controls, frames, longest, sequences, view_pixels, .. } = capture;
    let gaussians = u64::from(settings.appearance.gaussians.unwrap_or_default());
    let &GraphSize { nodes, springs, triplets, .. } = graph;
    let windows = if settings.refine.window == GradientWindow::Pass { 2 } else { 4 };
    let starts = u64::from(settings.search.start_count());
    // Where frames are held back, these and the frames before them have separate targets.
    let holds_back = starts > 1 && settings.search.held_back > 0.0;
    let windows = if holds_back { 2 * windows } else { windows };
    let targets = sum([(12, points), (16, nodes), (12, controls), (1, 500)]).saturating_mul(frames);

    let models = starts * if settings.bending && settings.compare_axial { 2 } else { 1 };
    let candidate = graph.candidate_bytes();
    let population = settings.search.population.unwrap_or_default() as u64;
    let candidates = population.max(64).saturating_mul(models);
    let loaded = GENERATION_BYTES.max(sum([(lanes.count.max(1).saturating_mul(2), candidate)]));
    let threads = if lanes.on_host { lanes.count } else { lanes.count.min(HOST_THREADS) };
    let building = sum([(200, springs), (320, triplets)]).saturating_mul(threads.max(1));
    let search = candidates.saturating_mul(candidate).min(loaded).saturating_add(building);

    let batch = match settings.refine.batch.unwrap_or_default() as u64 {
        0 => sequences,
        batch => batch.min(sequences),
    };
    let coordinates = sum([(3, springs), (3, triplets), (1, 5)]);
    let per_coordinate = 280_u64.saturating_add(batch.saturating_mul(8));
    let run = sum([(per_coordinate, coordinates), (2, candidate)]);
    let endpoints = nodes.saturating_add(controls);
    let substeps = u64::from(settings.substeps.most());
    let tape = endpoints.saturating_mul(48).saturating_mul(substeps).min(TAPE_BYTES);
    let states = endpoints.saturating_mul(32).saturating_mul(longest.saturating_add(1));
    let lane = sum([(1, tape), (1, states), (200, springs), (220, triplets), (400, nodes)]);
    Estimate {
        capture: sum([(14, points), (12, controls)]).saturating_mul(frames).saturating_mul(2),
        targets: targets.saturating_mul(windows),
        search,
        refinement: sum([(models, run), (if lanes.on_host { lanes.count } else { 0 }, lane)]),
        views: sum([(VIEW_PIXEL_BYTES, view_pixels)]),
        appearance: if view_pixels > 0 { sum([(GAUSSIAN_BYTES, gaussians)]) } else { 0 },
        planner: if settings.planner.nodes.unwrap_or_default() > 0 {
            sum([(DISTILLED_NODE_BYTES, nodes)])
        } else {
            0
        },
    }
}

/// A value of one setting with which a fit would fit, as `name value`.
pub type Advice = (&'static str, u64);

/// Values of single settings, as large as possible, with which a fit stays within a number of
/// bytes.
pub fn what_would_fit(
    settings: &FitSettings,
    capture: &CaptureSize,
    lanes: Lanes,
    most: u64,
) -> Vec<Advice> {
    type Set = fn(&mut FitSettings, u64);
    let largest = GraphSize::largest(settings, capture);
    let knobs: [(&'static str, u64, Set); 4] = [
        ("graph.max_nodes", largest.nodes, |s, v| {
            s.graph.max_nodes = Some(v as usize);
        }),
        (
            "graph.max_neighbours",
            settings.graph.max_neighbours.unwrap_or_default() as u64,
            |s, v| {
                s.graph.max_neighbours = Some(v as usize);
            },
        ),
        ("search.starts", settings.search.starts.unwrap_or(1).into(), |s, v| {
            s.search.starts = Some(v as u32);
        }),
        (
            "appearance.gaussians",
            settings.appearance.gaussians.unwrap_or_default().into(),
            |s, v| {
                s.appearance.gaussians = Some(v as u32);
            },
        ),
    ];
    let fits = |set: Set, value: u64| {
        let mut changed = settings.clone();
        set(&mut changed, value);
        let graph = GraphSize::largest(&changed, capture);
        estimate(&changed, capture, &graph, lanes).total() <= most
    };
    let largest_that_fits = |&(name, value, set): &(&'static str, u64, Set)| {
        // What is off cannot be lowered.
        if value == 0 || !fits(set, 1) {
            return None;
        }
        let (mut low, mut high) = (1, value.max(2));
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if fits(set, middle) { low = middle } else { high = middle }
        }
        Some((name, low))
    };
    knobs.iter().filter_map(largest_that_fits).collect()
}

/// The refusal of a fit, with its need, the most that it may take, and what would fit.
pub fn refusal(needed: u64, most: u64, advice: &[Advice]) -> String {
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    let with: Vec<String> = advice.iter().map(|(name, value)| format!("{name} {value}")).collect();
    let what = match &with[..] {
        [] => "use a capture with fewer points or frames, or a worker with more memory".to_owned(),
        with => format!("it would fit with {}", with.join(", or with ")),
    };
    let (needed, most) = (gib(needed), gib(most));
    format!("the fit needs about {needed:.1} GiB of memory and may take {most:.1}: {what}")
}

#[cfg(test)]
mod tests;
