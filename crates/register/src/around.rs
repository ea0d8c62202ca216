//! Surroundings of an object at one moment: what a correction or a registration keeps it out of, and
//! which of its control points hold nothing then.

use bendtwin_core::geometry::{add, dot};
use bendtwin_engine::{
    model::State,
    world::{Collider, Face, Phase, Pose, Region, Shape, World},
};

/// Surroundings at one moment, beside the ground of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Around {
    /// Colliders where they are.
    pub obstacles: Vec<Obstacle>,
    /// Control points that hold nothing: those of hands that are open.
    pub loose: Vec<u32>,
}

/// A collider at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// The collider in world coordinates, at its body's pose.
    pub collider: Collider,
    /// Velocity of its points: that of a point at `x` is `R x + p` [m/s] with the rows [R | p].
    pub motion: Pose,
}

/// A body at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedBody {
    /// Pose of the body.
    pub pose: Pose,
    /// Change of the pose [1/s].
    pub rate: Pose,
}

impl Around {
    /// A world with its bodies where they are, shape [B]; what is carried by one that is not known is
    /// left out. `state` says which hands are open.
    pub fn new(world: &World, bodies: &[Option<PlacedBody>], state: &State) -> Self {
        let obstacle = |collider: &Collider| match collider.body {
            None => Some(Obstacle { collider: collider.clone(), motion: Pose::default() }),
            Some(body) => Some(Obstacle::carried(collider, bodies.get(body as usize)?.as_ref()?)),
        };
        let phases = &state.grasping.phases;
        let is_open = |g: usize| phases.get(g).is_some_and(|phase| *phase == Phase::Open);
        let open = world.grasps.iter().enumerate().filter(|(g, _)| is_open(*g));
        let loose = open.flat_map(|(_, grasp)| match &grasp.region {
            Region::Controls(controls) => controls.to_vec(),
            _ => Vec::new(),
        });
        Self {
            obstacles: world.colliders.iter().filter_map(obstacle).collect(),
            loose: loose.collect(),
        }
    }

    /// True if a control point holds nothing.
    pub(crate) fn is_loose(&self, control: usize) -> bool {
        self.loose.iter().any(|loose| *loose as usize == control)
    }
}

impl Obstacle {
    /// A collider that a body carries.
    fn carried(collider: &Collider, body: &PlacedBody) -> Self {
        let PlacedBody { pose, rate } = body;
        let at = |p: [f32; 3]| pose.map(|[x, y, z, at]| x * p[0] + y * p[1] + z * p[2] + at);
        let turned = |d: [f32; 3]| pose.map(|[x, y, z, _]| x * d[0] + y * d[1] + z * d[2]);
        let position = pose.map(|row| row[3]);
        let shape = match &collider.shape {
            Shape::Capsule { from, to, radius_m } => {
                Shape::Capsule { from: at(*from), to: at(*to), radius_m: *radius_m }
            }
            Shape::Convex(faces) => {
                let face = |face: &Face| {
                    let normal = turned(face.normal);
                    Face { normal, offset_m: face.offset_m + dot(normal, position) }
                };
                Shape::Convex(std::sync::Arc::new(faces.iter().map(face).collect()))
            }
        };
        // A point x of the world is at Rᵀ (x - p) of the body.
        let motion: Pose = rate.map(|rate| {
            let spin: [f32; 3] =
                std::array::from_fn(|j| (0..3).map(|k| rate[k] * pose[j][k]).sum::<f32>());
            [spin[0], spin[1], spin[2], rate[3] - dot(spin, position)]
        });
        Self { collider: Collider { body: None, shape, ..collider.clone() }, motion }
    }

    /// Velocity of its point at `x` [m/s].
    pub fn velocity(&self, x: [f32; 3]) -> [f32; 3] {
        let turning = self.motion.map(|[a, b, c, _]| dot([a, b, c], x));
        add(turning, self.motion.map(|row| row[3]))
    }
}

#[cfg(test)]
mod tests;
