//! Initial states of rollouts: the rest shape, settled or not, a frame of a capture, or a state that
//! the caller gives.

mod controls;

use std::sync::Arc;

use bendtwin_core::{
    Graph, Point,
    geometry::{length, sub},
    ids::CaptureId,
};
use bendtwin_engine::model::State;
use bendtwin_proto::v1::{
    InitialState,
    initial_state::{self as wire, GivenState, State as Wire},
};

use crate::{error::Error, request::grasping, twin::rest_shape::RestShape, world::Ended};

/// A state and the control points that belong to it.
#[derive(Clone, Debug)]
pub struct Start {
    pub(crate) state: Arc<State>,
    /// Control points [m], shape [C, 3].
    pub(crate) controls: Arc<Vec<Point>>,
    /// Places where grippers would have them, had the ground not held them back [m], shape [C];
    /// `None` if they are the same.
    pub(crate) commanded: Option<Arc<Vec<Point>>>,
    /// If some of them are not known but assumed to be at rest: where the nodes say that they may
    /// be [m], shape [C, 3].
    pub(crate) likely: Option<Arc<Vec<Point>>>,
    /// Rest shape, where it is not that of the twin.
    pub(crate) rest: Option<Arc<RestShape>>,
    /// Surroundings in which a simulation ended in it.
    pub(crate) around: Option<Arc<Ended>>,
}

/// Memory of where bodies are around a state, at most [bytes].
const BODIES_BYTES: usize = 4 << 10;

impl Start {
    /// A state whose control points are known [m], shape [C, 3], of a simulation with the twin's own
    /// rest shape.
    pub(crate) fn new(state: Arc<State>, controls: Arc<Vec<Point>>) -> Self {
        Self { state, controls, commanded: None, likely: None, rest: None, around: None }
    }

    /// Memory that it takes beside its rest shape [bytes].
    pub fn bytes(&self) -> u64 {
        (24 * (self.state.positions.len() + self.controls.len()) + BODIES_BYTES) as u64
    }

    /// Control points, or where they may be if they are not known [m], shape [C, 3].
    pub(crate) fn here(&self) -> &[Point] {
        self.likely.as_ref().unwrap_or(&self.controls)
    }

    /// The control points that grippers carry on [m], shape [C, 3].
    pub(crate) fn commanded(&self) -> &[Point] {
        self.commanded.as_ref().unwrap_or(&self.controls)
    }

    /// Largest distance between control points here and in the first row of the actions [m]. Where
    /// they are not known it counts from where they may be.
    pub(crate) fn gap_m(&self, row: &[Point]) -> f32 {
        self.here().iter().zip(row).map(|(a, b)| length(sub(*a, *b))).fold(0.0, f32::max)
    }
}

/// The starts of a batch.
pub enum Starts {
    /// A start for all instances.
    Shared(Start),
    /// A start for each instance.
    Each(Vec<Start>),
}

/// Initial state as the request asks for it, before captures are read.
pub enum Wanted {
    /// The state is there.
    Ready(Starts),
    /// The result of a separate simulation, or the state of a session: [`StartSimulation::wanted`].
    Simulation,
}

/// An initial state that a separate simulation leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartSimulation {
    /// The capture is replayed.
    Frame(CaptureFrame),
    /// The twin comes to rest.
    Settled,
}

impl StartSimulation {
    /// The simulation that a request needs before it starts, if any; `own_capture` is the twin's.
    ///
    /// # Errors
    /// If the name of the capture is invalid.
    pub fn wanted(wire: Option<&InitialState>, own_capture: &str) -> Result<Option<Self>, Error> {
        Ok(match wire.and_then(|w| w.state.as_ref()) {
            Some(Wire::CaptureFrame(at)) => Some(Self::Frame(CaptureFrame::read(at, own_capture)?)),
            Some(Wire::Settled(_)) => Some(Self::Settled),
            None | Some(Wire::Rest(_) | Wire::Given(_) | Wire::Session(_)) => None,
        })
    }
}

/// A frame of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CaptureFrame {
    /// The capture.
    pub capture: CaptureId,
    pub(crate) sequence: usize,
    pub(crate) frame: usize,
}

impl CaptureFrame {
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
    pub(crate) fn of(&self, instance: usize) -> &Start {
        match self {
            Self::Shared(start) => start,
            Self::Each(starts) => &starts[instance],
        }
    }

    /// Rest shapes that are not the twin's: one for all instances, or one for each.
    pub fn rests(&self) -> Vec<Option<Arc<RestShape>>> {
        match self {
            Self::Shared(start) => vec![start.rest.clone()],
            Self::Each(starts) => starts.iter().map(|start| start.rest.clone()).collect(),
        }
    }
}

impl Wanted {
    /// Reads the initial state of a checked request of `instances` instances.
    ///
    /// # Errors
    /// If a tensor of a given state is not what the check saw.
    pub fn read(
        wire: Option<InitialState>,
        graph: &Graph,
        instances: usize,
    ) -> Result<Self, Error> {
        match wire.and_then(|w| w.state) {
            None | Some(Wire::Rest(_)) => {
                let state = Arc::new(State::rest(graph));
                let controls = Arc::new(graph.control_rest.clone());
                Ok(Self::Ready(Starts::Shared(Start::new(state, controls))))
            }
            Some(Wire::CaptureFrame(_) | Wire::Settled(_) | Wire::Session(_)) => {
                Ok(Self::Simulation)
            }
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
    let controls = match wire.controls.filter(|t| !t.is_absent()) {
        None => None,
        Some(tensor) => Some(tensor.unpack_points("initial.given.controls")?.1),
    };
    let commanded = match wire.commanded_controls.filter(|t| !t.is_absent()) {
        None => None,
        Some(tensor) => Some(tensor.unpack_points("initial.given.commanded_controls")?.1),
    };
    let graspings = match &wire.grasping {
        None => None,
        Some(wire) => Some(grasping::read(wire, if each { instances } else { 1 }, n)?),
    };
    let start = |i: usize| {
        let nodes = i * n..(i + 1) * n;
        let grasping = graspings.as_ref().and_then(|all| all.get(i)).cloned().unwrap_or_default();
        let state = State {
            positions: positions[nodes.clone()].to_vec(),
            velocities: velocities[nodes].to_vec(),
            twists: twists[i * r..(i + 1) * r].to_vec(),
            grasping,
        };
        let c = graph.control_count();
        let row = |all: &Vec<Point>| all[i * c..(i + 1) * c].to_vec();
        let given = controls.as_ref().map(row);
        let commanded = commanded.as_ref().map(row).map(Arc::new);
        let likely = if given.is_some() { None } else { controls::likely(graph, &state.positions) };
        let controls = given.unwrap_or_else(|| controls::pinned(graph, &state.positions));
        let likely = likely.map(Arc::new);
        Start { commanded, likely, ..Start::new(Arc::new(state), Arc::new(controls)) }
    };
    Ok(if each {
        Starts::Each((0..instances).map(start).collect())
    } else {
        Starts::Shared(start(0))
    })
}
