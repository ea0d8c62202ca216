//! What a running fit has so far.

use bendtwin_core::{Point, quality::Measure};
use bendtwin_proto::v1;
use jiff::Timestamp;

use crate::{Error, resources::value::FromWire as _};

/// Predicted motion of the best parameters of a running fit, and its errors: P points of the object's
/// surface in F frames of one sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct FitPreview {
    /// `search` or `refine`.
    pub stage: String,
    /// `bending` or `axial`, of several starts followed by which: `bending 2/3`.
    pub variant: String,
    /// Iterations of the stage that were done.
    pub iteration: u32,
    /// Time at which the server received it.
    pub created: Timestamp,
    /// Index of the sequence among those of the capture.
    pub sequence: u32,
    /// Numbers of the frames, ascending, shape [F].
    pub frames: Vec<u32>,
    /// Positions [m], shape [F, P, 3].
    pub positions: Vec<Point>,
    /// The kind of the errors.
    pub measure: Measure,
    /// Error over the frames that the parameters are fitted to [m].
    pub error_m: f64,
    /// Error over training frames that are held back [m]; none where none are.
    pub held_back_m: Option<f64>,
    /// Error of the object standing still, over the frames of `error_m` [m].
    pub baseline_m: f64,
}

impl TryFrom<v1::FitPreview> for FitPreview {
    type Error = Error;
    fn try_from(wire: v1::FitPreview) -> Result<Self, Error> {
        let frames = wire.frames.unwrap_or_default();
        let (_, frames) = frames.unpack::<u32>("frames").map_err(Error::malformed)?;
        let positions = wire.positions.unwrap_or_default();
        let (shape, positions) = positions.unpack_points("positions").map_err(Error::malformed)?;
        if shape.len() != 2 || shape[0] != frames.len() {
            return Err(Error::malformed("a preview has positions of other frames"));
        }
        let measure = Measure::parse(&wire.measure)
            .ok_or_else(|| Error::malformed("a preview has an unknown measure"))?;
        Ok(Self {
            stage: wire.stage,
            variant: wire.variant,
            iteration: wire.iteration,
            created: Timestamp::from_wire(wire.create_time, "create_time")?,
            sequence: wire.sequence,
            frames,
            positions,
            measure,
            error_m: wire.error_m,
            held_back_m: wire.held_back_m,
            baseline_m: wire.baseline_m,
        })
    }
}
