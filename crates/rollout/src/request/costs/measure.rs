//! A cost of a request, as terms of the engine or as a measure of the controls.

use std::sync::Arc;

use bendtwin_contract::rollout;
use bendtwin_core::Point;
use bendtwin_engine::{PointLoss, PointSet, Term, objective::ForceBy};
use bendtwin_proto::v1::{
    self, Plane, Tensor,
    cost::{
        Kind,
        force::By,
        winding::{Around, Axis},
    },
};

use super::{Context, controls::Motion};
use crate::{error::Error, world::unit};

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
    /// Reads a kind of cost of a checked request. Also returns the factor from the engine's value to the
    /// cost's.
    pub(super) fn read(
        kind: Option<Kind>,
        context: &Context<'_>,
        field: &impl Fn(&str) -> String,
    ) -> Result<(Self, f64), Error> {
        let fixed = |term| Ok((Self::Fixed(term), 1.0));
        match kind {
            None => Err(Error::field(field("kind"), "is missing")),
            Some(Kind::TargetCloud(cloud)) => {
                let of = surface(cloud.point_set());
                let targets = Targets::read(cloud.points, &field("target_cloud.points"))?;
                Ok((Self::Cloud { of, targets }, 1.0))
            }
            Some(Kind::Keypoints(keypoints)) => {
                let (nodes, skin_points) = (keypoints.nodes, keypoints.skin_points);
                let (of, points) = list(nodes, skin_points, &field("keypoints"))?;
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
                let newtons = context.newtons;
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
            Some(Kind::Order(order)) => {
                let (of, points) = list(order.nodes, order.skin_points, &field("order"))?;
                let (points, direction) = (Arc::new(points), unit(three(&order.direction)));
                fixed(Term::Order { of, points, direction, gap_m: order.gap_m })
            }
            Some(Kind::Winding(winding)) => {
                let (of, points) = list(winding.nodes, winding.skin_points, &field("winding"))?;
                let [origin, direction] = match winding.around {
                    Some(Around::Axis(Axis { point, direction })) => {
                        [three(&point), unit(three(&direction))]
                    }
                    Some(Around::Collider(collider)) => {
                        let axis = context.surroundings.axis(collider as usize);
                        axis.ok_or_else(|| Error::field(field("winding.collider"), "has no axis"))?
                    }
                    None => return Err(Error::field(field("winding.around"), "is missing")),
                };
                let (points, turns) = (Arc::new(points), winding.turns);
                fixed(Term::Winding { of, points, origin, direction, turns })
            }
            Some(Kind::Coverage(coverage)) => {
                let (of, reach_m) = (surface(coverage.point_set()), coverage.reach_m);
                let points = coverage.points.unwrap_or_default();
                let (_, targets) = points.unpack_points(&field("coverage.points"))?;
                fixed(Term::Coverage { of, targets: Arc::new(targets), reach_m })
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

/// Points of the surface whose distance to target points is measured.
fn surface(asked: v1::PointSet) -> PointSet {
    match rollout::measured(asked) {
        v1::PointSet::Nodes => PointSet::Nodes,
        v1::PointSet::Skin | v1::PointSet::Unspecified => PointSet::Skin,
    }
}

/// The points that a cost names: nodes or points of the skin.
fn list(
    nodes: Option<Tensor>,
    skin_points: Option<Tensor>,
    kind: &str,
) -> Result<(PointSet, Vec<u32>), Error> {
    let (of, points, set) = match skin_points.filter(|t| !t.is_absent()) {
        Some(points) => (PointSet::Skin, points, "skin_points"),
        None => (PointSet::Nodes, nodes.unwrap_or_default(), "nodes"),
    };
    let (_, points) = points.unpack(&format!("{kind}.{set}"))?;
    Ok((of, points))
}

fn some_nodes(nodes: Option<Tensor>, field: &str) -> Result<Option<Arc<Vec<u32>>>, Error> {
    let given = nodes.filter(|t| !t.is_absent());
    Ok(given.map(|t| t.unpack(field)).transpose()?.map(|(_, nodes)| Arc::new(nodes)))
}

/// Three numbers that the check has counted.
fn three(values: &[f32]) -> Point {
    values.try_into().unwrap_or_default()
}
