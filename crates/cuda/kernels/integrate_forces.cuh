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

// A substep of a frame of the launch, and its place on tape.
struct Moment {
    u32 frame;
    u32 substep, substeps;
    u32 tape;
};

// Moves a free node for a substep that it starts in the state `s`; `v` is its velocity after forces
// acted.
DEVICE void travel(
    const InstanceArgs& instance, const Constants& c, const ThreadNode& p, const Moment& at,
    const State& s, float3& x, float3& v
) {
    x = s.x;
#if COLLIDERS || FORCES || SMOOTH
    float t = __fdiv_rn((float)at.substep, (float)at.substeps);
    u32 frame = frame_of(instance, at.frame);
    advance_among(instance, frame, t, p.at, s.v, x, v, [&](const Meeting& m) {
#if FORCES
        if (!instance.world.impulses || !p.valid || p.lane != 0) return;
        float3 by = scale(m.contact.change, instance.topology.masses[p.at]);
        bool ground = m.with == GROUND_ITSELF;
        u32 kind = ground ? IMPULSE_GROUND : IMPULSES + 6 * m.with;
        u32 body = ground ? NO_BODY : instance.world.colliders[m.with].body;
        add_node_impulse(instance, frame, p.at, kind, body, s.x, by);
#endif
    });
#elif GROUND
    advance(ground_for(instance, c.ground, p.at), c.law, c.dt, s.v, x, v);
#else
    x = add_scaled(x, c.dt, v);
#endif
}

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

// Forces of triplets on their ends, as references to them say; those of instances in turn. Outside
// shared memory a force's components stand together.
struct Bends {
    float* at;

    DEVICE_MEMBER float* first(u32 ref, u32 m) const {
        u32 shared = INSTANCES * (ref & ~31u) + (ref & 31u) + m * VECTORS;
        u32 spilled = ((triplet_of(ref) * ROLES + role_of(ref)) * INSTANCES + m) * 3;
        return at + (BEND_IN_SHARED ? shared : spilled);
    }
    static constexpr u32 APART = BEND_IN_SHARED ? 32 : 1;
    DEVICE_MEMBER float3 load(u32 ref, u32 m) const {
        const float* f = first(ref, m);
        return v3(f[0], f[APART], f[2 * APART]);
    }
    DEVICE_MEMBER void store(u32 t, u32 role, u32 m, float3 force) const {
        float* f = first(arm_ref(t, role), m);
        f[0] = force.x;
        f[APART] = force.y;
        f[2 * APART] = force.z;
    }
    // The forces on i and k; the centre takes the opposite of their sum.
    DEVICE_MEMBER void store(u32 t, u32 m, float3 f_i, float3 f_k) const {
        store(t, ROLE_I, m, f_i);
        store(t, ROLE_K, m, f_k);
        store(t, ROLE_J, m, scale(add(f_i, f_k), -1.0f));
    }
};

DEVICE Bends bends_of(const BlockState& l) {
    const TopologyArgs& topology = l.instance->topology;
    u32 pairs = FORCES ? topology.max_all_pairs : topology.max_pairs;
    u32 before = HALF_SPRINGS_IN_SHARED ? pairs_size(pairs) : 0;
    Bends b;
    b.at = reinterpret_cast<float*>(BEND_IN_SHARED ? l.after_states(before) : l.spill());
    return b;
}

DEVICE void bend_one(const BlockState& l, u32 now, const Bends& bends, u32 t, const HeldTriplet& h) {
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++) {
        State i = l.state(now, m, h.ends.i), j = l.state(now, m, h.ends.j);
        State k = l.state(now, m, h.ends.k);
        float3 f_i, f_k;
        bend_force(h.params, sub(i.x, j.x), sub(k.x, j.x), sub(i.v, j.v), sub(k.v, j.v), f_i, f_k);
        bends.store(t, m, f_i, f_k);
    }
}

#if RODS
// Moves the rods' twists and leaves what their inner nodes exert on their neighbours where triplets
// leave theirs.
DEVICE void rod_forces(
    const BlockState& l, const Constants& c, const InstanceArgs* instances, u32 frame, u32 now,
    const Bends& bends, const HeldRod& first, u32 tape
) {
    for_rods(l, first, [&](u32 r, const HeldRod& h) {
        for (u32 m = 0; m < INSTANCES; m++) {
            u32 lane = threadIdx.x % 32;
            RodSpan span = rod_span_of(
                instances[m], frame_of(instances[m], frame), r, h.end - h.first);
            u32 begin = h.first + span.first, end = h.first + span.end;
            float rate = 0.0f;
            for (u32 t = begin + lane; t < end; t += 32) {
                InnerNode in = inner_node_at(l, now, m, t);
                rate += along(in.turn, in.v_before, in.v_after);
            }
            rate = (sum_warp(rate) + span.roll_rate) * span.inverse_share;
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
                if (t < begin || t >= end) {
                    bends.store(t, m, zero3(), zero3());
                    continue;
                }
                Turn turn = inner_node_at(l, now, m, t).turn;
                bends.store(t, m, scale(turn.a, -torque), scale(turn.c, -torque));
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

// Takes from the twists what lay outside the clamps that hold in a frame.
DEVICE void begin_twists(const InstanceArgs* instances, u32 frame) {
#if GRASPS
    for (u32 i = threadIdx.x; i < RODS * INSTANCES; i += THREADS) {
        const InstanceArgs& instance = instances[i / RODS];
        float kept = rod_span_of(instance, frame_of(instance, frame), i % RODS, 0).kept;
        float rest = instance.parameters.rods[2 * RODS + i % RODS];
        if (kept != 1.0f) rod_twists()[i] = rest + kept * (rod_twists()[i] - rest);
    }
#endif
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

DEVICE void
bend_forces(const BlockState& l, u32 now, const Bends& bends, const HeldTriplet& first) {
#if BENDING
    if (first.has) bend_one(l, now, bends, first_triplet(), first);
    for (u32 t = first_triplet() + THREADS; t < l.share.triplets; t += THREADS)
        bend_one(l, now, bends, t, triplet_at(l, t));
#if !ONE_ROW
    synchronize_bends();
#endif
#endif
}

// A lane's part of the forces of its node's triplets.
DEVICE float3 bend_share(const ThreadNode& p, const Bends& bends, const u32* refs, u32 m) {
    float3 sum = zero3();
#if BENDING
    for_arms(p, refs, [&](u32 ref) { sum = add(sum, bends.load(ref, m)); });
#endif
    return sum;
}
