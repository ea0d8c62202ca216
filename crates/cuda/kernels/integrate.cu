// Frames forward: all substeps of all frames of a launch without leaving the kernel. For every
// substep: forces, velocities, contact between nodes, ground, pins, in the order of the model's
// definition.
//
// Instances come in groups of INSTANCES that share a graph and its parameters, so that a
// half-spring is loaded once for all of them. The lanes of a node sum their forces by shuffles in a
// fixed order, and all of them then know the node's new state.

// Values of all substeps, kept in registers.
struct Constants {
    float3 kick;
    float dt, decay;
    Ground ground;
    Law law;
    float dashpot;
};

DEVICE Constants constants_of(const InstanceArgs& instance) {
    Constants c;
    c.kick = load_v3(instance.step.kick);
    c.dt = instance.step.dt;
    c.decay = instance.parameters.decay;
    c.ground = instance.step.ground;
    c.law = instance.parameters.ground_law;
    c.dashpot = instance.parameters.dashpot;
    return c;
}

#define NO_TAPE 0xffffffffu

// A frame of an instance; one that has ended stays in its last.
DEVICE u32 frame_of(const InstanceArgs& instance, u32 frame) {
    return instance.state.first_frame + min(frame, max(instance.state.frame_count, 1u) - 1);
}

// Forces of the ends i and k, by triplet and instance.
DEVICE float3* bend_buffer(const BlockState& l) {
    u32 before = HALF_SPRINGS_IN_SHARED ? pairs_size(l.instance->topology.max_pairs) : 0;
    return reinterpret_cast<float3*>(BEND_IN_SHARED ? l.after_states(before) : l.spill());
}

DEVICE void bend_one(const BlockState& l, u32 now, float3* forces, u32 t, const HeldTriplet& h) {
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++) {
        State i = l.state(now, m, h.ends.i), j = l.state(now, m, h.ends.j);
        State k = l.state(now, m, h.ends.k);
        float3 f_i, f_k;
        bend_force(h.params, sub(i.x, j.x), sub(k.x, j.x), sub(i.v, j.v), sub(k.v, j.v), f_i, f_k);
        forces[(t * INSTANCES + m) * 2] = f_i;
        forces[(t * INSTANCES + m) * 2 + 1] = f_k;
    }
}

#if RODS
// Moves the rods' twists and leaves what their inner nodes exert on their neighbours where triplets
// leave theirs.
DEVICE void rod_forces(
    const BlockState& l, const Constants& c, const InstanceArgs* instances, u32 now, float3* forces,
    const HeldRod& first, u32 tape
) {
    for_rods(l, first, [&](u32 r, const HeldRod& h) {
        for (u32 m = 0; m < INSTANCES; m++) {
            u32 lane = threadIdx.x % 32;
            float rate = 0.0f;
            for (u32 t = h.first + lane; t < h.end; t += 32) {
                InnerNode in = inner_node_at(l, now, m, t);
                rate += along(in.turn, in.v_before, in.v_after);
            }
            rate = sum_warp(rate);
            float* kept = rod_twists() + m * RODS + r;
            float before = *kept;
            float twist = before + rate * c.dt;
            __syncwarp();
            if (lane == 0) {
                *kept = twist;
#if TAPE
                if (tape != NO_TAPE) instances[m].tape.twists[(u64)tape * RODS + r] = before;
#endif
            }
            float torque = h.stiffness * (twist - h.rest_twist) + h.damping * rate;
            for (u32 t = h.first + lane; t < h.end; t += 32) {
                Turn turn = inner_node_at(l, now, m, t).turn;
                forces[(t * INSTANCES + m) * 2] = scale(turn.a, -torque);
                forces[(t * INSTANCES + m) * 2 + 1] = scale(turn.c, -torque);
            }
            __syncwarp();
        }
    });
}

// Twists where a launch begins and where frames end, as states.
DEVICE void load_twists(const InstanceArgs* instances, u32 frame) {
    for (u32 i = threadIdx.x; i < RODS * INSTANCES; i += THREADS) {
        const InstanceArgs& instance = instances[i / RODS];
        u64 slot = frame_of(instance, frame) % instance.state.slot_count;
        rod_twists()[i] = instance.state.twists[slot * RODS + i % RODS];
    }
}

DEVICE void store_twists(const InstanceArgs* instances, u32 frame) {
    for (u32 i = threadIdx.x; i < RODS * INSTANCES; i += THREADS) {
        const InstanceArgs& instance = instances[i / RODS];
        if (frame >= instance.state.frame_count) continue;
        u32 reached = instance.state.first_frame + frame + 1;
        instance.state.twists[(u64)(reached % instance.state.slot_count) * RODS + i % RODS] =
            rod_twists()[i];
    }
}
#endif

DEVICE void bend_forces(const BlockState& l, u32 now, float3* forces, const HeldTriplet& first) {
#if BENDING
    if (first.has) bend_one(l, now, forces, first_triplet(), first);
    for (u32 t = first_triplet() + THREADS; t < l.share.triplets; t += THREADS)
        bend_one(l, now, forces, t, triplet_at(l, t));
#if !ONE_ROW
    synchronize_bends();
#endif
#endif
}

// A lane's part of the forces of its node's triplets.
DEVICE float3 bend_share(const ThreadNode& p, const float3* forces, const u32* refs, u32 m) {
    float3 sum = zero3();
#if BENDING
    for_arms(p, refs, [&](u32 triplet, u32 role) {
        const float3* f = forces + (triplet * INSTANCES + m) * 2;
        sum = role < 2 ? add(sum, f[role]) : sub(sum, add(f[0], f[1]));
    });
#endif
    return sum;
}

// Velocity of a node before contact.
DEVICE float3 accelerate(const Constants& c, float inverse_mass, float3 force, float3 v) {
    float3 change = add_scaled(c.kick, inverse_mass * c.dt, force);
    return scale(add(v, change), c.decay);
}

// Ends a node's substep: from its velocity after contact to its new state, published to all blocks.
DEVICE void finish_substep(
    const BlockState& l, const Constants& c, const ThreadNode& p, u32 m, u32 now, State s,
    float3 before, float3 after, u32 tape
) {
#if TAPE
    if (p.lane == 0 && tape != NO_TAPE) {
        const InstanceArgs& instance = *l.instance;
        // Nodes of a row in adjacent entries: scattered, they would cost more than the rest of the
        // tape.
        u64 at = (u64)tape * instance.topology.node_count + l.share.slot + p.node;
        instance.tape.x[at] = with_w(s.x, s.v.x);
        instance.tape.v[at] = make_float2(s.v.y, s.v.z);
        float* b = instance.tape.before + 3 * at;
        b[0] = before.x;
        b[1] = before.y;
        b[2] = before.z;
    }
#endif
    float3 x = s.x, v = after;
    if (p.pin >= 0) {
        State held = l.state(now, m, p.pin_control);
        x = add(held.x, p.pin_offset);
        v = held.v;
    } else {
#if GROUND
        advance(c.ground, c.law, c.dt, x, v);
#else
        x = add_scaled(x, c.dt, v);
#endif
    }
    publish_state(l, p, now ^ 1, m, x, v);
}

// The half-springs of the one row that a warp has, in registers.
struct HeldPairs {
#if HELD > 0
    Pair pairs[HELD];
#endif
};

// A pair of a node's half-springs, `xs` and `vs` being the states that they see.
DEVICE void spring_forces(
    const Constants& c, const float4* const* xs, const float2* const* vs, const Pair& pair,
    const State* s, float3* force
) {
    HalfSpring one = first_of(pair, c.dashpot), two = second_of(pair, c.dashpot);
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++) {
        float4 ax = xs[m][one.other], bx = xs[m][two.other];
        float2 av = vs[m][one.other], bv = vs[m][two.other];
        float3 r = sub(xyz(ax), s[m].x), w = sub(v3(ax.w, av.x, av.y), s[m].v);
        spring_force(one, r, w, force[m]);
        r = sub(xyz(bx), s[m].x);
        w = sub(v3(bx.w, bv.x, bv.y), s[m].v);
        spring_force(two, r, w, force[m]);
    }
}

DEVICE void integrate_node(
    const BlockState& l, const Constants& c, const ThreadNode& p, const HeldPairs& held, u32 now,
    u32 tape, const Pairs& pairs, const float3* bends, const u32* refs
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
#pragma unroll 2
    for (u32 k = HELD; k < p.pairs; k++)
        spring_forces(c, xs, vs, load_pair(pairs, p.first + k * 32), s, force);
#if ONE_ROW
    synchronize_bends();
#endif
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++) {
        float3 total = sum_lanes(add(force[m], bend_share(p, bends, refs, m)));
        float3 before = accelerate(c, p.inverse_mass, total, s[m].v);
        if (p.pin >= 0) before = l.state(now, m, p.pin_control).v;
#if CONTACT
        if (p.valid && p.lane == 0) {
            __stcg(l.instance->contact.x + p.at, with_w(s[m].x, p.inverse_mass));
            __stcg(l.instance->contact.v + p.at, with_w(before, 0.0f));
        }
#else
        if (p.valid) finish_substep(l, c, p, m, now, s[m], before, before, tape);
#endif
    }
}

DEVICE void resolve_contact(
    const BlockState& l, const Constants& c, const ThreadNode& p, u32 now, u32 tape
) {
    const InstanceArgs& instance = *l.instance;
    float contact_count;
    CurrentNodes nodes = {instance.contact.x, instance.contact.v};
    float3 after = collide(instance, nodes, p.at, p.valid, p.lane, contact_count);
    float3 before = xyz(__ldcg(instance.contact.v + p.at));
    if (p.valid) finish_substep(l, c, p, 0, now, l.state(now, 0, p.node), before, after, tape);
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
            Path path = path_of(instances[m], frame_of(instances[m], frame));
            l.put(buffer, m, l.control_base + c, control_position(path, t, c),
                  control_velocity(path, c));
        }
    }
}

// Pinned nodes stand at the frame's start with its velocity, wherever they are known.
DEVICE void begin_frame(const BlockState& l, const InstanceArgs* instances, u32 now, u32 frame) {
    const TopologyArgs& t = l.instance->topology;
    for (u32 m = 0; m < INSTANCES; m++) {
        Path path = path_of(instances[m], frame_of(instances[m], frame));
        for (u32 i = threadIdx.x; i < l.share.pins; i += THREADS) {
            LocalPin local = t.local_pins[l.share.pin + i];
            Pin pin = t.pins[local.pin];
            float3 held = load_v3(path.from + 3 * pin.control);
            l.put(now, m, local.local, add(held, load_v3(pin.offset)),
                  control_velocity(path, pin.control));
        }
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
    u32 unused;
};

// Runs frames `first..end` of each instance. With TAPE, each only as far as substep `to`, and what
// happens from `from` on goes onto tape, frame after frame.
extern "C" __global__ void __launch_bounds__(THREADS)
advance_frames(const __grid_constant__ AdvanceFramesArgs args) {
    const u32 first = args.first, end = args.end, from = args.from, to = args.to, keep = args.keep;
    const InstanceArgs* instances = args.instances + (u64)(blockIdx.x / BLOCKS) * INSTANCES;
    BlockState l = block_state_of(instances, blockIdx.x % BLOCKS, sizeof(float4) + sizeof(float2));
    Pairs pairs = pairs_of(l, l.share.rows, l.after_states(0));
    Constants c = constants_of(*instances);
    float3* bends = bend_buffer(l);
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
        begin_frame(l, instances, now, frame);
        place_controls(l, instances, path, now, frame, 0);
        __syncthreads();
        u32 last = TAPE ? min(to, path.substeps) : path.substeps;
        for (u32 s = 0; s < last; s++) {
            u32 tape = s >= from ? frame * (last - from) + s - from : NO_TAPE;
            expect_halo(l.arrivals, now ^ 1);
            place_controls(l, instances, path, now ^ 1, frame, s + 1);
#if RODS
            rod_forces(l, c, instances, now, bends, rod, tape);
#endif
            bend_forces(l, now, bends, triplet);
#if ONE_ROW
            integrate_node(l, c, p, held, now, tape, pairs, bends, refs);
#else
            for (u32 row = threadIdx.x / 32; row < l.share.rows; row += WARPS)
                integrate_node(l, c, thread_node_of(l, row), held, now, tape, pairs, bends, refs);
#endif
#if CONTACT
            synchronize_team(l.barrier, l.round);
#if ONE_ROW
            resolve_contact(l, c, p, now, tape);
#else
            for (u32 row = threadIdx.x / 32; row < l.share.rows; row += WARPS)
                resolve_contact(l, c, thread_node_of(l, row), now, tape);
#endif
#endif
            now ^= 1;
            synchronize_halo(l.arrivals, now, l.barrier, l.round);
            fetch_states(l, halo, now);
        }
#if RODS
        if (keep) store_twists(instances, frame);
#endif
        if (keep) store_states(l, instances, now, frame);
    }
    // None may end while another still writes into it.
    synchronize_team(l.barrier, l.round);
}
