//! Initial states of rollouts: the rest shape, a frame of a capture, or a state that the caller
//! gives.

use std::sync::Arc;

use bendtwin_core::{Graph, Point, ids::CaptureId};
use bendtwin_engine::model::State;
use bendtwin_proto::v1::{
    InitialState,
    initial_state::{self as wire, GivenState, State as Wire},
};

use super::error::Error;

/// A state and the control points that belong to it.
#[derive(Clone, Debug)]
pub(super) struct Start {
    pub(super) state: Arc<State>,
    /// Control points [m], shape [C, 3].
    pub(super) controls: Arc<Vec<Point>>,
}

/// The starts of a batch.
pub(super) enum Starts {
    /// One for all instances.
    Shared(Start),
    /// One for each.
    Each(Vec<Start>),
}

/// Initial state as the request asks for it, before captures are read.
pub(super) enum Wanted {
    Ready(Starts),
    /// That of the frame, which is replayed apart: [`CaptureFrame::wanted`].
    Frame,
}

/// A frame of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct CaptureFrame {
    pub(super) capture: CaptureId,
    pub(super) sequence: usize,
    pub(super) frame: usize,
}

impl CaptureFrame {
    /// The frame that a request starts in, if it starts in one; `own_capture` is the twin's.
    pub(super) fn wanted(
        wire: Option<&InitialState>,
        own_capture: &str,
    ) -> Result<Option<Self>, Error> {
        match wire.and_then(|w| w.state.as_ref()) {
            Some(Wire::CaptureFrame(wire)) => Self::read(wire, own_capture).map(Some),
            _ => Ok(None),
        }
    }

    fn read(wire: &wire::CaptureFrame, own_capture: &str) -> Result<Self, Error> {
        const FIELD: &str = "initial.capture_frame.capture";
        let name = if wire.capture.is_empty() { own_capture } else { &wire.capture };
        let capture = name.parse::<CaptureId>().map_err(|e| Error::field(FIELD, e.to_string()))?;
        let (sequence, frame) = (wire.sequence as usize, wire.frame as usize);
        Ok(Self { capture, sequence, frame })
    }
}

impl Starts {
    /// The start of an instance.
    pub(super) fn of(&self, instance: usize) -> &Start {
        match self {
            Self::Shared(start) => start,
            Self::Each(starts) => &starts[instance],
        }
    }
}

impl Wanted {
    /// Reads the initial state of a checked request of `instances` instances.
    pub(super) fn read(
        wire: Option<InitialState>,
        graph: &Graph,
        instances: usize,
    ) -> Result<Self, Error> {
        match wire.and_then(|w| w.state) {
            None | Some(Wire::Rest(_) | Wire::Settled(_) | Wire::Session(_)) => {
                let state = Arc::new(State::rest(graph));
                let controls = Arc::new(graph.control_rest.clone());
                Ok(Self::Ready(Starts::Shared(Start { state, controls })))
            }
            Some(Wire::CaptureFrame(_)) => Ok(Self::Frame),
            Some(Wire::Given(wire)) => given(wire, graph, instances).map(Self::Ready),
        }
    }
}

fn given(wire: GivenState, graph: &Graph, instances: usize) -> Result<Starts, Error> {
    let (n, r) = (graph.node_count(), graph.rods.len());
    let (dims, positions) =
        wire.positions.unwrap_or_default().unpack_points("initial.given.positions")?;
    let each = dims.len() == 2;
    let velocities = match wire.velocities.filter(|t| !t.is_absent()) {
        None => vec![[0.0; 3]; positions.len()],
        Some(tensor) => tensor.unpack_points("initial.given.velocities")?.1,
    };
    let twists: Vec<f32> = match wire.twists.filter(|t| !t.is_absent()) {
        None => vec![0.0; r * if each { instances } else { 1 }],
        Some(tensor) => tensor.unpack("initial.given.twists")?.1,
    };
    let start = |i: usize| {
        let nodes = i * n..(i + 1) * n;
        let state = State {
            positions: positions[nodes.clone()].to_vec(),
            velocities: velocities[nodes].to_vec(),
            twists: twists[i * r..(i + 1) * r].to_vec(),
            ..State::default()
        };
        let controls = Arc::new(controls_of(graph, &state.positions));
        Start { state: Arc::new(state), controls }
    };
    Ok(if each {
        Starts::Each((0..instances).map(start).collect())
    } else {
        Starts::Shared(start(0))
    })
}

/// Control points that belong to a given state: a control point that
/// holds a node is where that node says, the others are at rest.
fn controls_of(graph: &Graph, positions: &[Point]) -> Vec<Point> {
    let mut controls = graph.control_rest.clone();
    // The first pin of a control point decides, so later ones are written first.
    for pin in graph.pins.iter().rev() {
        let node = positions[pin.node as usize];
        controls[pin.control as usize] = std::array::from_fn(|i| node[i] - pin.offset_m[i]);
    }
    controls
}
