//! Memory of the fit of a capture that has been read: the formulas of
//! [`bendtwin_core::settings::memory`] with the graph that the fit will build.

use bendtwin_core::{
    Capture, FitSettings, Problem, Sequence, Views,
    settings::{
        GraphSettings,
        memory::{
            self, Advice, CaptureSize, GraphSize, Lanes, estimate as of_sizes, what_would_fit,
        },
    },
};
use bendtwin_engine::Backend;
use bendtwin_graph::{Connectivity, connect, sample_nodes};

/// A fit that needs more memory than it may take.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Problem)]
#[error("{}", memory::refusal(*.needed, *.most, .advice))]
// Asked again, it would be refused again: so it is not RESOURCE_EXHAUSTED.
#[problem(InvalidArgument, "FIT_OUT_OF_MEMORY")]
pub struct TooLarge {
    /// Bytes that it needs.
    pub needed: u64,
    /// Bytes that it may take.
    pub most: u64,
    /// Settings with which it would fit.
    pub advice: Vec<Advice>,
}

/// Memory of a fit [bytes], an upper bound by its settings, the capture and its views.
pub fn estimate(
    capture: &Capture,
    views: Option<&Views>,
    settings: &FitSettings,
    backend: &dyn Backend,
) -> u64 {
    let (size, lanes) = (size_of(capture, views), lanes(backend));
    let settings = settings.filled(size.conditions(lanes));
    of_sizes(&settings, &size, &GraphSize::largest(&settings, &size), lanes).total()
}

/// Memory of a fit [bytes], checked against a limit. Settings may allow far more springs than there
/// are neighbours within their radius, so where the bound exceeds the limit, the graph is built and
/// counted.
///
/// # Errors
/// [`TooLarge`].
pub fn check(
    capture: &Capture,
    views: Option<&Views>,
    settings: &FitSettings,
    backend: &dyn Backend,
    most: u64,
) -> Result<u64, TooLarge> {
    let bound = estimate(capture, views, settings, backend);
    if bound <= most {
        return Ok(bound);
    }
    let (size, lanes) = (size_of(capture, views), lanes(backend));
    let settings = &settings.filled(size.conditions(lanes));
    let largest = GraphSize::largest(settings, &size);
    // Too large even without springs, or the candidates have separate graphs.
    let is_hopeless = {
        let bare = GraphSize { springs: 0, triplets: 0, ..largest };
        of_sizes(settings, &size, &bare, lanes).total() > most
    };
    let searches_topology = settings.of_starts().any(|of_start| of_start.search.topology);
    let built = if is_hopeless || searches_topology { None } else { graph_of(capture, settings) };
    let needed =
        built.map_or(bound, |built| of_sizes(settings, &size, &built, lanes).total().min(bound));
    if needed <= most {
        return Ok(needed);
    }
    Err(TooLarge { needed, most, advice: what_would_fit(settings, &size, lanes, most) })
}

/// The graphs of all starts by the settings; none if there cannot be one, which the fit will say.
fn graph_of(capture: &Capture, settings: &FitSettings) -> Option<GraphSize> {
    let sample = sample_nodes(capture, &settings.graph, settings.seed).ok()?;
    let radius_m = Some(sample.radius_m(&settings.graph));
    let others = other_controls(capture);
    let sizes = settings.of_starts().map(|of_start| {
        let settings_of_graph = GraphSettings { radius_m, ..of_start.graph.clone() };
        let connectivity = Connectivity::from_settings(&settings_of_graph, of_start.bending);
        let graph = connect(&sample, &connectivity);
        let held = others.saturating_mul(connectivity.control_neighbours.min(graph.node_count()));
        GraphSize {
            nodes: graph.node_count() as u64,
            springs: graph.springs.len().saturating_add(held) as u64,
            triplets: graph.triplets.len() as u64,
            controls: (graph.control_count() + others) as u64,
        }
    });
    Some(sizes.fold(GraphSize::default(), GraphSize::or_larger))
}

pub(crate) fn lanes(backend: &dyn Backend) -> Lanes {
    let device = backend.device();
    Lanes { count: device.lanes as u64, on_host: device.kind == "cpu" }
}

/// Size of a capture with all recordings of its object, and of its views.
pub fn size_of(capture: &Capture, views: Option<&Views>) -> CaptureSize {
    let sequences: Vec<&Sequence> = capture.recordings().flat_map(|r| &r.sequences).collect();
    let frames = || sequences.iter().map(|s| s.frame_count as u64);
    // A frame's targets are points of one recording.
    let points = capture.recordings().map(|r| r.object.point_count).max().unwrap_or(0);
    CaptureSize {
        points: points as u64,
        completed: capture.object.completed_surface.len() as u64,
        interior: capture.object.interior.len() as u64,
        controls: (own_controls(capture) + other_controls(capture)) as u64,
        frames: frames().sum(),
        longest: frames().max().unwrap_or(0),
        sequences: sequences.len() as u64,
        edges: capture.object.edges.len() as u64,
        view_pixels: views.map_or(0, |views| views.pixel_count() as u64),
    }
}

/// Control points of the reference.
fn own_controls(capture: &Capture) -> usize {
    capture.sequences.first().map_or(0, Sequence::control_count)
}

/// Control points that the graph has for the sequences of other recordings.
fn other_controls(capture: &Capture) -> usize {
    capture.others.iter().flat_map(|r| &r.sequences).map(Sequence::control_count).sum()
}
