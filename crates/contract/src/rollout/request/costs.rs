//! Costs: names, weights, times and what they measure, and what it takes to measure it.

mod lists;
mod targets;

use std::{collections::HashSet, ops::RangeInclusive};

use bendtwin_proto::v1::{
    Cost, PointSet, RollOutRequest, Tensor,
    cost::{
        Kind, When,
        force::{self, By},
        winding::Around,
    },
};

use self::targets::{by_instance, points};
use super::{
    Asked, Batch, Error, Limits, Message, Price, TwinShape,
    gradients::has_gradients,
    mul,
    numbers::{least, within_range},
    returns::has_skin,
    sum,
    tensors::{given, index_list, known_nodes, known_skin_points},
    within,
    world::{cuboid, plane},
};
use crate::rollout::points::{is_at_skin, measured, measures_nodes, point_set};

/// Target points that a cost counts for in each of its frames, beside its own.
const OVERHEAD: u128 = 16;
/// A target point with its node, its term's share and the copy that sorting makes [bytes].
const TARGET: u64 = 32;
/// A name of a cost beside its text [bytes].
const NAME: u64 = 64;
/// A cost in a frame: its sum, and its value in the reply [bytes].
const FRAME_COST: u64 = 16;
/// A point of the skin where a cost is measured there: its place, and its part of the search for the
/// nearest [bytes].
const SKIN_POINT: u64 = 128;
/// Work of looking one target point up, in element substeps.
const TARGET_WORK: u128 = 20;
/// Work of a spring, and of a node in a region, in a cost of all of them.
const SPRING_WORK: u128 = 4;
const NODE_WORK: u128 = 2;
/// Work of placing a point of the skin, which is carried by some sixteen nodes.
const SKIN_WORK: u128 = 8;
/// Work of the distance between a node and a collider.
const COLLIDER_WORK: u128 = 32;

/// Least and greatest reach of a coverage [m].
const REACHES_M: RangeInclusive<f32> = 1e-6..=1000.0;

/// Checks costs, given the numbers of colliders and grasps.
pub(in crate::rollout) fn check(
    request: &RollOutRequest,
    parts: [usize; 2],
    batch: &Batch,
    limits: &Limits,
) -> Result<(), Error> {
    let costs = &request.costs;
    within("the number of costs", costs.len() as u128, limits.costs, "merge target clouds")?;
    let mut names = HashSet::new();
    for (i, cost) in costs.iter().enumerate() {
        let field = |part: &str| format!("costs[{i}].{part}");
        let name = if cost.name.is_empty() { format!("cost{i}") } else { cost.name.clone() };
        if name.len() as u64 > limits.name_bytes || name.chars().any(char::is_control) {
            let fault = format!("is longer than {} bytes or not printable", limits.name_bytes);
            return Err(Error::field(field("name"), fault));
        }
        if let Some(name) = names.replace(name) {
            let fault = format!("is `{name}`, which an earlier cost has: names must differ");
            return Err(Error::field(field("name"), fault));
        }
        if let Some(weight) = cost.weight
            && !(weight as f32).is_finite()
        {
            let fault = format!("is {weight}: it must be finite in single precision, 1 say");
            return Err(Error::field(field("weight"), fault));
        }
        let Ok(when) = When::try_from(cost.when) else {
            let fault = format!(
                "has the unknown value {}: use LAST_FRAME, EVERY_FRAME or SOFT_MIN",
                cost.when
            );
            return Err(Error::field(field("when"), fault));
        };
        if when == When::SoftMin && !(cost.temperature.is_finite() && cost.temperature > 0.0) {
            let fault = format!(
                "is {}: SOFT_MIN needs one above 0, the difference of costs that matters say",
                cost.temperature
            );
            return Err(Error::field(field("temperature"), fault));
        }
        kind(cost, when, request, parts, batch, &field)?;
        condition(cost, &field)?;
    }
    within(
        "the number of target points over all instances and frames of all costs",
        targets(costs, batch),
        limits.targets,
        "thin the targets out, or count them in the last frame only",
    )
}

pub(in crate::rollout) fn check_for(costs: &[Cost], twin: &TwinShape) -> Result<(), Error> {
    for (i, cost) in costs.iter().enumerate() {
        let (nodes, skin_points, kind) = match &cost.kind {
            Some(Kind::TargetCloud(cloud)) => {
                if measured(cloud.point_set()) == PointSet::Skin {
                    has_skin(twin, &format!("costs[{i}].target_cloud.point_set"))?;
                }
                continue;
            }
            Some(Kind::Coverage(coverage)) => {
                if measured(coverage.point_set()) == PointSet::Skin {
                    has_skin(twin, &format!("costs[{i}].coverage.point_set"))?;
                }
                continue;
            }
            Some(Kind::Keypoints(k)) => (&k.nodes, &k.skin_points, "keypoints"),
            Some(Kind::Order(o)) => (&o.nodes, &o.skin_points, "order"),
            Some(Kind::Winding(w)) => (&w.nodes, &w.skin_points, "winding"),
            Some(Kind::Height(h)) => (&h.nodes, &None, "height"),
            Some(Kind::Within(w)) => (&w.nodes, &None, "within"),
            Some(Kind::Force(f)) => {
                if let Some(By::Control(control)) = f.by
                    && u64::from(control) >= twin.controls
                {
                    let count = twin.controls;
                    let fault = format!(
                        "names control point {control}, the twin has {count} (counted from 0)"
                    );
                    return Err(Error::field(format!("costs[{i}].force.control"), fault));
                }
                continue;
            }
            Some(_) | None => continue,
        };
        if let Some(points) = given(skin_points.as_ref()) {
            let field = format!("costs[{i}].{kind}.skin_points");
            known_skin_points(points, &field, twin.skin_points)?;
        }
        if let Some(nodes) = given(nodes.as_ref()) {
            known_nodes(nodes, &format!("costs[{i}].{kind}.nodes"), twin.nodes)?;
        }
    }
    Ok(())
}

/// Targets, terms, and costs by frame.
pub(in crate::rollout) fn price(asked: &Asked<'_>) -> Price {
    let (costs, batch, twin) = (&asked.request.costs, asked.batch, asked.twin);
    let (instances, count) = (batch.instances, costs.len() as u64);
    let narrow = |count: u128| u64::try_from(count).unwrap_or(u64::MAX);
    let targets = narrow(targets(costs, batch));
    let soft_min = costs.iter().any(|cost| cost.when() == When::SoftMin);
    // A soft minimum weighs frames differently in each instance's gradient.
    let own = narrow(own_targets(costs, batch, soft_min && has_gradients(&asked.returns)));
    let conditions = costs.iter().filter(|cost| cost.success_at_most.is_some()).count() as u64;
    let frame_costs = mul(&[FRAME_COST, asked.boundaries, count + conditions]);
    // What is differentiated has no conditions, so its terms are others.
    let objectives = if conditions > 0 && has_gradients(&asked.returns) { 2 } else { 1 };
    let names = costs.iter().map(|cost| cost.name.len() as u64 + NAME).sum::<u64>();
    let mut reply = Message::default();
    for (i, cost) in costs.iter().enumerate() {
        let name = &cost.name;
        reply.text(if name.is_empty() { format!("cost{i}").len() } else { name.len() });
    }
    reply.tensor(1, 8, &[asked.covered]);
    reply.tensor(1, 8, &[asked.covered, count]);
    if conditions > 0 {
        reply.tensor(2, 4, &[asked.covered]);
    }
    Price {
        work: work(costs, batch, twin),
        reply,
        fixed: sum(&[
            mul(&[TARGET, targets, objectives]),
            // Costs by instance, of all parts where the best are chosen.
            mul(&[instances, 16]),
            // Of all instances of a part, until its gradients are there.
            if soft_min { mul(&[instances, asked.members, frame_costs]) } else { 0 },
        ]),
        prepared: sum(&[mul(&[2, names]), mul(&[TARGET, own, objectives]), frame_costs]),
        running: sum(&[
            // Terms in the order of their frames.
            targets,
            mul(&[SKIN_POINT, placed(asked)]),
        ]),
        ..Price::default()
    }
}

/// Points of the skin that are placed for costs.
fn placed(asked: &Asked<'_>) -> u64 {
    let costs = &asked.request.costs;
    // Keypoints at nodes are points of the planner's skin, behind those of the twin's own.
    let nodes_at_skin = asked.is_of_planner() && costs.iter().any(measures_nodes);
    if !nodes_at_skin && !costs.iter().any(is_at_skin) {
        return 0;
    }
    let nodes = if nodes_at_skin { asked.twin.nodes } else { 0 };
    asked.twin.most_skin_points().saturating_add(nodes)
}

/// Work of the costs of one instance, in element substeps.
fn work(costs: &[Cost], batch: &Batch, twin: &TwinShape) -> u128 {
    let nodes = u128::from(twin.nodes);
    let each = |cost: &Cost| {
        let placed =
            if is_at_skin(cost) { SKIN_WORK * u128::from(twin.most_skin_points()) } else { 0 };
        let listed = points(cost).max(1) * TARGET_WORK + placed;
        match &cost.kind {
            Some(Kind::Strain(_)) => u128::from(twin.springs) * SPRING_WORK,
            Some(Kind::Height(_) | Kind::Within(_)) => listed.max(nodes * NODE_WORK),
            Some(Kind::Clearance(_)) => nodes * COLLIDER_WORK,
            _ => listed,
        }
    };
    costs.iter().map(|cost| each(cost).saturating_mul(evaluations(cost, batch))).sum()
}

/// Target points over all instances and frames of all costs, with the overhead of each.
pub(in crate::rollout) fn targets(costs: &[Cost], batch: &Batch) -> u128 {
    let lists = |cost: &Cost| if by_instance(cost) { u128::from(batch.instances) } else { 1 };
    costs.iter().map(|cost| one_list(cost, batch).saturating_mul(lists(cost))).sum()
}

/// Those of one instance: of costs whose targets differ by instance or, with `all`, of all costs.
pub(in crate::rollout) fn own_targets(costs: &[Cost], batch: &Batch, all: bool) -> u128 {
    let own = costs.iter().filter(|cost| all || by_instance(cost));
    own.map(|cost| one_list(cost, batch)).sum()
}

/// Target points over all frames of a cost for one instance, with the overhead.
fn one_list(cost: &Cost, batch: &Batch) -> u128 {
    (points(cost) + OVERHEAD).saturating_mul(evaluations(cost, batch))
}

fn kind(
    cost: &Cost,
    when: When,
    request: &RollOutRequest,
    [colliders, grasps]: [usize; 2],
    batch: &Batch,
    field: &impl Fn(&str) -> String,
) -> Result<(), Error> {
    match &cost.kind {
        None => {
            let fault = "is missing: give target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding or coverage";
            Err(Error::field(field("kind"), fault))
        }
        Some(Kind::TargetCloud(cloud)) => {
            point_set(cloud.point_set, &field("target_cloud.point_set"))?;
            let points = field("target_cloud.points");
            targets::check(cloud.points.as_ref(), &points, when, batch).map(drop)
        }
        Some(Kind::Keypoints(keypoints)) => {
            let (nodes, skin_points) = (&keypoints.nodes, &keypoints.skin_points);
            let (points, what) = named(nodes.as_ref(), skin_points.as_ref(), "keypoints", field)?;
            let targets = field("keypoints.targets");
            let count = targets::check(keypoints.targets.as_ref(), &targets, when, batch)?;
            if points.shape != [count] {
                let fault = format!("has {count} points for {} {what}", points.shape[0]);
                return Err(Error::field(targets, fault));
            }
            Ok(())
        }
        Some(Kind::Strain(strain)) => least(strain.limit, &field("strain.limit"), 0.0),
        Some(Kind::Force(f)) => force(f, grasps, colliders, field),
        Some(Kind::Height(height)) => {
            if let Some(ground) = &height.plane {
                plane(ground, &field("height.plane"))?;
            }
            some_nodes(height.nodes.as_ref(), &field("height.nodes"))
        }
        Some(Kind::Within(within)) => {
            let Some(space) = &within.cuboid else {
                return Err(Error::field(field("within.cuboid"), "is missing"));
            };
            cuboid(space, &field("within.cuboid"))?;
            some_nodes(within.nodes.as_ref(), &field("within.nodes"))
        }
        Some(Kind::Clearance(clearance)) => {
            known(clearance.collider, colliders, "collider", &field("clearance.collider"))?;
            least(clearance.margin_m, &field("clearance.margin_m"), 0.0)
        }
        Some(Kind::ControlSpeed(speed)) => {
            amount(speed.limit_m_s, &field("control_speed.limit_m_s"))
        }
        Some(Kind::Smoothness(_) | Kind::ControlPath(_)) => Ok(()),
        Some(Kind::Order(order)) => lists::order(order, field),
        Some(Kind::Winding(winding)) => {
            if let Some(Around::Collider(collider)) = winding.around {
                known(collider, colliders, "collider", &field("winding.collider"))?;
            }
            lists::winding(winding, request.world.as_ref(), field)
        }
        Some(Kind::Coverage(coverage)) => {
            point_set(coverage.point_set, &field("coverage.point_set"))?;
            targets::check_fixed(coverage.points.as_ref(), &field("coverage.points"))?;
            within_range(Some(coverage.reach_m), &field("coverage.reach_m"), REACHES_M)
        }
    }
}

/// The points that a cost of this kind names, and of what they are.
fn named<'t>(
    nodes: Option<&'t Tensor>,
    skin_points: Option<&'t Tensor>,
    kind: &str,
    field: &impl Fn(&str) -> String,
) -> Result<(&'t Tensor, &'static str), Error> {
    let field = |set: &str| field(&format!("{kind}.{set}"));
    match (given(nodes), given(skin_points)) {
        (Some(_), Some(_)) => {
            let fault = "are given beside `nodes`: make two costs of them";
            Err(Error::field(field("skin_points"), fault))
        }
        (None, Some(points)) => {
            Ok((index_list(Some(points), &field("skin_points"))?, "skin points"))
        }
        (given, None) => Ok((index_list(given, &field("nodes"))?, "nodes")),
    }
}

/// The condition of success of a cost.
fn condition(cost: &Cost, field: &impl Fn(&str) -> String) -> Result<(), Error> {
    let Some(most) = cost.success_at_most else { return Ok(()) };
    let field = field("success_at_most");
    let measures = match &cost.kind {
        Some(Kind::Force(_)) => "forces over a frame",
        Some(Kind::Smoothness(_)) => "how positions change",
        Some(Kind::ControlPath(_) | Kind::ControlSpeed(_)) => "the motion of control points",
        _ if most.is_finite() && most >= 0.0 => return Ok(()),
        _ => {
            let fault = format!("is {most}: it must be finite and not negative, as the cost is");
            return Err(Error::field(field, fault));
        }
    };
    let fault = format!(
        "is not for this cost, which measures {measures}: give conditions of the state after the last frame, such as keypoints, within or coverage"
    );
    Err(Error::field(field, fault))
}

fn force(
    force: &bendtwin_proto::v1::cost::Force,
    grasps: usize,
    colliders: usize,
    field: &impl Fn(&str) -> String,
) -> Result<(), Error> {
    match force.by {
        None => {
            let fault = "is missing: give controls, control, grasp, ground or collider";
            return Err(Error::field(field("force.by"), fault));
        }
        Some(By::Grasp(grasp)) => known(grasp, grasps, "grasp", &field("force.grasp"))?,
        Some(By::Collider(collider)) => {
            known(collider, colliders, "collider", &field("force.collider"))?;
        }
        // The twin tells how many control points there are.
        Some(By::Control(_) | By::Controls(force::All {}) | By::Ground(force::All {})) => {}
    }
    amount(force.limit_n, &field("force.limit_n"))
}

/// Refuses the number of a part that the request does not have.
fn known(number: u32, count: usize, what: &str, field: &str) -> Result<(), Error> {
    if (number as usize) < count {
        return Ok(());
    }
    let fault = format!("names {what} {number}, the request has {count} (counted from 0)");
    Err(Error::field(field, fault))
}

/// Refuses what is negative, or not finite in single precision.
fn amount(value: f64, field: &str) -> Result<(), Error> {
    if value >= 0.0 && (value as f32).is_finite() {
        return Ok(());
    }
    let fault = format!("is {value}: it must be finite in single precision and not negative");
    Err(Error::field(field, fault))
}

/// A list of nodes that may be left out.
fn some_nodes(nodes: Option<&Tensor>, field: &str) -> Result<(), Error> {
    match given(nodes) {
        Some(nodes) => index_list(Some(nodes), field).map(drop),
        None => Ok(()),
    }
}

/// Number of times that a cost is measured: in the frames in which it counts, and for its condition of
/// success.
fn evaluations(cost: &Cost, batch: &Batch) -> u128 {
    let frames = match (&cost.kind, cost.when()) {
        (Some(Kind::ControlPath(_) | Kind::ControlSpeed(_)), _)
        | (_, When::EveryFrame | When::SoftMin) => u128::from(batch.frames),
        _ => 1,
    };
    frames + u128::from(cost.success_at_most.is_some())
}

#[cfg(test)]
mod tests;
