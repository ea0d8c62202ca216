//! Actions of a play by frame boundaries, and the request that they make: one frame of them moves a
//! play, all of them are a rollout that anyone can repeat.

use std::ops::Range;

use bendtwin_proto::v1::{
    Collider, GripperPoses, Returns, RollOutRequest, Tensor, World, collider::Carrier,
    roll_out_request::Actions,
};

use crate::{Error, Result};

/// Position [m] and quaternion.
pub(super) type Pose = [f32; 7];

/// Actions at frame boundaries K, of which the last says nothing about what is closed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Rows {
    /// Number of grippers G, of grasps E and of colliders C.
    pub(super) widths: [usize; 3],
    /// Shape [K, G].
    pub(super) poses: Vec<Pose>,
    /// Shape [K, E].
    pub(super) closed: Vec<u32>,
    /// Shape [K, C].
    pub(super) paths: Vec<Pose>,
}

impl Rows {
    /// Number of boundaries K.
    pub(super) fn len(&self) -> usize {
        self.poses.len() / self.widths[0].max(1)
    }

    /// Poses of the grippers at a boundary.
    pub(super) fn grippers(&self, row: usize) -> &[Pose] {
        self.poses.get(row * self.widths[0]..(row + 1) * self.widths[0]).unwrap_or_default()
    }

    /// Poses of the colliders at a boundary.
    pub(super) fn colliders(&self, row: usize) -> &[Pose] {
        self.paths.get(row * self.widths[2]..(row + 1) * self.widths[2]).unwrap_or_default()
    }

    /// Closings from a boundary on, shape [E].
    pub(super) fn closed(&self, row: usize) -> &[u32] {
        self.closed.get(row * self.widths[1]..(row + 1) * self.widths[1]).unwrap_or_default()
    }

    /// Adds the end of a frame, through which it was closed as at its beginning.
    pub(super) fn push(&mut self, frame: &Self) {
        if self.poses.is_empty() {
            *self = frame.clone();
            return;
        }
        // What the last boundary said was a guess.
        let last = self.closed.len() - self.widths[1];
        self.closed.truncate(last);
        self.closed.extend_from_slice(frame.closed(0));
        self.closed.extend_from_slice(frame.closed(1));
        self.poses.extend_from_slice(frame.grippers(1));
        self.paths.extend_from_slice(frame.colliders(1));
    }

    /// Memory [bytes].
    pub(super) fn bytes(&self) -> usize {
        size_of::<Pose>() * (self.poses.len() + self.paths.len()) + 4 * self.closed.len()
    }

    /// The request of a template with the actions of these boundaries, a dense trajectory.
    pub(super) fn request(&self, template: &RollOutRequest, rows: Range<usize>) -> RollOutRequest {
        let [grippers, grasps, colliders] = self.widths;
        let count = rows.len();
        let poses: Vec<f32> =
            rows.clone().flat_map(|k| self.grippers(k)).flatten().copied().collect();
        let mut request = template.clone();
        if let Some(Actions::Poses(wire)) = &mut request.actions {
            wire.poses = Some(Tensor::pack(&[1, count, grippers, 7], &poses));
        }
        for (e, grasp) in request.grasps.iter_mut().enumerate() {
            // Nothing begins at the last boundary.
            let last = rows.end - 1;
            let from = |k: usize| if k == last { k.saturating_sub(1) } else { k };
            let closed: Vec<u32> = rows
                .clone()
                .map(|k| self.closed.get(from(k) * grasps + e).copied().unwrap_or(0))
                .collect();
            grasp.closed = Some(Tensor::pack(&[count], &closed));
        }
        let wire = request.world.iter_mut().flat_map(|world| &mut world.colliders);
        for (c, collider) in wire.enumerate().take(colliders) {
            let path: Vec<f32> = rows.clone().flat_map(|k| self.paths[k * colliders + c]).collect();
            collider.carrier = Some(Carrier::Path(Tensor::pack(&[count, 7], &path)));
        }
        request.frames = count.saturating_sub(1) as u32;
        request
    }

    /// Template and actions of a dense request of one instance.
    ///
    /// # Errors
    /// If it is not one that [`Rows::request`] makes.
    pub(super) fn read(mut request: RollOutRequest) -> Result<(RollOutRequest, Self)> {
        let Some(Actions::Poses(wire)) = &mut request.actions else {
            return Err(unlike("has no `poses`"));
        };
        let poses = wire.poses.take().unwrap_or_default();
        let (shape, values) = poses.unpack::<f32>("poses").map_err(|e| unlike(&e.to_string()))?;
        let (count, grippers) = match shape[..] {
            [1, count, grippers, 7] if count >= 2 && grippers >= 1 => (count, grippers),
            _ => return Err(unlike("has poses of another shape than [1, K, G, 7]")),
        };
        if request.frames != 0 && request.frames as usize != count - 1 {
            return Err(unlike("has a number of frames that is not that of its poses"));
        }
        let poses = values.as_chunks::<7>().0.to_vec();
        let grasps = request.grasps.len();
        let mut closed = vec![1; count * grasps];
        for (e, grasp) in request.grasps.iter_mut().enumerate() {
            let Some(tensor) = grasp.closed.take() else { continue };
            let (shape, values) =
                tensor.unpack::<u32>("closed").map_err(|e| unlike(&e.to_string()))?;
            if shape != [count] {
                return Err(unlike("has a grasp without a value for each frame"));
            }
            values.iter().enumerate().for_each(|(k, value)| closed[k * grasps + e] = *value);
        }
        let wire: Vec<&mut Collider> =
            request.world.iter_mut().flat_map(|world| &mut world.colliders).collect();
        let colliders = wire.len();
        let mut paths = vec![[0.0; 7]; count * colliders];
        for (c, collider) in wire.into_iter().enumerate() {
            let Some(Carrier::Path(tensor)) = collider.carrier.take() else {
                return Err(unlike("has a collider without a path"));
            };
            let (shape, values) =
                tensor.unpack::<f32>("path").map_err(|e| unlike(&e.to_string()))?;
            if shape != [count, 7] {
                return Err(unlike("has a collider without a pose for each frame"));
            }
            let poses = values.as_chunks::<7>().0.iter();
            poses.enumerate().for_each(|(k, pose)| paths[k * colliders + c] = *pose);
        }
        Ok((request, Self { widths: [grippers, grasps, colliders], poses, closed, paths }))
    }
}

/// Returns of every frame of a play.
pub(super) fn returns() -> Returns {
    Returns { final_state: true, forces: true, diagnostics: true, ..Returns::default() }
}

/// A template for grippers that carry control points.
pub(super) fn template(gripper_of_control: &[u32], world: World) -> RollOutRequest {
    let map = (!gripper_of_control.is_empty())
        .then(|| Tensor::pack(&[gripper_of_control.len()], gripper_of_control));
    let poses = GripperPoses { gripper_of_control: map, ..GripperPoses::default() };
    RollOutRequest {
        actions: Some(Actions::Poses(poses)),
        world: Some(world),
        returns: Some(returns()),
        ..RollOutRequest::default()
    }
}

fn unlike(fault: &str) -> Error {
    Error::invalid("segments", format!("has one that is not of a recorded play: it {fault}"))
}

#[cfg(test)]
mod tests {
    use bendtwin_proto::v1::{Grasp, Sphere, collider::Shape, grasp::Region};

    use super::*;

    fn frame(at: f32, closed: u32) -> Rows {
        let pose = |x: f32| [x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        Rows {
            widths: [2, 1, 1],
            poses: vec![pose(at), pose(-at), pose(at + 1.0), pose(-at - 1.0)],
            closed: vec![closed; 2],
            paths: vec![pose(10.0 * at), pose(10.0 * at + 10.0)],
        }
    }

    fn surrounded() -> RollOutRequest {
        let shape = Some(Shape::Sphere(Sphere { center: Vec::new(), radius_m: 0.1 }));
        let collider = Collider { shape, ..Collider::default() };
        let world = World { colliders: vec![collider], ..World::default() };
        let region = Some(Region::Nodes(Tensor::pack(&[1], &[0u32])));
        let grasps = vec![Grasp { region, ..Grasp::default() }];
        RollOutRequest { grasps, ..template(&[0, 1, 0], world) }
    }

    #[test]
    fn frames_one_by_one_are_the_frames_of_the_whole() {
        let mut rows = Rows::default();
        let frames: Vec<Rows> =
            [1, 1, 0, 1].iter().zip(0u8..).map(|(c, k)| frame(k.into(), *c)).collect();
        frames.iter().for_each(|frame| rows.push(frame));
        assert_eq!(rows.len(), 5);
        let template = surrounded();
        let whole = rows.request(&template, 0..5);
        assert_eq!(whole.frames, 4);
        let (_, closed) = whole.grasps[0].closed.as_ref().unwrap().unpack::<u32>("c").unwrap();
        assert_eq!(closed, [1, 1, 0, 1, 1]);
        for (k, frame) in frames.iter().enumerate() {
            assert_eq!(rows.request(&template, k..k + 2), frame.request(&template, 0..2));
        }
        // A document reads back unchanged.
        let (read, again) = Rows::read(whole).unwrap();
        assert_eq!(again, rows);
        let bare = RollOutRequest { frames: 4, ..template };
        assert_eq!(read, bare);
    }

    #[test]
    fn requests_that_are_no_recording_are_refused() {
        let mut rows = Rows::default();
        rows.push(&frame(0.0, 1));
        let good = rows.request(&surrounded(), 0..2);
        let refused = |request: RollOutRequest| Rows::read(request).unwrap_err().to_string();
        assert!(refused(RollOutRequest::default()).contains("poses"));
        assert!(refused(RollOutRequest { frames: 7, ..good.clone() }).contains("frames"));
        let mut fixed = good.clone();
        fixed.world.as_mut().unwrap().colliders[0].carrier = None;
        assert!(refused(fixed).contains("path"));
        let mut short = good;
        short.grasps[0].closed = Some(Tensor::pack(&[1], &[1u32]));
        assert!(refused(short).contains("grasp"));
    }
}
