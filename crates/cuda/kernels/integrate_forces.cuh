// Parts of a substep forward: values that stay, holds of a node, its way through contacts, and the
// forces of triplets and rods. `integrate.cu` puts them together.

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

// What holds a thread's node in a frame, by instance.
struct NodeHolds {
#if GRASPS
    Held of[INSTANCES];
#endif
};

DEVICE NodeHolds node_holds_of(const ThreadNode& p, const InstanceArgs* instances, u32 frame) {
    NodeHolds h;
#if GRASPS
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++)
        h.of[m] = held_of(instances[m], frame_of(instances[m], frame), p.at, p.valid, p.pin);
#endif
    return h;
}

// True if a control point holds the node.
DEVICE bool is_pinned(const ThreadNode& p, const NodeHolds& holds, u32 m) {
#if GRASPS
    return holds.of[m].by == BY_CONTROL;
#else
    return p.pin >= 0;
#endif
}

// Zero where a node is held.
DEVICE float inverse_mass_of(const ThreadNode& p, const NodeHolds& holds, u32 m) {
#if GRASPS
    return p.valid ? holds.of[m].inverse_mass : 0.0f;
#else
    return p.inverse_mass;
#endif
}

// A substep of a frame of the rollout, and its place on tape.
struct Moment {
    u32 frame;
    u32 substep, substeps;
    u32 tape;
};

// Moves a free node for a substep.
DEVICE void travel(
    const InstanceArgs& instance, const Constants& c, const ThreadNode& p, const Moment& at,
    float3& x, float3& v
) {
#if COLLIDERS || FORCES || SMOOTH
    float3 start = x;
    float t = __fdiv_rn((float)at.substep, (float)at.substeps);
    advance_among(instance, at.frame, t, x, v, [&](const Meeting& m) {
#if FORCES
        if (!instance.world.impulses || !p.valid || p.lane != 0) return;
        float3 by = scale(sub(m.after, m.before), instance.topology.masses[p.at]);
        bool ground = m.with == GROUND_ITSELF;
        u32 kind = ground ? IMPULSE_GROUND : IMPULSES + 6 * m.with;
        u32 body = ground ? NO_BODY : instance.world.colliders[m.with].body;
        add_node_impulse(instance, at.frame, p.at, kind, body, start, by);
#endif
    });
#elif GROUND
    advance(c.ground, c.law, c.dt, x, v);
#else
    x = add_scaled(x, c.dt, v);
#endif
}

// Forces of the ends i and k, by triplet and instance.
DEVICE float3* bend_buffer(const BlockState& l) {
    const TopologyArgs& topology = l.instance->topology;
    u32 pairs = FORCES ? topology.max_all_pairs : topology.max_pairs;
    u32 before = HALF_SPRINGS_IN_SHARED ? pairs_size(pairs) : 0;
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
    const BlockState& l, const Constants& c, const InstanceArgs* instances, u32 frame, u32 now,
    float3* forces, const HeldRod& first, u32 tape
) {
    for_rods(l, first, [&](u32 r, const HeldRod& h) {
        for (u32 m = 0; m < INSTANCES; m++) {
            u32 lane = threadIdx.x % 32;
            float rate = 0.0f;
            for (u32 t = h.first + lane; t < h.end; t += 32) {
                InnerNode in = inner_node_at(l, now, m, t);
                rate += along(in.turn, in.v_before, in.v_after);
            }
            rate = sum_warp(rate) + roll_rate(instances[m], frame_of(instances[m], frame), r);
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
