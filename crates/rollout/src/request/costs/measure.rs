//! A cost of a request, as terms of the engine or as a measure of the controls.

use std::sync::Arc;

use bendtwin_contract::rollout;
use bendtwin_core::Point;
use bendtwin_engine::{PointLoss, PointSet, Term, objective::ForceBy};
use bendtwin_proto::v1::{
    self, Plane, Tensor,
    cost::{Kind, force::By},
};

use super::controls::Motion;
use crate::error::Error;

/// Quantity that a cost measures.
#[derive(Debug)]
pub(super) enum Measure {
    Cloud {
        of: PointSet,
        targets: Targets,
    },
    Keypoints {
        of: PointSet,
        points: Vec<u32>,
        targets: Targets,
        loss: PointLoss,
    },
    /// The same term in every frame of every instance.
    Fixed(Term),
    /// The motion of the control points.
    Controls(Motion),
}

/// Lists of points by instance and frame.
#[derive(Debug)]
pub(super) struct Targets {
    points: Vec<Point>,
    /// Points of a list.
    count: usize,
    /// Number of instances with separate lists; 1 if all share a list.
    instances: usize,
    /// Number of frames with separate lists; 1 if all share a list.
    frames: usize,
}

impl Targets {
    /// Targets of a checked tensor, [M, 3], [F, M, 3], [B, 1, M, 3] or [B, F, M, 3].
    fn read(tensor: Option<Tensor>, field: &str) -> Result<Self, Error> {
        let (shape, points) = tensor.unwrap_or_default().unpack_points(field)?;
        let (instances, frames, count) = match shape[..] {
            [count] => (1, 1, count),
            [frames, count] => (1, frames, count),
            [instances, frames, count] => (instances, frames, count),
            _ => return Err(Error::field(field, format!("has shape {shape:?}"))),
        };
        Ok(Self { points, count, instances, frames })
    }

    /// The list of an instance in a frame, 1-based.
    fn at(&self, instance: usize, frame: usize) -> Vec<Point> {
        let instance = if self.instances > 1 { instance } else { 0 };
        let frame = if self.frames > 1 { frame.saturating_sub(1) } else { 0 };
        let start = (instance * self.frames + frame) * self.count;
        self.points.get(start..start + self.count).unwrap_or_default().to_vec()
    }
}

impl Measure {
    /// Reads a kind of cost of a checked request, given the newtons of a force of 1 at unit node
    /// mass. Also returns the factor from the engine's value to the cost's.
    pub(super) fn read(
        kind: Option<Kind>,
        newtons: f64,
        field: &impl Fn(&str) -> String,
    ) -> Result<(Self, f64), Error> {
        let fixed = |term| Ok((Self::Fixed(term), 1.0));
        match kind {
            None => Err(Error::field(field("kind"), "is missing")),
            Some(Kind::TargetCloud(cloud)) => {
                let of = match rollout::measured(&cloud) {
                    v1::PointSet::Nodes => PointSet::Nodes,
                    v1::PointSet::Skin | v1::PointSet::Unspecified => PointSet::Skin,
                };
                let targets = Targets::read(cloud.points, &field("target_cloud.points"))?;
                Ok((Self::Cloud { of, targets }, 1.0))
            }
            Some(Kind::Keypoints(keypoints)) => {
                let of_skin = keypoints.skin_points.filter(|t| !t.is_absent());
                let (of, points, name) = match of_skin {
                    Some(points) => (PointSet::Skin, points, "keypoints.skin_points"),
                    None => {
                        (PointSet::Nodes, keypoints.nodes.unwrap_or_default(), "keypoints.nodes")
                    }
                };
                let (_, points) = points.unpack(&field(name))?;
                let targets = Targets::read(keypoints.targets, &field("keypoints.targets"))?;
                let squared = keypoints.squared;
                let loss = if squared { PointLoss::SquaredDistance } else { PointLoss::Distance };
                Ok((Self::Keypoints { of, points, targets, loss }, 1.0))
            }
            Some(Kind::Smoothness(_)) => fixed(Term::Acceleration),
            Some(Kind::Strain(strain)) => fixed(Term::Strain { limit: strain.limit }),
            Some(Kind::Force(force)) => {
                let by = match force.by {
                    None => return Err(Error::field(field("force.by"), "is missing")),
                    Some(By::Controls(_)) => ForceBy::Controls,
                    Some(By::Control(control)) => ForceBy::Control(control),
                    Some(By::Grasp(grasp)) => ForceBy::Grasp(grasp),
                    Some(By::Ground(_)) => ForceBy::Ground,
                    Some(By::Collider(collider)) => ForceBy::Collider(collider),
                };
                let term = Term::Force { by, limit: (force.limit_n / newtons) as f32 };
                Ok((Self::Fixed(term), newtons * newtons))
            }
            Some(Kind::Height(height)) => {
                let Plane { normal, offset_m } = height.plane.unwrap_or_default();
                let normal = if normal.is_empty() { [0.0, 0.0, 1.0] } else { three(&normal) };
                let nodes = some_nodes(height.nodes, &field("height.nodes"))?;
                fixed(Term::Above { nodes, normal, offset_m })
            }
            Some(Kind::Within(within)) => {
                let nodes = some_nodes(within.nodes, &field("within.nodes"))?;
                let space = within.cuboid.unwrap_or_default();
                fixed(Term::Within { nodes, low: three(&space.low), high: three(&space.high) })
            }
            Some(Kind::Clearance(clearance)) => fixed(Term::Clearance {
                collider: clearance.collider,
                margin_m: clearance.margin_m,
            }),
            Some(Kind::ControlPath(_)) => Ok((Self::Controls(Motion::Path), 1.0)),
            Some(Kind::ControlSpeed(speed)) => {
                Ok((Self::Controls(Motion::Speed { limit_m_s: speed.limit_m_s }), 1.0))
            }
            Some(Kind::Order(_) | Kind::Winding(_) | Kind::Coverage(_)) => {
                Err(Error::field(field("kind"), "PLACEHOLDER"))
            }
        }
    }

    /// True if other instances have other targets.
    pub(super) fn is_by_instance(&self) -> bool {
        match self {
            Self::Cloud { targets, .. } | Self::Keypoints { targets, .. } => targets.instances > 1,
            Self::Fixed(_) | Self::Controls(_) => false,
        }
    }

    /// The term of an instance in a frame; none of what the engine does not measure.
    pub(super) fn term(&self, instance: usize, frame: usize) -> Option<Term> {
        match self {
            Self::Cloud { of, targets } => {
                Some(Term::Chamfer { of: *of, targets: targets.at(instance, frame) })
            }
            Self::Keypoints { of, points, targets, loss } => Some(Term::Track {
                of: *of,
                points: points.clone(),
                targets: targets.at(instance, frame),
                loss: *loss,
            }),
            Self::Fixed(term) => Some(term.clone()),
            Self::Controls(_) => None,
        }
    }
}

fn some_nodes(nodes: Option<Tensor>, field: &str) -> Result<Option<Arc<Vec<u32>>>, Error> {
    let given = nodes.filter(|t| !t.is_absent());
    Ok(given.map(|t| t.unpack(field)).transpose()?.map(|(_, nodes)| Arc::new(nodes)))
}

/// Three numbers that the check has counted.
fn three(values: &[f32]) -> Point {
    values.try_into().unwrap_or_default()
}
