//! The action space of a plan.

use bendtwin_plan::Movement;
use bendtwin_proto::v1::{
    ActionSpace, action_space::Coordinates, roll_out_request::Actions, tensor::Dtype,
};

use super::Error;
use crate::rollout::{
    SHORTEST_QUATERNION,
    tensors::{finite, floats, given, indices, required},
};

const COORDINATES: &str = "space.coordinates";
const GROUPS: &str = "space.group_of_control";
const START: &str = "space.start";

/// Coordinates of a plan, by what they move, whose actions have the shape [1, K, `points`, `width`].
pub(super) fn movement(
    space: &ActionSpace,
    actions: &Actions,
    points: usize,
) -> Result<Movement, Error> {
    let unknown = || {
        let fault = format!("has the unknown value {}", space.coordinates);
        Error::field(COORDINATES, fault)
    };
    let coordinates = Coordinates::try_from(space.coordinates).map_err(|_| unknown())?;
    let groups = given(space.group_of_control.as_ref());
    if groups.is_some() && coordinates != Coordinates::PerGroup {
        let fault = "goes with the coordinates PER_GROUP: leave it out, or set them";
        return Err(Error::field(GROUPS, fault));
    }
    let has_poses = matches!(actions, Actions::Poses(_));
    match (coordinates, has_poses) {
        (Coordinates::Unspecified | Coordinates::Together, false) => {
            Ok(Movement::Points(vec![0; points]))
        }
        (Coordinates::Points, false) => Ok(Movement::Points((0..points).collect())),
        (Coordinates::PerGroup, false) => {
            let (groups, shape) = required(groups, GROUPS, Dtype::Uint32)?;
            if shape != [points as u64] {
                let fault =
                    format!("has shape {shape:?}: the actions have {points} control points");
                return Err(Error::field(GROUPS, fault));
            }
            if let Some(group) = indices(groups).find(|group| *group as usize >= points) {
                let fault =
                    format!("has group {group}: {points} points make {points} groups at most");
                return Err(Error::field(GROUPS, fault));
            }
            Ok(Movement::Points(indices(groups).map(|group| group as usize).collect()))
        }
        (Coordinates::Unspecified | Coordinates::Rigid, true) => Ok(Movement::Rigid),
        (Coordinates::Translation, true) => Ok(Movement::Translation),
        (_, true) => {
            Err(Error::field(COORDINATES, "is for trajectories: use TRANSLATION or RIGID"))
        }
        (_, false) => {
            Err(Error::field(COORDINATES, "is for poses: use TOGETHER, PER_GROUP or POINTS"))
        }
    }
}

/// The place that coordinates are counted from, shape [`points`, `width`], if it is given.
pub(super) fn start(
    space: &ActionSpace,
    points: usize,
    width: usize,
) -> Result<Option<Vec<f64>>, Error> {
    let Some(start) = given(space.start.as_ref()) else { return Ok(None) };
    let (start, shape) = required(Some(start), START, Dtype::Float32)?;
    if shape != [points as u64, width as u64] {
        let fault = format!("has shape {shape:?}, not [{points}, {width}] as a row of the actions");
        return Err(Error::field(START, fault));
    }
    finite(start, START)?;
    let values: Vec<f64> = floats(start).map(f64::from).collect();
    let has_direction =
        |pose: &[f64]| pose[3..].iter().any(|x| x.abs() >= f64::from(SHORTEST_QUATERNION));
    if width > 3 && !values.chunks_exact(width).all(has_direction) {
        let fault = "has a quaternion of length zero; no rotation is [0, 0, 0, 1]";
        return Err(Error::field(START, fault));
    }
    Ok(Some(values))
}
