//! Costs that score a rollout.

use bendtwin_core::Point;
use bendtwin_proto::v1::{
    self, Cuboid, Plane, PointSet, Tensor,
    cost::{
        Clearance, ControlPath, ControlSpeed, Coverage, Force, Height, Keypoints, Kind, Order,
        Smoothness, Strain, TargetCloud, When, Winding, Within, force,
        winding::{Around, Axis},
    },
};

/// Source of a force on the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceBy {
    /// All control points together.
    Controls,
    /// A control point.
    Control(u32),
    /// A grasp of the request.
    Grasp(u32),
    /// The ground.
    Ground,
    /// A collider of the request.
    Collider(u32),
}

/// A straight line that a chain of nodes winds around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Line {
    /// The line through a point [m] along a unit vector.
    Axis {
        /// Point on the line [m].
        point: Point,
        /// Unit vector.
        direction: Point,
    },
    /// The axis of a fixed collider of the request that is a capsule, from its first end to its second.
    Capsule(u32),
}

/// A weighted cost, counted after the last frame unless [`Cost::every_frame`] or
/// [`Cost::soft_min`]. A weight of 0 switches it off, a negative one asks for more of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost(pub(super) v1::Cost);

impl Cost {
    /// Mean squared distance of the target's points [m] to the nearest point of the skin [m²].
    pub fn target_cloud(name: &str, weight: f64, points: &[Point]) -> Self {
        let points = Some(Tensor::pack_points(&[points.len()], points));
        let cloud = TargetCloud { points, point_set: PointSet::Skin.into() };
        Self::new(name, weight, Kind::TargetCloud(cloud))
    }

    /// Mean distance between points of the skin and their targets [m], which the server refuses if
    /// there is one too many or too few.
    pub fn skin_keypoints(name: &str, weight: f64, points: &[u32], targets: &[Point]) -> Self {
        let keypoints = Keypoints {
            skin_points: Some(Tensor::pack(&[points.len()], points)),
            targets: Some(Tensor::pack_points(&[targets.len()], targets)),
            ..Keypoints::default()
        };
        Self::new(name, weight, Kind::Keypoints(keypoints))
    }

    /// Mean distance between nodes and their targets [m]. A target too many or too few is left to
    /// the server to refuse.
    pub fn keypoints(name: &str, weight: f64, nodes: &[u32], targets: &[Point]) -> Self {
        let keypoints = Keypoints {
            nodes: Some(Tensor::pack(&[nodes.len()], nodes)),
            targets: Some(Tensor::pack_points(&[targets.len()], targets)),
            ..Keypoints::default()
        };
        Self::new(name, weight, Kind::Keypoints(keypoints))
    }

    /// Mean squared second difference of node positions over three frames [m²].
    pub fn smoothness(name: &str, weight: f64) -> Self {
        Self::new(name, weight, Kind::Smoothness(Smoothness {})).every_frame()
    }

    /// Mean over the springs of the material of max(0, |strain| - limit)².
    pub fn strain(name: &str, weight: f64, limit: f32) -> Self {
        Self::new(name, weight, Kind::Strain(Strain { limit }))
    }

    /// max(0, |f| - limit)² of the mean force over a frame [N², per unit mass where the object's
    /// mass is not known].
    pub fn force(name: &str, weight: f64, by: ForceBy, limit_n: f64) -> Self {
        let by = Some(match by {
            ForceBy::Controls => force::By::Controls(force::All {}),
            ForceBy::Control(control) => force::By::Control(control),
            ForceBy::Grasp(grasp) => force::By::Grasp(grasp),
            ForceBy::Ground => force::By::Ground(force::All {}),
            ForceBy::Collider(collider) => force::By::Collider(collider),
        });
        Self::new(name, weight, Kind::Force(Force { by, limit_n }))
    }

    /// Mean over all nodes of the squared depth below a plane [m²], whose unit normal shows to the
    /// side where nodes cost nothing.
    pub fn height(name: &str, weight: f64, normal: Point, offset_m: f32) -> Self {
        let plane = Some(Plane { normal: normal.to_vec(), offset_m });
        Self::new(name, weight, Kind::Height(Height { plane, nodes: None }))
    }

    /// Mean over all nodes of the squared distance to a box along the axes [m²], zero within.
    pub fn within(name: &str, weight: f64, low: Point, high: Point) -> Self {
        let cuboid = Some(Cuboid { low: low.to_vec(), high: high.to_vec() });
        Self::new(name, weight, Kind::Within(Within { cuboid, nodes: None }))
    }

    /// Mean over nodes of max(0, margin - distance)² to a collider of the request [m²].
    pub fn clearance(name: &str, weight: f64, collider: u32, margin_m: f32) -> Self {
        Self::new(name, weight, Kind::Clearance(Clearance { collider, margin_m }))
    }

    /// Length of the way of the control points, mean over them [m].
    pub fn control_path(name: &str, weight: f64) -> Self {
        Self::new(name, weight, Kind::ControlPath(ControlPath {}))
    }

    /// Mean over control points and frames of max(0, speed - limit)² [m²/s²].
    pub fn control_speed(name: &str, weight: f64, limit_m_s: f64) -> Self {
        Self::new(name, weight, Kind::ControlSpeed(ControlSpeed { limit_m_s }))
    }

    /// Order of nodes along a unit vector: mean over neighbours in the list of
    /// max(0, gap - direction · (x(next) - x))² [m²].
    pub fn order(name: &str, weight: f64, nodes: &[u32], direction: Point, gap_m: f32) -> Self {
        let nodes = Some(Tensor::pack(&[nodes.len()], nodes));
        let order = Order { nodes, direction: direction.to_vec(), gap_m, skin_points: None };
        Self::new(name, weight, Kind::Order(order))
    }

    /// Winding of a chain of nodes around a line, (turns - wanted turns)²; positive turns are
    /// counter-clockwise seen against the direction of the line.
    pub fn winding(name: &str, weight: f64, nodes: &[u32], around: Line, turns: f32) -> Self {
        let nodes = Some(Tensor::pack(&[nodes.len()], nodes));
        let around = Some(match around {
            Line::Axis { point, direction } => {
                Around::Axis(Axis { point: point.to_vec(), direction: direction.to_vec() })
            }
            Line::Capsule(collider) => Around::Collider(collider),
        });
        let winding = Winding { nodes, around, turns, skin_points: None };
        Self::new(name, weight, Kind::Winding(winding))
    }

    /// Uncovered share of points [m]: mean of 1 - exp(-d² / (2 reach²)), with the distance d to the nearest
    /// point of the skin.
    pub fn coverage(name: &str, weight: f64, points: &[Point], reach_m: f32) -> Self {
        let points = Some(Tensor::pack_points(&[points.len()], points));
        let coverage = Coverage { points, reach_m, point_set: PointSet::Skin.into() };
        Self::new(name, weight, Kind::Coverage(coverage))
    }

    /// Adds a condition of success: the value after the last frame, without the weight, is at most this.
    /// [`Reply::successes`](super::Reply::successes) has the instances that meet all.
    #[must_use]
    pub fn success_at_most(mut self, value: f64) -> Self {
        self.0.success_at_most = Some(value);
        self
    }

    /// Gives targets another shape than [M]: [F, M] by frame, [B, 1, M] by instance or [B, F, M];
    /// nothing changes for costs without targets. A shape that does not fit is left to the server to
    /// refuse.
    #[must_use]
    pub fn shaped(mut self, shape: &[usize]) -> Self {
        let targets = match &mut self.0.kind {
            Some(Kind::TargetCloud(cloud)) => cloud.points.as_mut(),
            Some(Kind::Keypoints(keypoints)) => keypoints.targets.as_mut(),
            _ => None,
        };
        if let Some(targets) = targets {
            targets.shape = shape.iter().map(|d| *d as u64).chain([3]).collect();
        }
        self
    }

    /// Measures a target cloud or a coverage to the nearest surface node instead of the skin; no effect on
    /// other costs.
    #[must_use]
    pub fn at_nodes(mut self) -> Self {
        match &mut self.0.kind {
            Some(Kind::TargetCloud(cloud)) => cloud.point_set = PointSet::Nodes.into(),
            Some(Kind::Coverage(coverage)) => coverage.point_set = PointSet::Nodes.into(),
            _ => {}
        }
        self
    }

    /// Measures an order or a winding at these points of the skin instead of nodes; no effect on other
    /// costs.
    #[must_use]
    pub fn at_skin_points(mut self, points: &[u32]) -> Self {
        let points = Some(Tensor::pack(&[points.len()], points));
        match &mut self.0.kind {
            Some(Kind::Order(order)) => (order.nodes, order.skin_points) = (None, points),
            Some(Kind::Winding(winding)) => (winding.nodes, winding.skin_points) = (None, points),
            _ => {}
        }
        self
    }

    /// Only of these nodes, of a height or a box; nothing changes for other costs.
    #[must_use]
    pub fn of_nodes(mut self, nodes: &[u32]) -> Self {
        let nodes = Some(Tensor::pack(&[nodes.len()], nodes));
        match &mut self.0.kind {
            Some(Kind::Height(height)) => height.nodes = nodes,
            Some(Kind::Within(within)) => within.nodes = nodes,
            _ => {}
        }
        self
    }

    /// Keypoint distances squared [m²]; nothing changes for other costs.
    #[must_use]
    pub fn squared(mut self) -> Self {
        if let Some(Kind::Keypoints(keypoints)) = &mut self.0.kind {
            keypoints.squared = true;
        }
        self
    }

    /// Summed over all frames.
    #[must_use]
    pub fn every_frame(mut self) -> Self {
        self.0.when = When::EveryFrame.into();
        self
    }

    /// Low if it is low in any frame: a soft minimum over all of them. The temperature is the
    /// difference of costs, in their own unit, at which a frame counts for clearly less.
    #[must_use]
    pub fn soft_min(mut self, temperature: f64) -> Self {
        self.0.when = When::SoftMin.into();
        self.0.temperature = temperature;
        self
    }

    fn new(name: &str, weight: f64, kind: Kind) -> Self {
        Self(v1::Cost {
            name: name.to_owned(),
            weight: Some(weight),
            when: When::LastFrame.into(),
            kind: Some(kind),
            ..v1::Cost::default()
        })
    }
}
