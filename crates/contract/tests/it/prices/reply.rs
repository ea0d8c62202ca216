//! The formula beside the encoding of a reply with all that was asked for.

use bendtwin_contract::rollout::{
    Batch, ImplausibleReason, TwinShape, has_gradients, part_frames, reply_bytes,
};
use bendtwin_proto::v1::{
    ControlTrajectories, Cost, Fidelity, Grasp, Grasping, Plausibility, PointSet, Returns,
    RollOutRequest, RollOutResponse, Tensor,
    returns::Encoding,
    roll_out_request::Actions,
    roll_out_response::{Deviation, Diagnostics, Divergence, Implausible, Timing, Window},
};
use proptest::prelude::*;
use prost::Message as _;

/// What an instance of a batch can do that is not plausible.
fn implausible(request: &RollOutRequest, batch: &Batch) -> Vec<Implausible> {
    let (instance, last) = ((batch.instances - 1) as u32, batch.frames as u32);
    let limits = request.plausibility.unwrap_or_default();
    let each = ImplausibleReason::ALL.into_iter().flat_map(|reason| {
        let frame = if reason.names_frame() { last } else { 0 };
        let grasps: Vec<Option<u32>> = match reason {
            ImplausibleReason::GraspForce if limits.grasp_force_n.is_none() => Vec::new(),
            ImplausibleReason::GraspForce => (0..request.grasps.len() as u32).map(Some).collect(),
            _ => vec![None],
        };
        let reason = reason.as_str().to_owned();
        grasps.into_iter().map(move |grasp| {
            let reason = reason.clone();
            Implausible { instance, reason, found: 1.0, limit: 1.0, frame, grasp }
        })
    });
    each.collect()
}

/// The reply of a worker in which every number takes as many bytes as it can.
fn reply(
    request: &RollOutRequest,
    batch: &Batch,
    twin: &TwinShape,
    covered: u64,
) -> RollOutResponse {
    let returns = request.returns.clone().unwrap_or_default();
    let (n, terms) = (covered as usize, request.costs.len());
    let tensor = |shape: &[u64], width: usize| Tensor {
        dtype: 1,
        shape: shape.to_vec(),
        data: vec![0; width * shape.iter().product::<u64>() as usize].into(),
        ..Tensor::default()
    };
    let mut reply = RollOutResponse {
        first_instance: u32::MAX,
        costs: Some(Tensor::pack(&[n], &vec![0.0f64; n])),
        cost_names: (0..terms).map(|i| format!("cost{i}")).collect(),
        cost_terms: Some(Tensor::pack(&[n, terms], &vec![0.0f64; n * terms])),
        diverged: vec![Divergence { instance: u32::MAX, frame: u32::MAX, node: u32::MAX }; n],
        implausible: (0..n).flat_map(|_| implausible(request, batch)).collect(),
        timing: Some(Timing { queue_s: 1.0, compute_s: 1.0 }),
        worker: format!("workers/{}", "0".repeat(36)),
        fidelity: Fidelity::Fast.into(),
        substeps: u32::MAX,
        mass_kg: Some(1.0),
        deviation: Some(Deviation {
            mean_m: 1.0,
            max_m: 1.0,
            mean_travel_m: 1.0,
            frames: u32::MAX,
        }),
        ..RollOutResponse::default()
    };
    if request.time_limit_s.is_some() {
        reply.unfinished = Some(tensor(&[covered], 4));
    }
    if returns.part_frames > 0 {
        reply.window = Some(Window { first_frame: u32::MAX, last_frame: u32::MAX });
    }
    if returns.diagnostics {
        let most = Diagnostics {
            max_strain: 1.0,
            max_speed_m_s: 1.0,
            kinetic_energy: 1.0,
            elastic_energy: 1.0,
            ground_contacts: u32::MAX,
            max_control_strain: 1.0,
            control_depth_m: 1.0,
            stopped_hand_m: 1.0,
        };
        reply.diagnostics = vec![most; n];
    }
    let holders = if returns.best == 0 { covered } else { u64::from(returns.best).min(covered) };
    let has_arrays = returns.every_frames > 0
        || returns.final_state
        || returns.frame_costs
        || returns.controls
        || has_gradients(&returns);
    if has_arrays || returns.best > 0 {
        reply.instances = Some(tensor(&[holders], 4));
    }
    if returns.every_frames > 0 {
        let rows = part_frames(request, batch) / u64::from(returns.every_frames);
        let (chosen, all) = match returns.point_set() {
            PointSet::Skin => (&returns.skin_points, twin.skin_points.unwrap_or(twin.nodes)),
            _ => (&returns.nodes, twin.nodes),
        };
        let points = chosen.as_ref().map_or(all, |t| t.shape[0]);
        reply.frames = Some(tensor(&[rows], 4));
        let is_packed = returns.encoding() == Encoding::Int16;
        let positions = tensor(&[holders, rows, points, 3], if is_packed { 2 } else { 4 });
        let scale = if is_packed { 1.0 } else { 0.0 };
        reply.positions = Some(Tensor { scale, offset: scale, ..positions });
        reply.velocities = returns.velocities.then(|| reply.positions.clone()).flatten();
    }
    let boundaries = part_frames(request, batch) + 1;
    if returns.frame_costs {
        reply.frame_costs = Some(tensor(&[holders, boundaries, terms as u64], 8));
    }
    if returns.controls {
        reply.controls = Some(tensor(&[holders, boundaries, twin.controls, 3], 4));
    }
    if returns.initial_gradients {
        reply.initial_position_gradients = Some(tensor(&[holders, twin.nodes, 3], 4));
        reply.initial_velocity_gradients = reply.initial_position_gradients.clone();
    }
    if returns.gradient_norms {
        reply.gradient_norms = Some(tensor(&[holders, boundaries], 8));
    }
    if has_gradients(&returns) {
        reply.gradient_exploded = Some(tensor(&[holders], 4));
    }
    if returns.final_state {
        reply.final_positions = Some(tensor(&[holders, twin.nodes, 3], 4));
        reply.final_velocities = reply.final_positions.clone();
        reply.final_twists = twin.rods.map(|rods| tensor(&[holders, rods], 4));
        reply.final_controls = Some(tensor(&[holders, twin.controls, 3], 4));
        if matches!(request.actions, Some(Actions::Poses(_))) {
            reply.final_commanded_controls.clone_from(&reply.final_controls);
        }
        let grasps = request.grasps.len() as u64;
        reply.final_grasping = (grasps > 0).then(|| Grasping {
            phases: Some(tensor(&[holders, grasps], 4)),
            holders: Some(tensor(&[holders, twin.nodes], 4)),
            places: Some(tensor(&[holders, twin.nodes, 3], 4)),
        });
    }
    if returns.action_gradients {
        reply.action_gradients = Some(tensor(&[holders, batch.knots, twin.controls, 3], 4));
    }
    if returns.control_gradients {
        let shape = [holders, boundaries, twin.controls, 3];
        reply.control_gradients = Some(tensor(&shape, 4));
    }
    reply
}

proptest! {
    #[test]
    fn no_reply_is_larger_and_only_constants_are_smaller(
        (instances, frames, part) in (1u64..400, 1u64..40, 0u32..30),
        (nodes, controls, rods) in (1u64..200, 1u64..5, prop::option::of(1u64..3)),
        (every_frames, best, chosen) in (0u32..9, 0u32..5, prop::option::of(1usize..9)),
        (point_set, skin_points) in (0i32..3, prop::option::of(1u64..500)),
        (encoding, terms, grasps) in (0i32..3, 0usize..20, 0usize..3),
        (part_frames, time_limit_s) in (0u32..9, prop::option::of(0.1f64..1.0)),
        flags in any::<[bool; 11]>(),
    ) {
        let part = if best > 0 { 0 } else { part };
        let list = |n: usize| Tensor::pack(&[n], &vec![0u32; n]);
        let returns = Returns {
            every_frames,
            best,
            encoding,
            point_set,
            nodes: chosen.filter(|_| point_set != PointSet::Skin as i32).map(list),
            skin_points: chosen.filter(|_| point_set == PointSet::Skin as i32).map(list),
            final_state: flags[0],
            diagnostics: flags[1],
            control_gradients: flags[2],
            action_gradients: flags[4],
            velocities: flags[5],
            frame_costs: flags[6],
            controls: flags[7],
            initial_gradients: flags[8],
            gradient_norms: flags[9],
            part_frames,
            ..Returns::default()
        };
        let shape = [instances as usize, 2, controls as usize];
        let positions = Tensor::pack_points(&shape, &vec![[0.0; 3]; shape.iter().product()]);
        let trajectories = ControlTrajectories { positions: Some(positions), interpolation: 0 };
        let limits = Plausibility { grasp_force_n: Some(1.0), ..Plausibility::default() };
        let request = RollOutRequest {
            actions: Some(Actions::Trajectories(trajectories)),
            grasps: vec![Grasp::default(); grasps],
            costs: vec![Cost::default(); terms],
            returns: flags[3].then_some(returns),
            plausibility: flags[10].then_some(limits),
            time_limit_s,
            ..RollOutRequest::default()
        };
        let batch = Batch { instances, knots: 2, frames };
        let twin = TwinShape { nodes, controls, rods, skin_points, ..TwinShape::default() };
        let covered = if part == 0 { instances } else { instances.min(u64::from(part)) };
        let encoded = reply(&request, &batch, &twin, covered).encoded_len() as u64;
        let bound = reply_bytes(&request, &batch, &twin, part);
        prop_assert!((encoded..=encoded + 64).contains(&bound), "{bound} for {encoded}");
    }
}

#[test]
fn absurd_sizes_stay_at_the_largest_number() {
    let returns = Some(Returns { every_frames: 1, ..Returns::default() });
    let request = RollOutRequest { returns, ..RollOutRequest::default() };
    let batch = Batch { instances: u64::MAX, knots: 2, frames: u64::MAX };
    let twin = TwinShape { nodes: u64::MAX, ..TwinShape::default() };
    assert_eq!(reply_bytes(&request, &batch, &twin, 0), u64::MAX);
}
