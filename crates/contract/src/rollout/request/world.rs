//! Surroundings: gravity, ground and colliders.

use std::collections::HashSet;

use bendtwin_proto::v1::{
    Capsule, Collider, Cuboid, Grasp, Plane, RollOutRequest, Sphere, Tensor, World,
    collider::{Carrier, Shape},
    roll_out_request::Actions,
    tensor::Dtype,
    world::GroundChoice,
};

use super::{
    Asked, Error, Grippers, Limits, Moves, Price, mul,
    numbers::{angle_free, least, unit, vector, within_range},
    sum,
    tensors::{finite, floats, given, required},
    vary::set_bytes,
};

/// Most colliders, most grasps, and most rigid bodies that carry any of them.
pub(in crate::rollout) const MOST_PARTS: u64 = 32;
/// A pose of a body, and its gradient [bytes].
const POSE: u64 = 48;
/// A face of a collider, and faces of all of them at most [bytes].
const FACES: u64 = 16 * 32 * 128;
/// Fewest and most points of a convex mesh.
const MESH_POINTS: std::ops::RangeInclusive<u64> = 4..=4096;
/// Farthest that anything is from where it belongs [m].
pub(super) const FARTHEST_M: f32 = 1000.0;

pub(in crate::rollout) fn check(
    world: Option<&World>,
    grasps: &[Grasp],
    moves: &Moves,
    limits: &Limits,
) -> Result<(), Error> {
    let Some(world) = world else { return bodies(None, grasps, moves) };
    if !world.gravity.is_empty() {
        vector(&world.gravity, "world.gravity", f32::MAX)?;
    }
    if let Some(GroundChoice::Ground(plane)) = &world.ground_choice {
        self::plane(plane, "world.ground")?;
    }
    within_range(world.ground_friction, "world.ground_friction", 0.0..=2.0)?;
    within_range(world.ground_restitution, "world.ground_restitution", 0.0..=1.0)?;
    parts("world.colliders", world.colliders.len())?;
    let mut names = HashSet::new();
    for (i, collider) in world.colliders.iter().enumerate() {
        let field = |part: &str| format!("world.colliders[{i}].{part}");
        let named = !collider.name.is_empty();
        let name = if named { collider.name.clone() } else { format!("collider{i}") };
        if name.len() as u64 > limits.name_bytes || name.chars().any(char::is_control) {
            let fault = format!("is longer than {} bytes or not printable", limits.name_bytes);
            return Err(Error::field(field("name"), fault));
        }
        if let Some(name) = names.replace(name) {
            let fault = format!("is `{name}`, which an earlier collider has: names must differ");
            return Err(Error::field(field("name"), fault));
        }
        self::collider(collider, &field, moves)?;
    }
    bodies(Some(world), grasps, moves)
}

/// Refuses more parts than a world has.
pub(in crate::rollout) fn parts(field: &str, count: usize) -> Result<(), Error> {
    if count as u64 > MOST_PARTS {
        let fault = format!("are {count}: at most {MOST_PARTS} are possible, leave some out");
        return Err(Error::field(field, fault));
    }
    Ok(())
}

/// A plane; its normal may be absent.
pub(super) fn plane(plane: &Plane, field: &str) -> Result<(), Error> {
    if !plane.normal.is_empty() {
        unit(&plane.normal, &format!("{field}.normal"))?;
    }
    let range = -FARTHEST_M..=FARTHEST_M;
    within_range(Some(plane.offset_m), &format!("{field}.offset_m"), range)
}

/// A sphere; its centre may be absent.
pub(crate) fn sphere(sphere: &Sphere, field: &str) -> Result<(), Error> {
    if !sphere.center.is_empty() {
        vector(&sphere.center, &format!("{field}.center"), FARTHEST_M)?;
    }
    radius(sphere.radius_m, field)
}

/// A box.
pub(crate) fn cuboid(cuboid: &Cuboid, field: &str) -> Result<(), Error> {
    let (low, high) = (format!("{field}.low"), format!("{field}.high"));
    let least = vector(&cuboid.low, &low, FARTHEST_M)?;
    let most = vector(&cuboid.high, &high, FARTHEST_M)?;
    if least.iter().zip(most).all(|(low, high)| *low < high) {
        return Ok(());
    }
    let fault = format!("is {least:?}, which is not below `high`, {most:?}, in every coordinate");
    Err(Error::field(low, fault))
}

/// The gripper of a part, which the actions must have.
pub(super) fn gripper(number: u32, field: &str, moves: &Moves) -> Result<(), Error> {
    match moves.grippers {
        Grippers::None => {
            let fault = "needs grippers: give the actions as `poses`, not as `trajectories`";
            Err(Error::field(field, fault))
        }
        Grippers::Count(grippers) if u64::from(number) >= grippers => {
            let fault = format!("names gripper {number}, there are {grippers} (counted from 0)");
            Err(Error::field(field, fault))
        }
        Grippers::Count(_) | Grippers::Later => Ok(()),
    }
}

/// The grippers of actions.
pub(in crate::rollout) fn grippers(actions: Option<&Actions>) -> Grippers {
    let Some(Actions::Poses(poses)) = actions else { return Grippers::None };
    Grippers::Count(poses.poses.as_ref().and_then(|t| t.shape.get(2)).copied().unwrap_or(0))
}

fn collider(
    collider: &Collider,
    field: &impl Fn(&str) -> String,
    moves: &Moves,
) -> Result<(), Error> {
    match &collider.shape {
        None => {
            let fault = "is missing: give sphere, capsule, cuboid or convex_mesh";
            return Err(Error::field(field("shape"), fault));
        }
        Some(Shape::Sphere(s)) => sphere(s, &field("sphere"))?,
        Some(Shape::Capsule(c)) => capsule(c, &field("capsule"))?,
        Some(Shape::Cuboid(c)) => cuboid(c, &field("cuboid"))?,
        Some(Shape::ConvexMesh(m)) => mesh(m.points.as_ref(), &field("convex_mesh.points"))?,
    }
    within_range(collider.friction, &field("friction"), 0.0..=2.0)?;
    within_range(collider.restitution, &field("restitution"), 0.0..=1.0)?;
    within_range(Some(collider.margin_m), &field("margin_m"), 0.0..=FARTHEST_M)?;
    match &collider.carrier {
        None | Some(Carrier::Fixed(_)) => {}
        Some(Carrier::Gripper(number)) => gripper(*number, &field("gripper"), moves)?,
        Some(Carrier::Path(path)) => self::path(path, &field("path"), moves.knots)?,
    }
    match collider.pose[..] {
        [] => Ok(()),
        [_, _, _, _, _, _, _] => pose(&collider.pose, &field("pose")),
        _ => {
            let fault = format!(
                "has {} numbers, not 7 (x, y, z, then the quaternion x, y, z, w)",
                collider.pose.len()
            );
            Err(Error::field(field("pose"), fault))
        }
    }
}

/// A capsule.
pub(crate) fn capsule(capsule: &Capsule, field: &str) -> Result<(), Error> {
    vector(&capsule.from, &format!("{field}.from"), FARTHEST_M)?;
    vector(&capsule.to, &format!("{field}.to"), FARTHEST_M)?;
    radius(capsule.radius_m, field)
}

fn radius(radius_m: f32, field: &str) -> Result<(), Error> {
    let field = format!("{field}.radius_m");
    least(radius_m, &field, f32::MIN_POSITIVE)?;
    within_range(Some(radius_m), &field, 0.0..=FARTHEST_M)
}

/// Points of a convex mesh. Their hull is made, and may be refused, where the twin is.
pub(crate) fn mesh(points: Option<&Tensor>, field: &str) -> Result<(), Error> {
    let (tensor, shape) = required(points, field, Dtype::Float32)?;
    match shape[..] {
        [count, 3] if MESH_POINTS.contains(&count) => {}
        _ => {
            let (least, most) = (MESH_POINTS.start(), MESH_POINTS.end());
            let fault =
                format!("has shape {shape:?}, not [M, 3] with M in {least}..={most}: thin it out");
            return Err(Error::field(field, fault));
        }
    }
    finite(tensor, field)?;
    match floats(tensor).find(|x| x.abs() > FARTHEST_M) {
        Some(x) => Err(Error::field(field, format!("has {x}: the unit is metres"))),
        None => Ok(()),
    }
}

fn path(path: &Tensor, field: &str, knots: Option<u64>) -> Result<(), Error> {
    let (tensor, shape) = required(Some(path), field, Dtype::Float32)?;
    let fits = matches!(shape[..], [own, 7] if knots.is_none_or(|knots| own == knots));
    if !fits {
        let knots = knots.map_or("K".to_owned(), |knots| knots.to_string());
        let fault = format!("has shape {shape:?}, not [{knots}, 7]: a pose for each knot");
        return Err(Error::field(field, fault));
    }
    finite(tensor, field)?;
    let rows = tensor.data.as_chunks::<28>().0;
    let short = rows.iter().position(|row| {
        let quaternion = row[12..].as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
        angle_free(quaternion)
    });
    match short {
        Some(knot) => {
            let fault = format!(
                "has a quaternion of length zero in knot {knot}; no rotation is [0, 0, 0, 1]"
            );
            Err(Error::field(field, fault))
        }
        None => Ok(()),
    }
}

fn pose(pose: &[f32], field: &str) -> Result<(), Error> {
    if let Some(x) = pose.iter().find(|x| !x.is_finite()) {
        return Err(Error::field(field, format!("has {x}: all numbers must be finite")));
    }
    if angle_free(pose[3..].iter().copied()) {
        let fault = "has a quaternion of length zero; no rotation is [0, 0, 0, 1]";
        return Err(Error::field(field, fault));
    }
    Ok(())
}

/// Refuses more bodies than a world has.
fn bodies(world: Option<&World>, grasps: &[Grasp], moves: &Moves) -> Result<(), Error> {
    let bodies = bodies_among(world, grasps, moves.grippers);
    if bodies > MOST_PARTS {
        let fault = format!(
            "have {bodies} carriers, grippers of the actions and paths together: at most {MOST_PARTS} are possible"
        );
        return Err(Error::field("world.colliders", fault));
    }
    Ok(())
}

/// Number of rigid bodies that a request moves: all grippers and paths, or none if nothing is
/// carried.
fn bodies_of(request: &RollOutRequest) -> u64 {
    let grippers = grippers(request.actions.as_ref());
    bodies_among(request.world.as_ref(), &request.grasps, grippers)
}

fn bodies_among(world: Option<&World>, grasps: &[Grasp], grippers: Grippers) -> u64 {
    let carriers = || world.iter().flat_map(|w| &w.colliders).filter_map(|c| c.carrier.as_ref());
    let paths = carriers().filter(|c| matches!(c, Carrier::Path(_))).count() as u64;
    let carrying = carriers().filter_map(|carrier| match carrier {
        Carrier::Gripper(number) => Some(*number),
        Carrier::Path(_) | Carrier::Fixed(_) => None,
    });
    let last = grasps.iter().map(|grasp| grasp.gripper).chain(carrying).max();
    let grippers = match grippers {
        Grippers::Count(count) if last.is_some() || paths > 0 => count,
        Grippers::Later => last.map_or(0, |last| u64::from(last) + 1),
        Grippers::Count(_) | Grippers::None => 0,
    };
    grippers.saturating_add(paths)
}

/// Bodies that move, the faces of colliders, and a model in another environment.
pub(in crate::rollout) fn price(asked: &Asked<'_>) -> Price {
    let world = asked.request.world.as_ref();
    let bodies = bodies_of(asked.request);
    let poses = mul(&[asked.boundaries, bodies, POSE]);
    Price {
        work_of_node: work_of(world),
        fixed: sum(&[
            if world.is_some() { set_bytes(asked.elements()) } else { 0 },
            if world.is_some() || bodies > 0 { FACES } else { 0 },
        ]),
        prepared: poses,
        running: poses,
        ..Price::default()
    }
}

/// Work of a world for a node in a substep, in elements: a face is a fourth of a spring.
pub(crate) fn work_of(world: Option<&World>) -> u64 {
    let colliders = world.iter().flat_map(|world| &world.colliders);
    let each = colliders.map(|collider| match &collider.shape {
        Some(Shape::ConvexMesh(mesh)) => {
            // A hull has at most two faces a point.
            let points = mesh.points.as_ref().and_then(|t| t.shape.first()).copied().unwrap_or(0);
            (points / 2).clamp(1, 32)
        }
        Some(Shape::Cuboid(_)) => 2,
        _ => 1,
    });
    each.sum::<u64>()
}

/// Checks the surroundings of an object at one moment, and the poses of the grippers in it, FLOAT32
/// [G, 7].
pub(crate) fn check_now(
    world: Option<&World>,
    grippers: Option<&Tensor>,
    field: &str,
    limits: &Limits,
) -> Result<(), Error> {
    let moves = Moves { instances: 1, knots: None, grippers: Grippers::Later };
    check(world, &[], &moves, limits)?;
    let Some(poses) = given(grippers) else { return Ok(()) };
    path(poses, field, None)?;
    match poses.shape.first() {
        Some(count) if *count <= MOST_PARTS => Ok(()),
        _ => Err(Error::field(field, format!("has more than {MOST_PARTS} poses"))),
    }
}
