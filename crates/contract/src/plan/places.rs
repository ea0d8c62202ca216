//! Places to grasp of a plan.

use bendtwin_proto::v1::{
    Grasp, GraspSearch, RollOutRequest, grasp::Region, roll_out_request::Actions, tensor::Dtype,
};

use super::Error;
use crate::rollout::{
    SHORTEST_QUATERNION,
    tensors::{finite, floats, given, indices, required},
};

const POSES: &str = "grasp_search.poses";
const GRIPPERS: &str = "grasp_search.grippers";
/// Most places of a search.
pub const MOST_PLACES: usize = 256;
/// Numbers of a pose.
const POSE: usize = 7;

/// Places to grasp that are searched together with the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct GraspPlaces {
    /// Grippers whose places are searched, G' of them, ascending.
    pub grippers: Vec<usize>,
    /// Their poses at each place, shape [P, G', 7].
    pub poses: Vec<f64>,
}

impl GraspPlaces {
    /// Number of places P.
    pub fn count(&self) -> usize {
        self.poses.len() / (POSE * self.grippers.len()).max(1)
    }

    /// A row of actions, shape [G, 7], with the grippers that are searched at a place.
    pub fn at(&self, place: usize, row: &[f64]) -> Vec<f64> {
        let mut row = row.to_vec();
        let width = POSE * self.grippers.len();
        let poses = self.poses[place * width..(place + 1) * width].chunks_exact(POSE);
        for (gripper, pose) in self.grippers.iter().zip(poses) {
            row[gripper * POSE..(gripper + 1) * POSE].copy_from_slice(pose);
        }
        row
    }

    /// The grasps of a request that belong to the grippers that are searched.
    pub fn grasps<'r>(
        &self,
        request: &'r RollOutRequest,
    ) -> impl Iterator<Item = usize> + use<'_, 'r> {
        let grasps = request.grasps.iter().enumerate();
        grasps.filter(|(_, g)| self.grippers.contains(&(g.gripper as usize))).map(|(i, _)| i)
    }
}

/// The places of a search whose rollout has these actions of `grippers` grippers.
pub(super) fn places(
    search: &GraspSearch,
    rollout: &RollOutRequest,
    grippers: usize,
) -> Result<GraspPlaces, Error> {
    if !matches!(rollout.actions, Some(Actions::Poses(_))) {
        let fault = "goes with `rollout.poses`: a place is the pose of a gripper";
        return Err(Error::field("grasp_search", fault));
    }
    let listed = self::grippers(&search.grippers, grippers)?;
    let (poses, shape) = required(search.poses.as_ref(), POSES, Dtype::Float32)?;
    let (most, own) = (MOST_PLACES as u64, listed.len() as u64);
    if !matches!(shape[..], [p, g, 7] if (2..=most).contains(&p) && g == own) {
        let fault = format!(
            "has shape {shape:?}, not [P, {own}, 7] with 2 to {most} places of the grippers that are searched"
        );
        return Err(Error::field(POSES, fault));
    }
    finite(poses, POSES)?;
    let poses: Vec<f64> = floats(poses).map(f64::from).collect();
    let is_free = |pose: &[f64]| pose[3..].iter().all(|x| x.abs() < f64::from(SHORTEST_QUATERNION));
    if let Some(i) = poses.chunks_exact(POSE).position(is_free) {
        let place = i / listed.len();
        let fault = format!(
            "has a quaternion of length zero at place {place}; no rotation is [0, 0, 0, 1]"
        );
        return Err(Error::field(POSES, fault));
    }
    for gripper in &listed {
        let takes = |grasp: &Grasp| {
            let is_hand = matches!(grasp.region, Some(Region::Hand(_)));
            grasp.gripper as usize == *gripper && !is_hand
        };
        if !rollout.grasps.iter().any(takes) {
            let fault = format!(
                "have none of gripper {gripper}, whose places are searched: give one with a sphere, a cuboid or nodes, also in a session"
            );
            return Err(Error::field("rollout.grasps", fault));
        }
    }
    Ok(GraspPlaces { grippers: listed, poses })
}

/// The grippers whose places are searched, of `count`.
fn grippers(listed: &[u32], count: usize) -> Result<Vec<usize>, Error> {
    if listed.is_empty() {
        return Ok((0..count).collect());
    }
    if !listed.is_sorted_by(|a, b| a < b) {
        return Err(Error::field(GRIPPERS, "must ascend, each gripper once"));
    }
    match listed.last().filter(|last| **last as usize >= count) {
        Some(last) => {
            let fault = format!("has gripper {last}: the actions have {count} (counted from 0)");
            Err(Error::field(GRIPPERS, fault))
        }
        None => Ok(listed.iter().map(|gripper| *gripper as usize).collect()),
    }
}

/// Refuses what holds or has slipped in the state that a plan begins in, with the `phases` of its grasps,
/// and is to hold something from the start: at another place it would tear the object there.
///
/// # Errors
/// The first such grasp.
pub fn check_open(
    places: &GraspPlaces,
    rollout: &RollOutRequest,
    phases: &[u32],
) -> Result<(), Error> {
    let is_closed = |grasp: usize| {
        let closed = given(rollout.grasps[grasp].closed.as_ref());
        closed.and_then(|tensor| indices(tensor).next()).is_none_or(|first| first != 0)
    };
    let is_open = |grasp: usize| phases.get(grasp).is_none_or(|phase| *phase == 0);
    match places.grasps(rollout).find(|grasp| !is_open(*grasp) && is_closed(*grasp)) {
        Some(grasp) => {
            let gripper = rollout.grasps[grasp].gripper;
            let fault = format!(
                "would move gripper {gripper}, whose grasp {grasp} is closed in the initial state: open that first, or start `closed` with 0"
            );
            Err(Error::field("grasp_search", fault))
        }
        None => Ok(()),
    }
}
