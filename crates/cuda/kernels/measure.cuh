// Forces: the impulses by what surrounds an object, found substep by substep (`force.cuh`), added up
// at a frame's end in a fixed order and divided by its length.

#if FORCES
// Adds the impulse that makes a node move with `held` in spite of `force`.
DEVICE void measure_held(
    const InstanceArgs& instance, const Constants& c, const ThreadNode& p, const NodeHolds& holds,
    u32 m, State s, float3 held, float3 force, const Moment& at
) {
    if (!instance.world.impulses || !p.valid || p.lane != 0) return;
    u32 kind = IMPULSE_CONTROL, body;
    if (is_pinned(p, holds, m)) {
        body = body_of_control(instance, instance.topology.pins[p.pin].control);
#if GRASPS
    } else if (holds.of[m].by == BY_PIN) {
        kind = IMPULSE_HOLD;
        body = instance.world.grasps[holds.of[m].grasp].body;
#endif
    } else {
        return;
    }
    float mass = instance.topology.masses[p.at];
    float3 free = add_scaled(scale(add(s.v, c.kick), mass), c.dt, force);
    float3 by = add_scaled(scale(held, mass), -c.decay, free);
    add_node_impulse(instance, frame_of(instance, at.frame), p.at, kind, body, s.x, by);
}

// Adds what control points exert through springs and triplets on the block's nodes.
DEVICE void measure_controls(
    const BlockState& l, const Constants& c, u32 now, const Pairs& pairs, const Bends& bends,
    const u32* refs, const Moment& at
) {
    if (!l.instance->world.impulses) return;
    const u32* rows = l.instance->topology.rows + l.share.row;
    const float4* xs[INSTANCES];
    const float2* vs[INSTANCES];
    for (u32 m = 0; m < INSTANCES; m++) {
        xs[m] = opaque_shared(l.xs(now, m));
        vs[m] = opaque_shared(l.vs(now, m));
    }
    for (u32 row = threadIdx.x / 32; row < l.share.control_rows; row += WARPS) {
        u32 control = row * NODES_A_ROW + threadIdx.x % 32 / LANES;
        bool valid = control < l.controls;
        u32 start = rows[l.share.rows + row], end = rows[l.share.rows + row + 1];
        State s[INSTANCES];
        float3 force[INSTANCES];
        for (u32 m = 0; m < INSTANCES; m++) {
            s[m] = l.state(now, m, l.control_base + (valid ? control : 0));
            force[m] = zero3();
        }
        u32 first = (start - rows[0]) * 32 + threadIdx.x % 32;
        for (u32 k = 0; k < end - start; k++)
            spring_forces(c, xs, vs, load_pair(pairs, first + k * 32), s, force);
        for (u32 m = 0; m < INSTANCES; m++) {
            const InstanceArgs& instance = l.instance[m];
            float3 sum = force[m];
            for_control_arms(l, row, refs, [&](u32 ref) { sum = add(sum, bends.load(ref, m)); });
            sum = sum_lanes(sum);
            if (!valid || threadIdx.x % LANES != 0 || !instance.world.impulses) continue;
            float* to = instance.world.control_impulses + (u64)l.rank * 6 * l.controls + control;
            u32 frame = frame_of(instance, at.frame), body = body_of_control(instance, control);
            float3 arm = sub(s[m].x, origin_of(instance, frame, body));
            add_wrench(to, l.controls, arm, scale(sum, -c.dt));
        }
    }
}

// Adds the impulse that gives a held node its velocity where a frame begins.
DEVICE void measure_jump(
    const BlockState& l, u32 m, u32 now, u32 local, u32 kind, u32 body, u32 frame, float3 x, float3 v
) {
    const InstanceArgs& instance = l.instance[m];
    if (!instance.world.impulses || local >= l.share.own) return;
    u32 node = l.graph_node(local), n = instance.topology.node_count;
    float3 arrives = l.state(now, m, local).v;
    if (frame == 0) {
        const float* v0 = instance.world.initial + 3 * (u64)n + node;
        arrives = v3(v0[0], v0[n], v0[2 * (u64)n]);
    }
    float3 by = scale(sub(v, arrives), instance.topology.masses[node]);
    add_node_impulse(instance, frame, node, kind, body, x, by);
}

// Sum over nodes that `counts` of a wrench's components, and what control points add.
template <class Counts, class Controls>
DEVICE void sum_wrench(
    const InstanceArgs& instance, u32 components, u32 kind, float* out, Counts counts,
    Controls controls
) {
    const u32 n = instance.topology.node_count, c = instance.topology.control_count;
    const u32 lane = threadIdx.x % 32;
    const float* from = instance.world.impulses + (u64)kind * n;
    float sum[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    for (u32 node = lane; node < n; node += 32) {
        if (!counts(node)) continue;
        for (u32 k = 0; k < components; k++) sum[k] += __ldcg(from + (u64)k * n + node);
    }
    for (u32 i = lane; i < c * BLOCKS; i += 32) {
        u32 control = i % c;
        if (!controls(control)) continue;
        const float* own = instance.world.control_impulses + (u64)(i / c) * 6 * c + control;
        for (u32 k = 0; k < components; k++) sum[k] += __ldcg(own + (u64)k * c);
    }
    for (u32 k = 0; k < components; k++) {
        float total = sum_warp(sum[k]);
        if (lane == 0) out[k] = total / instance.step.frame_s;
    }
}

// Forces of a frame.
DEVICE void sum_forces(const InstanceArgs& instance, u32 frame) {
    const WorldArgs& w = instance.world;
    const u32 c = instance.topology.control_count;
    const u32 g = w.grasp_count, colliders = w.collider_count;
    const int* pin_of = instance.topology.pin_of;
    const Pin* pins = instance.topology.pins;
    const Hold* holds = g ? holds_of(instance, frame) : 0;
    float* out = w.forces + (u64)frame * (6 * (c + g + colliders) + 3);
    auto none = [](u32) { return false; };
    for (u32 k = threadIdx.x / 32; k < c + g + 1 + colliders; k += THREADS / 32) {
        if (k < c) {
            sum_wrench(
                instance, 6, IMPULSE_CONTROL, out + 6 * k,
                [&](u32 node) { return pin_of[node] >= 0 && pins[pin_of[node]].control == k; },
                [&](u32 control) { return control == k; }
            );
        } else if (k < c + g) {
            int grasp = (int)(k - c);
            if (w.grasps[grasp].region == REGION_CONTROLS) {
                auto has = [&](u32 control) { return w.grasp_of[control] == grasp; };
                sum_wrench(
                    instance, 6, IMPULSE_CONTROL, out + 6 * k,
                    [&](u32 node) { return pin_of[node] >= 0 && has(pins[pin_of[node]].control); },
                    has
                );
            } else {
                sum_wrench(
                    instance, 6, IMPULSE_HOLD, out + 6 * k,
                    [&](u32 node) { return holds[node].grasp == grasp; }, none
                );
            }
        } else if (k == c + g) {
            auto all = [](u32) { return true; };
            sum_wrench(instance, 3, IMPULSE_GROUND, out + 6 * k, all, none);
        } else {
            u32 collider = k - c - g - 1;
            auto all = [](u32) { return true; };
            sum_wrench(
                instance, 6, IMPULSES + 6 * collider, out + 6 * (c + g + collider) + 3, all, none
            );
        }
    }
}

// Clears the impulses of the block's own nodes, and those of control points on them.
DEVICE void clear_impulses(const BlockState& l, const InstanceArgs& instance) {
    const u32 n = instance.topology.node_count;
    const u32 kinds = IMPULSES + 6 * instance.world.collider_count;
    for (u32 i = threadIdx.x; i < l.share.own; i += THREADS) {
        u32 node = l.graph_node(i);
        for (u32 k = 0; k < kinds; k++) instance.world.impulses[(u64)k * n + node] = 0.0f;
    }
    for (u32 i = threadIdx.x; i < 6 * l.controls; i += THREADS)
        instance.world.control_impulses[(u64)l.rank * 6 * l.controls + i] = 0.0f;
}

DEVICE bool measures(const InstanceArgs& instance, u32 frame) {
    return instance.world.impulses && frame < instance.state.frame_count;
}

// Ends a frame: what the team's blocks have measured becomes its forces.
DEVICE void end_measuring(BlockState& l, const InstanceArgs* instances, u32 frame) {
    synchronize_team(l.barrier, l.round);
    for (u32 m = 0; m < INSTANCES && l.rank == 0; m++)
        if (measures(instances[m], frame)) sum_forces(instances[m], frame);
    synchronize_team(l.barrier, l.round);
    for (u32 m = 0; m < INSTANCES; m++)
        if (measures(instances[m], frame)) clear_impulses(l, instances[m]);
    __syncthreads();
}

#if GRASPS
// Changes the grasps behind a frame, whose forces and states are stored: they may slip.
DEVICE void end_holds(BlockState& l, const InstanceArgs* instances, u32 frame) {
    synchronize_team(l.barrier, l.round);
    for (u32 m = 0; m < INSTANCES && l.rank == 0; m++)
        if (measures(instances[m], frame)) change_grasps_of(instances[m], frame + 1, frame + 2);
    synchronize_team(l.barrier, l.round);
}
#endif
#endif
