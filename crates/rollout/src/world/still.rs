//! A world before anything moves, in which a twin settles: its gravity and ground, and the colliders
//! that stand still or begin a path. Grippers and their load are not there, unless it is said where
//! they are: actions say so, and each instance may have others.

use std::sync::Arc;

use bendtwin_core::{Environment, Params};
use bendtwin_engine::{
    Backend, Loaded, Motion, World,
    model::State,
    world::{Pose, Shape},
};
use bendtwin_proto::v1::{self, collider::Carrier};
use bendtwin_register::{Around, PlacedBody};
use prost::Message as _;

use super::Surroundings;
use crate::{error::Error, request::actions::pose};

/// Bytes of the first pose of a path.
const POSE_BYTES: usize = 7 * 4;

/// Faces of a collider that are as much work as a spring.
const FACES_OF_ELEMENT: usize = 4;

/// A world in which nothing moves.
#[derive(Debug)]
pub struct Still {
    surroundings: Surroundings,
    /// Poses of the bodies that begin a path, shape [B].
    poses: Vec<Pose>,
    key: [u8; 32],
}

impl Still {
    /// The world of a checked request, or the twin's own without one.
    pub fn read(wire: Option<&v1::World>) -> Result<Self, Error> {
        Self::among(wire, &[])
    }

    /// The world with what the first grippers carry, at their poses.
    pub(crate) fn among(wire: Option<&v1::World>, grippers: &[Pose]) -> Result<Self, Error> {
        let default = v1::World::default();
        let wire = wire.unwrap_or(&default);
        let key = *blake3::hash(&at_rest(wire).encode_to_vec()).as_bytes();
        let mut surroundings = Surroundings::without_bodies(wire);
        let mut poses = Vec::new();
        for (index, collider) in wire.colliders.iter().enumerate() {
            let body = match &collider.carrier {
                Some(Carrier::Gripper(number)) => {
                    let Some(pose) = grippers.get(*number as usize) else { continue };
                    poses.push(*pose);
                    Some((poses.len() - 1) as u32)
                }
                Some(Carrier::Path(path)) => {
                    let field = format!("world.colliders[{index}].path");
                    let (_, rows) = path.unpack::<f32>(&field)?;
                    rows.as_chunks::<7>().0.first().map(|row| {
                        poses.push(pose(*row));
                        (poses.len() - 1) as u32
                    })
                }
                None | Some(Carrier::Fixed(_)) => None,
            };
            surroundings.add_collider(collider, index, body)?;
        }
        surroundings.world.bodies = poses.len();
        Ok(Self { surroundings, poses, key })
    }

    /// Digest, the same for worlds in which a twin settles in the same way.
    pub fn key(&self) -> [u8; 32] {
        self.key
    }

    /// A model in this gravity and on this ground, with at least `drag` [1/s].
    pub(crate) fn load(
        &self,
        model: &Loaded,
        drag: f32,
        backend: &dyn Backend,
    ) -> Result<Loaded, Error> {
        let own = model.model();
        let mut params = own.params.clone();
        self.surroundings.touch(&mut params.contact);
        let damped = Params { drag: params.drag.max(drag), ..params };
        let model = backend.with_params(model, damped)?;
        Ok(match self.surroundings.environment(model.model().environment) {
            None => model,
            Some(environment) => backend.with_environment(&model, environment)?,
        })
    }

    /// The environment that takes the place of a model's own, if it differs.
    pub(crate) fn environment(&self, own: Environment) -> Option<Environment> {
        self.surroundings.environment(own)
    }

    /// Surroundings of an object in this world.
    pub(crate) fn around_now(&self) -> Around {
        let still = |pose: &Pose| Some(PlacedBody { pose: *pose, rate: Pose::default() });
        let bodies: Vec<Option<PlacedBody>> = self.poses.iter().map(still).collect();
        Around::new(&self.surroundings.world, &bodies, &State::default())
    }

    /// The colliders, and their poses during `frames` frames.
    pub(crate) fn around(&self, frames: usize) -> (Arc<World>, Arc<Motion>) {
        let motion = Motion { poses: self.poses.repeat(frames + 1), ..Motion::default() };
        (Arc::new(self.surroundings.world.clone()), Arc::new(motion))
    }

    /// Work of the colliders for a node in a substep, in elements.
    pub(crate) fn work(&self) -> u64 {
        let each = self.surroundings.world.colliders.iter().map(|c| match &c.shape {
            Shape::Convex(faces) => faces.len().div_ceil(FACES_OF_ELEMENT),
            Shape::Capsule { .. } => 1,
        });
        each.sum::<usize>() as u64
    }
}

/// The part of a world that exists before anything moves, without names: paths have their first
/// pose alone.
fn at_rest(wire: &v1::World) -> v1::World {
    let mut world = wire.clone();
    world.colliders.retain(|c| !matches!(c.carrier, Some(Carrier::Gripper(_))));
    for collider in &mut world.colliders {
        collider.name.clear();
        if let Some(Carrier::Path(path)) = &mut collider.carrier {
            path.data.truncate(POSE_BYTES);
            path.shape = vec![1, 7];
        }
    }
    world
}
