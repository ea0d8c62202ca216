//! A look at an encoded request before it is decoded. Two bytes of an empty cost become two hundred
//! in memory, and a byte of a shape eight: what is repeated is counted first. All else takes about
//! as much memory decoded as encoded. The descriptors of the messages say where tensors may be.

mod messages;

use bendtwin_proto::tensor::MOST_DIMENSIONS;
use prost::{
    bytes::Buf,
    encoding::{DecodeContext, WireType, decode_key, decode_varint, skip_field},
};

use self::messages::{Counted, MESSAGES, Message};
use super::{Error, Limits, check::within, request::world::parts};
use crate::picture;

/// Bytes of the longest encoding of a shape.
const SHAPE_BYTES: usize = 10 * MOST_DIMENSIONS;

/// Most fields of a message and those below it: a request that has more has no use of them.
const MOST_FIELDS: u64 = 1_000_000;

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
    /// [`RenderSessionRequest`](bendtwin_proto::v1::RenderSessionRequest).
    Render,
    /// A field without parts.
    Other,
}

impl Encoded {
    fn message(self) -> &'static Message {
        MESSAGES.named(match self {
            Self::RollOut => "RollOutRequest",
            Self::Advance => "AdvanceSessionRequest",
            Self::Open => "OpenSessionRequest",
            Self::Reset => "ResetSessionRequest",
            Self::Plan => "PlanRequest",
            Self::Register => "RegisterStateRequest",
            Self::Correct => "CorrectSessionRequest",
            Self::Step => "StepSessionRequest",
            Self::Render => "RenderSessionRequest",
            Self::Other => "",
        })
    }
}

/// Checks an encoded message for parts that take far more memory decoded, and for too many instances,
/// which stand at its beginning: what has come of a message that is still on its way may be checked,
/// too. Bytes that are no message pass: decoding refuses them.
///
/// # Errors
/// If it has more instances or costs than the limits allow, more colliders or grasps than a world has,
/// more cameras or props than pictures have, a tensor with too many dimensions, or a million fields.
pub fn check_encoded(encoded: Encoded, bytes: &[u8], limits: &Limits) -> Result<(), Error> {
    let (mut costs, mut fields) = (0, 0);
    let (mut colliders, mut grasps) = (0, 0);
    let (mut cameras, mut props) = (0, 0);
    walk(encoded.message(), false, bytes, &mut |seen| {
        // A number that no request can hold is not one of instances, but a wrong shape.
        if let Some(instances) = seen.instances.filter(|n| *n <= limits.request_bytes) {
            let most = limits.instances;
            within("the number of instances", instances.into(), most, "split the batch")?;
        }
        fields += 1;
        if fields > MOST_FIELDS {
            let fault = format!("has more than {MOST_FIELDS} fields");
            return Err(Error::field("request", fault));
        }
        match seen.counted {
            Some(Counted::Costs) => costs += 1,
            Some(Counted::Grasps) => {
                grasps += 1;
                parts("grasps", grasps)?;
            }
            Some(Counted::Colliders) => {
                colliders += 1;
                parts("world.colliders", colliders)?;
            }
            Some(Counted::Cameras) => {
                cameras += 1;
                most("cameras", cameras, picture::MAX_CAMERAS)?;
            }
            Some(Counted::Props) => {
                props += 1;
                most("props", props, picture::MAX_PROPS)?;
            }
            Some(Counted::Instances) | None => {}
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

/// Refuses more parts of pictures than are possible.
fn most(field: &str, count: usize, most: usize) -> Result<(), Error> {
    if count <= most {
        return Ok(());
    }
    Err(Error::field(field, format!("are more than {most}, which are possible: leave some out")))
}

/// A field that was passed.
struct Seen {
    counted: Option<Counted>,
    /// The first number of the shape of actions.
    instances: Option<u64>,
}

/// Goes through the fields of a message and those below it; `has_instances` says that it is a tensor
/// whose shape begins with the number of instances.
fn walk(
    message: &'static Message,
    has_instances: bool,
    mut rest: &[u8],
    see: &mut impl FnMut(Seen) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut shape_bytes = 0;
    while rest.has_remaining() {
        let Ok((field, wire)) = decode_key(&mut rest) else { return Ok(()) };
        let is_shape = message.shape == Some(field);
        let mut ahead = rest;
        let content = match wire {
            WireType::LengthDelimited => content(&mut rest),
            _ => None,
        };
        // The first number of a list, packed or not, stands once.
        let instances = match (wire, content) {
            _ if !has_instances || !is_shape || shape_bytes > 0 => None,
            (WireType::Varint, _) => decode_varint(&mut ahead).ok(),
            (_, Some(mut numbers)) => decode_varint(&mut numbers).ok(),
            _ => None,
        };
        let known = message.fields.get(&field);
        let counted = known.and_then(|known| known.counted);
        see(Seen { counted, instances })?;
        if let Some(content) = content {
            shape_bytes += if is_shape { content.len() } else { 0 };
            if let Some(below) = known.and_then(|known| known.below) {
                let has_instances = counted == Some(Counted::Instances);
                walk(MESSAGES.numbered(below), has_instances, content, see)?;
            }
        } else {
            let before = rest.len();
            if skip_field(wire, field, &mut rest, DecodeContext::default()).is_err() {
                return Ok(());
            }
            shape_bytes += if is_shape { before - rest.len() } else { 0 };
        }
        if shape_bytes > SHAPE_BYTES {
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
