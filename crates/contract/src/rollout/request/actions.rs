//! Actions: trajectories of the control points, or poses of grippers, for each frame.

use bendtwin_proto::v1::{Interpolation, roll_out_request::Actions, tensor::Dtype};

use super::{
    Asked, Error, Limits, Price, TwinShape, mul,
    numbers::SHORTEST_QUATERNION,
    tensors::{finite, floats, given, indices, required},
    within,
};

const POSITIONS: &str = "trajectories.positions";
const POSES: &str = "poses.poses";
const GRIPPERS: &str = "poses.gripper_of_control";
/// A control point in a frame: dense controls in single precision, and as the engine reads them.
const CONTROL: u64 = 12;
const CONTROL_READ: u64 = 16;
/// A frame's place among the knots: four knots with their weights.
const CURVE: u64 = 96;

/// Number of instances B and of knots K.
pub(in crate::rollout) fn check(
    actions: Option<&Actions>,
    limits: &Limits,
) -> Result<[u64; 2], Error> {
    match actions {
        None => Err(Error::field(
            "actions",
            "are missing: give `trajectories` of the control points or gripper `poses`",
        )),
        Some(Actions::Trajectories(t)) => {
            interpolation("trajectories.interpolation", t.interpolation)?;
            let (tensor, shape) = required(t.positions.as_ref(), POSITIONS, Dtype::Float32)?;
            let [instances, knots, _, 3] = shape[..] else {
                let fault = format!("has shape {shape:?}, not [B, K, C, 3]");
                return Err(Error::field(POSITIONS, fault));
            };
            batch(instances, knots, POSITIONS, limits)?;
            finite(tensor, POSITIONS)?;
            Ok([instances, knots])
        }
        Some(Actions::Poses(p)) => {
            interpolation("poses.interpolation", p.interpolation)?;
            let (tensor, shape) = required(p.poses.as_ref(), POSES, Dtype::Float32)?;
            let [instances, knots, grippers, 7] = shape[..] else {
                let fault = format!(
                    "has shape {shape:?}, not [B, K, G, 7] (x, y, z, then the quaternion x, y, z, w)"
                );
                return Err(Error::field(POSES, fault));
            };
            batch(instances, knots, POSES, limits)?;
            if grippers == 0 {
                return Err(Error::field(POSES, "has no grippers: at least 1 is needed"));
            }
            finite(tensor, POSES)?;
            rotations(floats(tensor), knots, grippers)?;
            attachments(p.gripper_of_control.as_ref(), grippers)?;
            Ok([instances, knots])
        }
    }
}

/// Checks the number of control points.
pub(in crate::rollout) fn check_for(
    actions: Option<&Actions>,
    twin: &TwinShape,
) -> Result<(), Error> {
    let controls = twin.controls;
    match actions {
        Some(Actions::Trajectories(t)) => {
            let shape = t.positions.as_ref().map(|p| p.shape.as_slice()).unwrap_or_default();
            match shape {
                [_, _, moved, _] if *moved == controls => Ok(()),
                _ => {
                    let fault =
                        format!("has shape {shape:?}: the twin has {controls} control points");
                    Err(Error::field(POSITIONS, fault))
                }
            }
        }
        Some(Actions::Poses(p)) => match given(p.gripper_of_control.as_ref()) {
            Some(map) if map.shape != [controls] => {
                let fault =
                    format!("has shape {:?}: the twin has {controls} control points", map.shape);
                Err(Error::field(GRIPPERS, fault))
            }
            _ => Ok(()),
        },
        None => Ok(()),
    }
}

/// The control points in all frames.
pub(in crate::rollout) fn price(asked: &Asked<'_>) -> Price {
    let (boundaries, controls) = (asked.boundaries, asked.twin.controls);
    Price {
        // Place and curve of each frame among the knots, shared by all instances.
        fixed: mul(&[CURVE, boundaries]),
        prepared: mul(&[CONTROL, boundaries, controls]),
        running: mul(&[CONTROL_READ, boundaries, controls]),
        ..Price::default()
    }
}

fn batch(instances: u64, knots: u64, field: &str, limits: &Limits) -> Result<(), Error> {
    if instances == 0 || knots < 2 {
        let fault = format!(
            "has {instances} instances of {knots} knots: at least 1 instance and 2 knots (start and end) are needed"
        );
        return Err(Error::field(field, fault));
    }
    let most = limits.instances;
    within("the number of instances", u128::from(instances), most, "split the batch")?;
    // Dense actions have a knot more than there are frames.
    let most = limits.frames.saturating_add(1);
    within(
        "the number of knots",
        u128::from(knots),
        most,
        "send fewer and let them be interpolated",
    )
}

fn interpolation(field: &str, wire: i32) -> Result<(), Error> {
    Interpolation::try_from(wire).map(drop).map_err(|_| {
        Error::field(field, format!("has the unknown value {wire}: use LINEAR, CUBIC or ZERO"))
    })
}

/// Refuses quaternions without a direction; `poses` has shape [B, K, G, 7].
fn rotations(
    mut poses: impl ExactSizeIterator<Item = f32>,
    knots: u64,
    grippers: u64,
) -> Result<(), Error> {
    for row in 0..(poses.len() / 7) as u64 {
        let longest = (0..7).fold(0.0f32, |longest, column| match poses.next() {
            Some(x) if column >= 3 => longest.max(x.abs()),
            _ => longest,
        });
        if longest < SHORTEST_QUATERNION {
            let (b, k, g) = (row / (knots * grippers), row / grippers % knots, row % grippers);
            let fault = format!(
                "has a quaternion of length zero for instance {b}, knot {k}, gripper {g}; no rotation is [0, 0, 0, 1]"
            );
            return Err(Error::field(POSES, fault));
        }
    }
    Ok(())
}

fn attachments(map: Option<&bendtwin_proto::v1::Tensor>, grippers: u64) -> Result<(), Error> {
    let Some(map) = given(map) else { return Ok(()) };
    let (map, shape) = required(Some(map), GRIPPERS, Dtype::Uint32)?;
    if shape.len() != 1 {
        return Err(Error::field(GRIPPERS, format!("has shape {shape:?}, not [C]")));
    }
    match indices(map).enumerate().find(|(_, g)| u64::from(*g) >= grippers) {
        Some((c, g)) => {
            let fault = format!(
                "gives control point {c} to gripper {g}, there are {grippers} (counted from 0)"
            );
            Err(Error::field(GRIPPERS, fault))
        }
        None => Ok(()),
    }
}
