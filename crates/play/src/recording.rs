//! The actions of a play, as rollouts: each segment is a request that anyone can send, complete with
//! the state that it begins in. A segment ends where something changes that a request has once: the
//! world, parameters, or more grasps than its list has.

use bendtwin_core::ids::TwinId;
use bendtwin_proto::{
    json::{Read, TensorFormat, Write},
    v1::{
        InitialState, Returns, RollOutRequest,
        initial_state::{GivenState, State},
    },
};
use prost::Message as _;
use serde::{Deserialize, Serialize, Serializer, ser::SerializeSeq as _};

use super::rows::{self, Rows};
use crate::{Error, Result};

/// Most memory of a recording [bytes]: as a document it takes about half as much again.
const MOST_BYTES: usize = 8 << 20;
/// Most segments of a recording.
const MOST_SEGMENTS: usize = 4096;

/// A part of a recording that is one rollout.
#[derive(Clone, Debug)]
pub(super) struct Segment {
    /// The request without its actions.
    pub(super) template: RollOutRequest,
    pub(super) rows: Rows,
    generation: u64,
}

/// The actions of a play.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    pub(super) segments: Vec<Segment>,
    bytes: usize,
}

/// A recording as a document.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Document {
    twin: String,
    #[serde(default, rename = "fps")]
    _fps: f64,
    segments: Vec<Read<RollOutRequest>>,
}

impl Recording {
    /// Adds a frame that was simulated from a state. False if it is full.
    pub(super) fn push(
        &mut self,
        frame: &Rows,
        generation: u64,
        from: &GivenState,
        template: RollOutRequest,
    ) -> bool {
        let continues = self.segments.last().is_some_and(|s| s.generation == generation);
        if self.bytes > MOST_BYTES || !continues && self.segments.len() >= MOST_SEGMENTS {
            return false;
        }
        if !continues {
            let initial = Some(InitialState { state: Some(State::Given(from.clone())) });
            let template = RollOutRequest { initial, ..template };
            self.bytes += template.encoded_len();
            self.segments.push(Segment { template, rows: Rows::default(), generation });
        } else if let Some(segment) = self.segments.last_mut()
            && segment.template.grasps != template.grasps
        {
            // A place that held nothing until now has nodes.
            self.bytes += template.encoded_len();
            segment.template.grasps = template.grasps;
        }
        let Some(segment) = self.segments.last_mut() else { return false };
        let before = segment.rows.bytes();
        segment.rows.push(frame);
        self.bytes += segment.rows.bytes() - before;
        true
    }

    /// Makes the next frame begin another segment, even in equal surroundings.
    pub(super) fn part(&mut self) {
        if let Some(last) = self.segments.last_mut() {
            last.generation = u64::MAX;
        }
    }

    /// Frames of all segments.
    pub(super) fn frames(&self) -> usize {
        self.segments.iter().map(|segment| segment.rows.len().saturating_sub(1)).sum()
    }

    /// Memory of the document, about [bytes].
    pub fn document_bytes(&self) -> u64 {
        2 * self.bytes as u64
    }

    /// The document.
    ///
    /// # Errors
    /// If it cannot be written as JSON.
    pub fn write(&self, twin: TwinId, frame_s: f64) -> serde_json::Result<Vec<u8>> {
        #[derive(Serialize)]
        struct Out<'r> {
            twin: String,
            fps: f64,
            segments: Segments<'r>,
        }
        struct Segments<'r>(&'r [Segment]);
        impl Serialize for Segments<'_> {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let mut seq = serializer.serialize_seq(Some(self.0.len()))?;
                for segment in self.0 {
                    let request = segment.request();
                    let message = Write { message: &request, tensors: TensorFormat::Base64 };
                    seq.serialize_element(&message)?;
                }
                seq.end()
            }
        }
        let segments = Segments(&self.segments);
        serde_json::to_vec(&Out { twin: twin.to_string(), fps: frame_s.recip(), segments })
    }

    /// Reads a document of a twin's play.
    ///
    /// # Errors
    /// If it is of another twin, or has requests that no play makes.
    pub fn read(document: Document, twin: TwinId) -> Result<Self> {
        if document.twin.parse() != Ok(twin) {
            let fault = format!("is {}, the play is of {twin}", document.twin);
            return Err(Error::invalid("twin", fault));
        }
        if document.segments.is_empty() || document.segments.len() > MOST_SEGMENTS {
            return Err(Error::invalid("segments", format!("must be 1 to {MOST_SEGMENTS}")));
        }
        let mut recording = Self::default();
        for Read(request) in document.segments {
            let (template, rows) = Rows::read(request)?;
            let given = template.initial.as_ref().and_then(|i| i.state.as_ref());
            if !matches!(given, Some(State::Given(_))) {
                return Err(Error::invalid("segments", "have one without `initial.given`"));
            }
            recording.bytes += template.encoded_len() + rows.bytes();
            let template = RollOutRequest { twin: String::new(), frames: 0, ..template };
            recording.segments.push(Segment { template, rows, generation: 0 });
        }
        Ok(recording)
    }
}

impl Segment {
    /// The whole segment as a rollout, which returns the nodes after every frame.
    pub(super) fn request(&self) -> RollOutRequest {
        let request = self.rows.request(&self.template, 0..self.rows.len());
        let returns = Returns { every_frames: 1, final_state: true, ..Returns::default() };
        RollOutRequest { returns: Some(returns), ..request }
    }

    /// The state that it begins in.
    pub(super) fn initial(&self) -> Option<InitialState> {
        self.template.initial.clone()
    }

    /// Gripper of each grasp.
    pub(super) fn gripper_of_grasp(&self) -> Vec<u32> {
        self.template.grasps.iter().map(|grasp| grasp.gripper).collect()
    }

    /// A frame of the recording, from a session's current state.
    pub(super) fn frame(&self, index: usize) -> (RollOutRequest, Rows) {
        let template = RollOutRequest {
            initial: None,
            returns: Some(rows::returns()),
            ..self.template.clone()
        };
        let request = self.rows.request(&template, index..index + 2);
        let [grippers, _, colliders] = self.rows.widths;
        let closed = self.rows.closed(index);
        let rows = Rows {
            widths: self.rows.widths,
            poses: self.rows.poses[index * grippers..(index + 2) * grippers].to_vec(),
            closed: [closed, closed].concat(),
            paths: self.rows.paths[index * colliders..(index + 2) * colliders].to_vec(),
        };
        (request, rows)
    }
}
