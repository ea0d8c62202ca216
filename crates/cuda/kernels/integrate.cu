// Frames forward: all substeps of all frames of a launch without leaving the kernel. For every
// substep: forces, velocities, contact between nodes, ground, pins, in the order of the model's
// definition.
//
// Instances come in groups of INSTANCES that share a graph and its parameters, so that a
// half-spring is loaded once for all of them. The lanes of a node sum their forces by shuffles in a
// fixed order, and all of them then know the node's new state.

// Velocity of a node before contact.
DEVICE float3 accelerate(const Constants& c, float inverse_mass, float3 force, float3 v) {
    float3 change = add_scaled(c.kick, inverse_mass * c.dt, force);
    return scale(add(v, change), c.decay);
}

// Puts a node's velocity before contact onto tape.
DEVICE void record_velocity(const BlockState& l, const ThreadNode& p, u32 tape, float3 before) {
    u64 at = (u64)tape * l.instance->topology.node_count + l.share.slot + p.node;
    float* b = l.instance->tape.before + 3 * at;
    b[0] = before.x;
    b[1] = before.y;
    b[2] = before.z;
}

// Ends a node's substep: from its velocity after contact to its new state, published to all blocks.
DEVICE void finish_substep(
    const BlockState& l, const Constants& c, const ThreadNode& p, const NodeHolds& holds, u32 m,
    u32 now, State s, float3 before, float3 after, const Moment& at
) {
    u32 tape = at.tape;
#if TAPE
    if (p.lane == 0 && tape != NO_TAPE) {
        const InstanceArgs& instance = *l.instance;
        // Nodes of a row in adjacent entries: scattered, they would cost more than the rest of the
        // tape.
        u64 at = (u64)tape * instance.topology.node_count + l.share.slot + p.node;
        instance.tape.x[at] = with_w(s.x, s.v.x);
        instance.tape.v[at] = make_float2(s.v.y, s.v.z);
        // With contact and forces it has been applied already.
        if (!(CONTACT && FORCES) || inverse_mass_of(p, holds, m) != 0.0f)
            record_velocity(l, p, tape, before);
    }
#endif
    float3 x, v = after;
    if (is_pinned(p, holds, m)) {
        State held = l.state(now, m, p.pin_control);
        x = add(held.x, p.pin_offset);
        v = held.v;
#if GRASPS
    } else if (holds.of[m].by == BY_PIN) {
        x = place_at(holds.of[m], progress(at.substep, at.substeps));
        v = holds.of[m].velocity;
#endif
    } else {
        travel(l.instance[m], c, p, at, s, x, v);
    }
    publish_state(l, p, now ^ 1, m, x, v);
}

#if GRASPS
// Force of a spring between a node and a body.
DEVICE float3 hold_force(const InstanceArgs& instance, const ThreadNode& p, const Held& h, State s,
                         const Moment& at) {
    float3 place = place_at(h, progress(at.substep, at.substeps));
    float3 force = scale(sub(s.x, place), -h.stiffness);
    force = add_scaled(force, -h.damping, sub(s.v, h.velocity));
#if FORCES
    if (instance.world.impulses && p.valid && p.lane == 0)
        add_node_impulse(
            instance, frame_of(instance, at.frame), p.at, IMPULSE_HOLD,
            instance.world.grasps[h.grasp].body, s.x, scale(force, instance.step.dt)
        );
#endif
    return force;
}
#endif

// The half-springs of the one row that a warp has, in registers.
struct HeldPairs {
#if HELD > 0
    Pair pairs[HELD];
#endif
};

DEVICE void integrate_node(
    const BlockState& l, const Constants& c, const ThreadNode& p, const NodeHolds& holds,
    const HeldPairs& held, u32 now, const Moment& at, const Pairs& pairs, const Bends& bends,
    const u32* refs
) {
    State s[INSTANCES];
    float3 force[INSTANCES];
    const float4* xs[INSTANCES];
    const float2* vs[INSTANCES];
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++) {
        s[m] = l.state(now, m, p.node);
        force[m] = zero3();
        xs[m] = opaque_shared(l.xs(now, m));
        vs[m] = opaque_shared(l.vs(now, m));
    }
#if HELD > 0
    // Pairs that all rows have need no test.
#pragma unroll
    for (u32 k = 0; k < HELD; k++) {
        if (k < HELD_ALWAYS || k < p.pairs) spring_forces(c, xs, vs, held.pairs[k], s, force);
    }
#endif
    Pairs rest = pairs_from(pairs, p.first + HELD * 32);
#pragma unroll 2
    for (u32 k = HELD; k < p.pairs; k++, next_pair(rest))
        spring_forces(c, xs, vs, load_pair(rest, 0), s, force);
#if ONE_ROW
    synchronize_bends();
#endif
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++) {
        float3 total = sum_lanes(add(force[m], bend_share(p, bends, refs, m)));
        float inverse_mass = inverse_mass_of(p, holds, m);
#if GRASPS
        if (holds.of[m].by == BY_SPRING)
            total = add(total, hold_force(l.instance[m], p, holds.of[m], s[m], at));
#endif
        float3 before = accelerate(c, inverse_mass, total, s[m].v);
        if (is_pinned(p, holds, m)) before = l.state(now, m, p.pin_control).v;
#if GRASPS
        if (holds.of[m].by == BY_PIN) before = holds.of[m].velocity;
#endif
        float3 recorded = before;
#if FORCES
        measure_held(l.instance[m], c, p, holds, m, s[m], before, total, at);
        // What a held node would do if it were not: what holds it makes up for that.
        if (p.valid)
            recorded = accelerate(c, 1.0f / l.instance->topology.masses[p.at], total, s[m].v);
#if CONTACT && TAPE
        if (inverse_mass == 0.0f && p.valid && p.lane == 0 && at.tape != NO_TAPE)
            record_velocity(l, p, at.tape, recorded);
#endif
#endif
#if CONTACT
        if (p.valid && p.lane == 0) {
            __stcg(l.instance->contact.x + p.at, with_w(s[m].x, inverse_mass));
            __stcg(l.instance->contact.v + p.at, with_w(before, 0.0f));
            __stcg(l.instance->contact.start + p.at, with_w(s[m].v, 0.0f));
        }
#else
        if (p.valid) finish_substep(l, c, p, holds, m, now, s[m], recorded, before, at);
#endif
    }
}

DEVICE void resolve_contact(
    const BlockState& l, const Constants& c, const ThreadNode& p, const NodeHolds& holds, u32 now,
    const Moment& at
) {
    const InstanceArgs& instance = *l.instance;
    float contact_count;
    CurrentNodes nodes = {instance.contact.x, instance.contact.v, instance.contact.start};
    float3 after = collide(instance, nodes, p.at, p.valid, p.lane, contact_count);
    float3 before = xyz(__ldcg(instance.contact.v + p.at));
    if (p.valid)
        finish_substep(l, c, p, holds, 0, now, l.state(now, 0, p.node), before, after, at);
}

// The path of the control point that a thread moves, held in registers. The last threads do it:
// their rows are the shortest.
struct ControlPath {
    float3 from[INSTANCES], to[INSTANCES];
    float3 velocity[INSTANCES];
    u32 control;
    u32 substeps;
};

DEVICE ControlPath control_path_of(const BlockState& l, const InstanceArgs* instances, u32 frame) {
    ControlPath w;
    w.control = THREADS - 1 - threadIdx.x;
    w.substeps = instances->step.substeps;
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++) {
        w.from[m] = w.to[m] = w.velocity[m] = zero3();
        if (w.control < l.controls) {
            Path path = path_of(instances[m], frame_of(instances[m], frame));
            w.from[m] = load_v3(path.from + 3 * w.control);
            w.to[m] = load_v3(path.to + 3 * w.control);
            w.velocity[m] = control_velocity(path, w.control);
#if GRASPS
            if (is_released(instances[m], frame_of(instances[m], frame), w.control)) {
                w.from[m] = w.to[m] = v3(FAR_M, FAR_M, FAR_M);
                w.velocity[m] = zero3();
            }
#endif
        }
    }
    return w;
}

// Puts the control points where a substep's forces see them.
DEVICE void place_controls(
    const BlockState& l, const InstanceArgs* instances, const ControlPath& w, u32 buffer, u32 frame,
    u32 substep
) {
    if (w.control >= l.controls) return;
    float t = progress(substep, w.substeps);
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++) {
        float3 at = add_scaled(scale(w.from[m], 1.0f - t), t, w.to[m]);
        l.put(buffer, m, l.control_base + w.control, at, w.velocity[m]);
        for (u32 c = w.control + THREADS; c < l.controls; c += THREADS) {
            put_control(l, instances[m], buffer, m, c, frame_of(instances[m], frame), t);
        }
    }
}

// Held nodes stand at the frame's start with its velocity, wherever they are known.
DEVICE void begin_frame(const BlockState& l, const InstanceArgs* instances, u32 now, u32 frame) {
    const TopologyArgs& t = l.instance->topology;
    for (u32 m = 0; m < INSTANCES; m++) {
        Path path = path_of(instances[m], frame_of(instances[m], frame));
        for (u32 i = threadIdx.x; i < l.share.pins; i += THREADS) {
            LocalPin local = t.local_pins[l.share.pin + i];
            Pin pin = t.pins[local.pin];
#if GRASPS
            if (is_released(instances[m], frame_of(instances[m], frame), pin.control)) continue;
#endif
            float3 held = load_v3(path.from + 3 * pin.control);
            float3 x = add(held, load_v3(pin.offset)), v = control_velocity(path, pin.control);
#if FORCES
            measure_jump(
                l, m, now, local.local, IMPULSE_CONTROL, body_of_control(instances[m], pin.control),
                frame_of(instances[m], frame), x, v
            );
#endif
            l.put(now, m, local.local, x, v);
        }
#if GRASPS
        u32 of = frame_of(instances[m], frame);
        const Hold* holds = holds_of(instances[m], of);
        for (u32 i = threadIdx.x; i < l.share.local; i += THREADS) {
            const Hold hold = load_hold(holds + l.graph_node(i));
            if (hold.grasp < 0) continue;
            const Grasp& grasp = instances[m].world.grasps[hold.grasp];
            if (grasp.attachment != HOLD_PIN) continue;
            BodyFrame body = body_of(instances[m], of, grasp.body);
            float3 place = load_v3(hold.place), x = apply(body.from, place), v = zero3();
            if (instances[m].step.controls_move) v = body_velocity(body, place);
#if FORCES
            measure_jump(l, m, now, i, IMPULSE_HOLD, grasp.body, of, x, v);
#endif
            l.put(now, m, i, x, v);
        }
#endif
    }
}

DEVICE void load_states(const BlockState& l, const InstanceArgs* instances, u32 now, u32 frame) {
    u32 n = l.instance->topology.node_count;
    for (u32 m = 0; m < INSTANCES; m++) {
        const float* s =
            instances[m].state.states +
            (u64)(frame_of(instances[m], frame) % instances[m].state.slot_count) * 6 * n;
        for (u32 i = threadIdx.x; i < l.share.local; i += THREADS) {
            u32 g = l.graph_node(i);
            l.put(now, m, i, v3(s[g], s[n + g], s[2 * n + g]),
                  v3(s[3 * n + g], s[4 * n + g], s[5 * n + g]));
        }
    }
    __syncthreads();
}

// Nodes farther out than that, or not finite, have diverged.
DEVICE bool inside(const State& s) {
    return fabsf(s.x.x) <= MAX_COORDINATE_M && fabsf(s.x.y) <= MAX_COORDINATE_M &&
           fabsf(s.x.z) <= MAX_COORDINATE_M && isfinite(s.v.x) && isfinite(s.v.y) &&
           isfinite(s.v.z);
}

DEVICE void store_states(const BlockState& l, const InstanceArgs* instances, u32 now, u32 frame) {
    u32 n = l.instance->topology.node_count;
    for (u32 m = 0; m < INSTANCES; m++) {
        const InstanceArgs& instance = instances[m];
        if (frame >= instance.state.frame_count) continue;
        u32 reached = instance.state.first_frame + frame + 1;
        float* to = instance.state.states + (u64)(reached % instance.state.slot_count) * 6 * n;
        for (u32 i = threadIdx.x; i < l.share.own; i += THREADS) {
            u32 g = l.graph_node(i);
            State s = l.state(now, m, i);
            to[g] = s.x.x;
            to[n + g] = s.x.y;
            to[2 * n + g] = s.x.z;
            to[3 * n + g] = s.v.x;
            to[4 * n + g] = s.v.y;
            to[5 * n + g] = s.v.z;
            if (!inside(s)) atomicMin(instance.state.divergence, (u64)reached << 32 | g);
        }
    }
    __syncthreads();
}

DEVICE u32 longest(const InstanceArgs* instances) {
    u32 longest = 0;
    for (u32 m = 0; m < INSTANCES; m++) longest = max(longest, instances[m].state.frame_count);
    return longest;
}

struct AdvanceFramesArgs {
    const InstanceArgs* instances;
    u32 first, end;  // frames
    u32 from, to;    // substeps that go onto tape
    u32 keep;        // whether frames store the states that they end in
    u32 pad;
};

// Runs frames `first..end` of each instance. With TAPE, each only as far as substep `to`, and what
// happens from `from` on goes onto tape, frame after frame.
extern "C" __global__ void __launch_bounds__(THREADS)
advance_frames(const __grid_constant__ AdvanceFramesArgs args) {
    const u32 first = args.first, end = args.end, from = args.from, to = args.to, keep = args.keep;
    const InstanceArgs* instances = args.instances + (u64)(blockIdx.x / BLOCKS) * INSTANCES;
    BlockState l = block_state_of(instances, blockIdx.x % BLOCKS, sizeof(float4) + sizeof(float2));
    // Where forces are measured those of control points are too.
    u32 rows = l.share.rows + (FORCES ? l.share.control_rows : 0);
    Pairs pairs = pairs_of(l, rows, l.after_states(0));
    Constants c = constants_of(*instances);
    Bends bends = bends_of(l);
    const u32* refs = instances->topology.arm_refs;
    HeldTriplet triplet = triplet_at(l, first_triplet());
#if RODS
    HeldRod rod = rod_at(l, threadIdx.x / 32);
    load_twists(instances, first);
#endif
    Halo halo = halo_of(l);
    u32 now = 0;
    load_states(l, instances, now, first);
    HeldPairs held;
#if ONE_ROW
    ThreadNode p = thread_node_of(l, threadIdx.x / 32);
#if HELD > 0
#pragma unroll
    for (u32 k = 0; k < HELD; k++)
        held.pairs[k] = k < p.pairs ? load_pair(pairs, p.first + k * 32) : no_pair(p.node);
#endif
#endif
    // A cluster's blocks must all have started before one writes into another.
    synchronize_team(l.barrier, l.round);
    u32 last_frame = min(end, longest(instances));
    for (u32 frame = first; frame < last_frame; frame++) {
        ControlPath path = control_path_of(l, instances, frame);
#if RODS
        begin_twists(instances, frame);
#endif
        begin_frame(l, instances, now, frame);
        place_controls(l, instances, path, now, frame, 0);
#if ONE_ROW
        NodeHolds holds = node_holds_of(p, instances, frame);
#endif
        __syncthreads();
        u32 last = TAPE ? min(to, path.substeps) : path.substeps;
        for (u32 s = 0; s < last; s++) {
            u32 tape = s >= from ? frame * (last - from) + s - from : NO_TAPE;
            Moment at = {frame, s, path.substeps, tape};
            expect_halo(l.arrivals, now ^ 1);
            place_controls(l, instances, path, now ^ 1, frame, s + 1);
#if RODS
            rod_forces(l, c, instances, frame, now, bends, rod, tape);
#endif
            bend_forces(l, now, bends, triplet);
#if ONE_ROW
            integrate_node(l, c, p, holds, held, now, at, pairs, bends, refs);
#else
            for (u32 row = threadIdx.x / 32; row < l.share.rows; row += WARPS) {
                ThreadNode p = thread_node_of(l, row);
                NodeHolds holds = node_holds_of(p, instances, frame);
                integrate_node(l, c, p, holds, held, now, at, pairs, bends, refs);
            }
#endif
#if FORCES
            measure_controls(l, c, now, pairs, bends, refs, at);
#endif
#if CONTACT
            synchronize_team(l.barrier, l.round);
#if ONE_ROW
            resolve_contact(l, c, p, holds, now, at);
#else
            for (u32 row = threadIdx.x / 32; row < l.share.rows; row += WARPS) {
                ThreadNode p = thread_node_of(l, row);
                resolve_contact(l, c, p, node_holds_of(p, instances, frame), now, at);
            }
#endif
#endif
            now ^= 1;
            synchronize_halo(l.arrivals, now, l.barrier, l.round);
            fetch_states(l, halo, now);
        }
#if FORCES
        end_measuring(l, instances, frame);
#endif
#if RODS
        if (keep) store_twists(instances, frame);
#endif
        if (keep) store_states(l, instances, now, frame);
#if GRASPS && FORCES
        if (keep) end_holds(l, instances, frame);
#endif
    }
    // None may end while another still writes into it.
    synchronize_team(l.barrier, l.round);
}
