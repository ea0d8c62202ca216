//! Nodes that a fit has before it begins: sampled from a capture, or those of a twin that is refined.

use bendtwin_core::{Capture, Environment, Graph, Params, Skin, Twin};
use bendtwin_eval::Grip;
use bendtwin_graph::{Connectivity, LeftOut, NodeSample, Notes, SurfacePoints, mean_spacing};

use crate::{built_graph::BuiltGraph, task::Task};

/// Nodes, something that joins them, and the surface that they carry.
pub(crate) struct Nodes {
    pub(crate) sample: NodeSample,
    /// A graph of them; its springs carry the surface.
    pub(crate) graph: Graph,
    pub(crate) skin: Skin,
    /// The twin that they are of, in the capture.
    pub(crate) start: Option<Twin>,
}

impl Nodes {
    /// The nodes of a twin that is in a capture already.
    pub(crate) fn of_twin(twin: Twin, capture: &Capture) -> Self {
        let graph = &twin.graph;
        let sample = NodeSample {
            positions: graph.rest_positions.clone(),
            kinds: graph.kinds.clone(),
            observed_points: graph.observed_points.clone(),
            object_ids: graph.object_ids.clone(),
            control_rest: graph.control_rest.clone(),
            pins: graph.pins.clone(),
            edges: (!capture.object.edges.is_empty()).then(|| capture.object.edges.clone()),
            rest_shape: None,
            point_spacing_m: mean_spacing(&graph.rest_positions),
            spacing_scale: 1.0,
            surface: SurfacePoints::default(),
            left_out: LeftOut::default(),
        };
        Self { sample, graph: graph.clone(), skin: twin.skin.clone(), start: Some(twin) }
    }
}

/// Graph, parameters and environment of the twin that is refined, with the control points of other
/// recordings, which hold as firmly as the twin's own.
pub(crate) fn of_start(task: &Task<'_>, twin: &Twin) -> (BuiltGraph, Params, Environment) {
    let (mut graph, mut params) = (twin.graph.clone(), twin.params.clone());
    let (grip, own) = (Grip::of(&graph, &params), graph.springs.len());
    let connectivity = Connectivity::from_settings(&task.settings.graph, task.settings.bending);
    let lengths = &mut params.rest_lengths_m;
    task.others.attach(&connectivity, task.control_rest(), &mut graph, lengths);
    // Of each recording by itself: hands of different ones may be where others were.
    for controls in task.others.ranges(twin.graph.control_count()) {
        let n = graph.node_count();
        let is_held = |s: &&[u32; 2]| controls.contains(&(s[1] as usize - n));
        let first = (n + controls.start) as u32;
        let springs = graph.springs[own..].iter().filter(is_held);
        let springs: Vec<_> = springs.map(|[node, end]| [*node, end - first + n as u32]).collect();
        let at = &graph.control_rest[controls];
        for Grip { stiffness, dashpot } in grip.by_springs(n, at, &springs) {
            params.spring_stiffness.push(stiffness);
            params.spring_dashpot.push(dashpot);
        }
    }
    let built = BuiltGraph {
        graph: graph.into(),
        rest_lengths_m: params.rest_lengths_m.clone(),
        rest_angles_rad: params.rest_angles_rad.clone(),
        notes: Notes::default(),
    };
    (built, params, twin.environment)
}
