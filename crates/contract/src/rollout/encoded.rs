//! A look at an encoded request before it is decoded. Two bytes of an empty cost become two hundred
//! in memory, and a byte of a shape eight: what is repeated is counted first. All else takes about
//! as much memory decoded as encoded.

use bendtwin_proto::tensor::MOST_DIMENSIONS;
use prost::{
    bytes::Buf,
    encoding::{DecodeContext, WireType, decode_key, decode_varint, skip_field},
};

use super::{Error, Limits, check::parts, within};

/// Numbers of fields in the .proto files.
const COSTS: u32 = 6;
const GRASPS: u32 = 10;
const OPEN_GRASPS: u32 = 5;
const COLLIDERS: u32 = 6;
const SHAPE: u32 = 2;

/// Bytes of the longest encoding of a shape.
const SHAPE_BYTES: usize = 10 * MOST_DIMENSIONS;

/// Most fields of a message and those below it: a request that has more has no use of them.
const MOST_FIELDS: u64 = 1_000_000;

/// Fields of a message by number.
struct Message(&'static [(u32, &'static Message)]);

/// A tensor has no fields below it; its shape is what counts.
static TENSOR: Message = Message(&[]);
/// The same, of actions: the first number of its shape is that of instances.
static ACTIONS: Message = Message(&[]);
static TRAJECTORIES: Message = Message(&[(1, &ACTIONS)]);
static POSES: Message = Message(&[(1, &ACTIONS), (2, &TENSOR)]);
static INITIAL: Message = Message(&[(3, &GIVEN)]);
static GIVEN: Message =
    Message(&[(1, &TENSOR), (2, &TENSOR), (3, &TENSOR), (4, &TENSOR), (5, &GRASPING)]);
static GRASPING: Message = Message(&[(1, &TENSOR), (2, &TENSOR), (3, &TENSOR)]);
static KNOT_TIMES: Message = Message(&[(1, &TENSOR)]);
static COST: Message = Message(&[(4, &CLOUD), (5, &KEYPOINTS), (9, &HEIGHT), (10, &WITHIN)]);
static CLOUD: Message = Message(&[(1, &TENSOR)]);
static KEYPOINTS: Message = Message(&[(1, &TENSOR), (2, &TENSOR), (4, &TENSOR)]);
static HEIGHT: Message = Message(&[(2, &TENSOR)]);
static WITHIN: Message = Message(&[(2, &TENSOR)]);
static RETURNS: Message = Message(&[(2, &TENSOR), (17, &TENSOR)]);
static WORLD: Message = Message(&[(COLLIDERS, &COLLIDER)]);
static COLLIDER: Message = Message(&[(5, &MESH), (11, &TENSOR)]);
static MESH: Message = Message(&[(1, &TENSOR)]);
static GRASP: Message = Message(&[(4, &TENSOR), (9, &TENSOR)]);
static VARY: Message = Message(&[
    (1, &TENSOR),
    (2, &TENSOR),
    (3, &TENSOR),
    (4, &TENSOR),
    (5, &TENSOR),
    (7, &TENSOR),
    (8, &TENSOR),
]);
static REQUEST: Message = Message(&[
    (2, &TRAJECTORIES),
    (3, &POSES),
    (4, &INITIAL),
    (COSTS, &COST),
    (7, &RETURNS),
    (9, &WORLD),
    (GRASPS, &GRASP),
    (11, &VARY),
    (15, &KNOT_TIMES),
]);

static ADVANCE: Message = Message(&[(3, &REQUEST)]);
static OPEN: Message = Message(&[(2, &INITIAL), (4, &WORLD), (OPEN_GRASPS, &GRASP)]);
static RESET: Message = Message(&[(3, &INITIAL)]);
static PLAN: Message =
    Message(&[(1, &REQUEST), (2, &SPACE), (3, &METHOD), (5, &TENSOR), (8, &BOUNDS)]);
static SPACE: Message = Message(&[(2, &TENSOR), (3, &TENSOR)]);
static METHOD: Message = Message(&[(4, &GRADIENT)]);
static GRADIENT: Message = Message(&[(1, &TENSOR)]);
static BOUNDS: Message = Message(&[(1, &TENSOR), (2, &TENSOR), (3, &TENSOR)]);
static PLACES: Message = Message(&[(1, &TENSOR), (2, &TENSOR)]);
static OBSERVATION: Message =
    Message(&[(1, &TENSOR), (2, &TENSOR), (3, &PLACES), (4, &TENSOR), (5, &TENSOR), (6, &TENSOR)]);
static REGISTER: Message =
    Message(&[(2, &OBSERVATION), (3, &INITIAL), (4, &TENSOR), (5, &WORLD), (7, &TENSOR)]);
static CORRECT: Message = Message(&[(3, &OBSERVATION), (4, &CORRECT_OPTIONS)]);
static CORRECT_OPTIONS: Message = Message(&[(8, &WORLD), (9, &TENSOR)]);
static STEP: Message = Message(&[(3, &CORRECT), (4, &PLAN), (6, &RETURNS)]);
static OTHER: Message = Message(&[]);

/// Message that is checked before it is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoded {
    /// [`RollOutRequest`](bendtwin_proto::v1::RollOutRequest).
    RollOut,
    /// [`AdvanceSessionRequest`](bendtwin_proto::v1::AdvanceSessionRequest).
    Advance,
    /// [`OpenSessionRequest`](bendtwin_proto::v1::OpenSessionRequest).
    Open,
    /// [`ResetSessionRequest`](bendtwin_proto::v1::ResetSessionRequest).
    Reset,
    /// [`PlanRequest`](bendtwin_proto::v1::PlanRequest).
    Plan,
    /// [`RegisterStateRequest`](bendtwin_proto::v1::RegisterStateRequest).
    Register,
    /// [`CorrectSessionRequest`](bendtwin_proto::v1::CorrectSessionRequest).
    Correct,
    /// [`StepSessionRequest`](bendtwin_proto::v1::StepSessionRequest).
    Step,
    /// One that has nothing below it.
    Other,
}

impl Encoded {
    fn message(self) -> &'static Message {
        match self {
            Self::RollOut => &REQUEST,
            Self::Advance => &ADVANCE,
            Self::Open => &OPEN,
            Self::Reset => &RESET,
            Self::Plan => &PLAN,
            Self::Register => &REGISTER,
            Self::Correct => &CORRECT,
            Self::Step => &STEP,
            Self::Other => &OTHER,
        }
    }
}

/// Checks an encoded message for parts that take far more memory decoded, and for too many instances,
/// which stand at its beginning: what has come of a message that is still on its way may be checked,
/// too. Bytes that are no message pass: decoding refuses them.
///
/// # Errors
/// If it has more instances or costs than the limits allow, more colliders or grasps than a world has,
/// a tensor with too many dimensions, or a million fields.
pub fn check_encoded(encoded: Encoded, bytes: &[u8], limits: &Limits) -> Result<(), Error> {
    let (mut costs, mut fields) = (0, 0);
    let (mut colliders, mut grasps) = (0, 0);
    walk(encoded.message(), bytes, &mut |message, field, first| {
        // A number that no request can hold is none of instances, but a wrong shape.
        if let (true, SHAPE, Some(instances)) = (std::ptr::eq(message, &ACTIONS), field, first)
            && instances <= limits.request_bytes
        {
            let most = limits.instances;
            within("the number of instances", instances.into(), most, "split the batch")?;
        }
        fields += 1;
        if fields > MOST_FIELDS {
            let fault = format!("has more than {MOST_FIELDS} fields");
            return Err(Error::field("request", fault));
        }
        if std::ptr::eq(message, &REQUEST) && field == COSTS {
            costs += 1;
        }
        let is_grasp = std::ptr::eq(message, &REQUEST) && field == GRASPS
            || std::ptr::eq(message, &OPEN) && field == OPEN_GRASPS;
        if is_grasp {
            grasps += 1;
            parts("grasps", grasps)?;
        }
        if std::ptr::eq(message, &WORLD) && field == COLLIDERS {
            colliders += 1;
            parts("world.colliders", colliders)?;
        }
        if costs > limits.costs {
            return Err(Error::TooLarge {
                what: "the number of costs",
                asked: costs,
                limit: limits.costs,
                advice: "merge target clouds",
            });
        }
        Ok(())
    })
}

/// Goes through the fields of a message and those below it, with the first number of each: that of a
/// list, once.
fn walk(
    message: &'static Message,
    mut rest: &[u8],
    see: &mut impl FnMut(&'static Message, u32, Option<u64>) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut shape_bytes = 0;
    while rest.has_remaining() {
        let Ok((field, wire)) = decode_key(&mut rest) else { return Ok(()) };
        let is_first = field != SHAPE || shape_bytes == 0;
        let mut ahead = rest;
        let content = match wire {
            WireType::LengthDelimited => content(&mut rest),
            _ => None,
        };
        let first = match (wire, content) {
            (WireType::Varint, _) => decode_varint(&mut ahead).ok(),
            (_, Some(mut numbers)) => decode_varint(&mut numbers).ok(),
            _ => None,
        };
        see(message, field, first.filter(|_| is_first))?;
        if let Some(content) = content {
            shape_bytes += if field == SHAPE { content.len() } else { 0 };
            if let Some((_, below)) = message.0.iter().find(|(number, _)| *number == field) {
                walk(below, content, see)?;
            }
        } else {
            let before = rest.len();
            if skip_field(wire, field, &mut rest, DecodeContext::default()).is_err() {
                return Ok(());
            }
            shape_bytes += if field == SHAPE { before - rest.len() } else { 0 };
        }
        let is_tensor = std::ptr::eq(message, &TENSOR) || std::ptr::eq(message, &ACTIONS);
        if is_tensor && shape_bytes > SHAPE_BYTES {
            let fault = format!("of a tensor has more than {MOST_DIMENSIONS} dimensions");
            return Err(Error::field("shape", fault));
        }
    }
    Ok(())
}

/// Content of a field with a length, or as much of it as is there; none if its length is not.
fn content<'b>(rest: &mut &'b [u8]) -> Option<&'b [u8]> {
    let mut after = *rest;
    let length = usize::try_from(decode_varint(&mut after).ok()?).ok()?;
    let (content, later) = after.split_at(length.min(after.len()));
    *rest = later;
    Some(content)
}

#[cfg(test)]
mod tests;
