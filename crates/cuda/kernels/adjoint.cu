// A frame backward: the adjoint of `integrate.cu`, substep by substep from the tape, in exactly the
// reverse order. Everything is gathered: a node adds up what it gets from its half-springs and
// triplets.
//
// A substep has two halves. `node_adjoint` turns d loss / d state at its end into that before
// forces acted, and into lambda = d loss / d force, which the neighbours need; `force_adjoint` adds
// what the forces contribute to d loss / d the state that they depend on. The second of a substep
// and the first of the one before it concern the same node, so the team synchronizes once a substep
// (and once more for contact). The second half is in `adjoint_forces.cuh`.

// Starts copying a substep of the tape to a buffer and puts the control points there.
DEVICE void fetch_tape(const BlockState& l, const Constants& c, u32 buffer, u32 tape, u32 substep) {
    const InstanceArgs& instance = *l.instance;
    const u32* nodes = instance.topology.nodes + l.share.nodes;
    const float4* xs = c.tape_x + (u64)tape * c.nodes;
    const float2* vs = c.tape_v + (u64)tape * c.nodes;
    for (u32 i = threadIdx.x; i < l.share.local; i += THREADS) {
        u32 at = i == threadIdx.x ? c.first_slot : instance.tape.slot_of[nodes[i]];
        copy_async(l.xs(buffer, 0) + i, xs + at);
        copy_async(l.vs(buffer, 0) + i, vs + at);
    }
    float t = progress(substep, c.substeps);
    // The last threads: their rows are the shortest.
    for (u32 i = THREADS - 1 - threadIdx.x; i < l.controls; i += THREADS)
        put_control(l, instance, buffer, 0, i, instance.state.first_frame, t);
}

// From d loss / d velocity before contact to that before forces acted, to which contact adds
// `start_bar`, and to lambda.
DEVICE void accelerate_adjoint(
    const BlockState& l, const Constants& c, const ThreadNode& p, const NodeHold& h, u32 buffer,
    float3 before, float3 x_bar, float3 v_bar, float3 start_bar, Sums& sums
) {
    bool is_held = is_pinned(p, h) || is_carried(h);
    float3 held_bar = zero3();  // d loss / d the velocity that it would have
#if FORCES
    if (is_held) {
        float mass = l.instance->topology.masses[p.at];
        float3 seed = scale(held_force_bar(l, p, h), mass / l.instance->step.frame_s);
        v_bar = add(v_bar, seed);
        held_bar = scale(seed, -1.0f);
    }
#endif
    if (is_held) {
        if (p.lane == 0) add_hold_path(l, p, h, 0.0f, zero3(), v_bar);
        v_bar = held_bar;
    }
    if (p.lane == 0) sums.decay += dot(v_bar, before);
    v_bar = scale(v_bar, c.decay);
    if (p.lane == 0) {
        bar_x_of(l)[p.node] = with_w(x_bar, 0.0f);
        bar_v_of(l)[p.node] = with_w(add(v_bar, start_bar), 0.0f);
    }
    float inverse_mass = inverse_mass_of(p, h);
#if FORCES
    if (is_held) inverse_mass = 1.0f / l.instance->topology.masses[p.at];
#endif
    float4 lambda = with_w(scale(v_bar, inverse_mass * c.dt), 0.0f);
    publish_vector(l, p, buffer, lambda_of(l, buffer), lambda);
}

// A node's record on tape at a substep: position and velocity at its start, and velocity before
// contact.
struct TapeEntry {
    float3 x, start, before;
};

DEVICE TapeEntry tape_entry_of(const Constants& c, const ThreadNode& p, u32 tape) {
    u64 at = (u64)tape * c.nodes + p.slot;
    TapeEntry e;
    float4 x = c.tape_x[at];
    e.x = xyz(x);
#if GROUND || COLLIDERS || SMOOTH
    float2 v = c.tape_v[at];
    e.start = v3(x.w, v.x, v.y);
#endif
    e.before = load_v3(c.tape_b + 3 * at);
    return e;
}

// First half of a substep, `bar` being d loss / d state at its end. With contact it ends before the
// barrier that `contact_adjoint` needs.
DEVICE void node_adjoint(
    const BlockState& l, const Constants& c, const ThreadNode& p, const NodeHold& h, u32 buffer,
    u32 substep, u32 tape, const TapeEntry& entry, float3 x_bar, float3 v_bar, Sums& sums
) {
    const InstanceArgs& instance = *l.instance;
    float3 x = entry.x, before = entry.before;
    bool is_held = is_pinned(p, h) || is_carried(h);
    if (is_held) {
        float t = progress(substep, c.substeps);
        if (p.lane == 0) add_hold_path(l, p, h, t, x_bar, v_bar);
        x_bar = v_bar = zero3();
    }
    float3 after = before, start_bar = zero3();
    Law law_bar = {0.0f, 0.0f};
#if CONTACT
    u64 start = (u64)tape * c.nodes;
    TapedNodes nodes = {
        c.tape_x + start, c.tape_v + start, c.tape_b + 3 * start, instance.topology.inverse_mass,
        instance.tape.slot_of, &instance
    };
    float contact_count;
    after = collide(instance, nodes, p.at, p.valid, p.lane, contact_count);
#endif
#if COLLIDERS || FORCES || SMOOTH
    if (!is_held && p.valid) {
        float t = __fdiv_rn((float)substep, (float)c.substeps);
        start_bar = advance_among_adjoint(
            instance, instance.state.first_frame, t, p.at, p.lane == 0, entry.start, x, after,
            x_bar, v_bar, law_bar
        );
    }
#elif GROUND
    float height_bar;
    start_bar = advance_adjoint(
        ground_for(instance, c.ground, p.at), c.law, c.dt, entry.start, x, after, x_bar, v_bar,
        law_bar, height_bar
    );
    if (p.valid && p.lane == 0) add_clearance_bar(instance, 0, p.at, -height_bar);
#else
    v_bar = add_scaled(v_bar, c.dt, x_bar);
#endif
    if (!p.valid) return;
    if (p.lane == 0) {
        sums.ground.restitution += law_bar.restitution;
        sums.ground.friction += law_bar.friction;
    }
#if CONTACT
    if (p.lane == 0) {
        float share = contact_count > 0.0f ? -(inverse_mass_of(p, h) / contact_count) : 0.0f;
        __stcg(instance.contact.v + p.at, with_w(scale(v_bar, share), 0.0f));
        __stcg(instance.contact.start + p.at, with_w(start_bar, 0.0f));
        bar_x_of(l)[p.node] = with_w(x_bar, 0.0f);
        bar_v_of(l)[p.node] = with_w(v_bar, 0.0f);
    }
#else
    accelerate_adjoint(l, c, p, h, buffer, before, x_bar, v_bar, start_bar, sums);
#endif
}

// The rest of it with contact, after the team's barrier.
DEVICE void contact_adjoint(
    const BlockState& l, const Constants& c, const ThreadNode& p, const NodeHold& h, u32 buffer,
    u32 tape, Sums& sums
) {
    const InstanceArgs& instance = *l.instance;
    u64 start = (u64)tape * c.nodes;
    TapedNodes nodes = {
        c.tape_x + start, c.tape_v + start, c.tape_b + 3 * start, instance.topology.inverse_mass,
        instance.tape.slot_of, &instance
    };
    float3 x_bar = zero3(), v_bar = zero3(), start_bar = zero3();
    if (p.valid) {
        x_bar = xyz(bar_x_of(l)[p.node]);
        v_bar = xyz(bar_v_of(l)[p.node]);
        start_bar = xyz(__ldcg(instance.contact.start + p.at));
    }
    __syncwarp();
    collide_adjoint(
        instance, nodes, p.at, p.valid, p.lane, instance.contact.v, x_bar, v_bar, start_bar,
        sums.object
    );
    float3 before = load_v3(c.tape_b + 3 * (start + p.slot));
    if (p.valid) accelerate_adjoint(l, c, p, h, buffer, before, x_bar, v_bar, start_bar, sums);
}

// Adds a block's sum of a thread's value to `to`, in a fixed order.
DEVICE void add_block_sum(float value, float* to) {
    __shared__ float partial[WARPS];
    for (int mask = 16; mask > 0; mask /= 2) value += __shfl_xor_sync(0xffffffffu, value, mask);
    if (threadIdx.x % 32 == 0) partial[threadIdx.x / 32] = value;
    __syncthreads();
    if (threadIdx.x == 0) {
        float sum = 0.0f;
        for (u32 w = 0; w < WARPS; w++) sum += partial[w];
        *to += sum;
    }
    __syncthreads();
}

DEVICE void store_sums(
    const BlockState& l, const Constants& c, const ThreadNode& p, const HeldTriplet& triplet,
    const Sums& sums
) {
    const InstanceArgs& instance = *l.instance;
#if HELD > 0
#pragma unroll
    for (u32 k = 0; k < HELD_SUMS; k++) {
        if (k >= p.summed) continue;
        float* to = instance.adjoint.spring_sums + p.sums + k * PAIR_SUMS;
        float before[6];
        for (u32 i = 0; i < 6; i++) before[i] = to[32 * i];
        add_sums(to, before, sums.springs[2 * k], sums.springs[2 * k + 1]);
    }
#endif
    if (triplet.has && triplet.ends.owned) {
        u32 at = instance.topology.triplet_of[l.share.triplet + first_triplet()];
        instance.adjoint.bend_sums[at] += sums.bend_stiffness;
        instance.adjoint.bend_sums[instance.topology.triplet_count + at] += sums.bend_damping;
        instance.adjoint.bend_sums[2 * instance.topology.triplet_count + at] += sums.bend_rest;
    }
    float* laws = instance.adjoint.law_sums + 5 * l.rank;
    add_block_sum(-c.dt * sums.decay, laws);
    add_block_sum(sums.ground.restitution, laws + 1);
    add_block_sum(sums.ground.friction, laws + 2);
    add_block_sum(sums.object.restitution, laws + 3);
    add_block_sum(sums.object.friction, laws + 4);
}

#if ONE_ROW
#define FOR_NODES(p)
#else
#define FOR_NODES(p)                                                                            \
    for (u32 row = threadIdx.x / 32; row < l.share.rows; row += WARPS)                           \
        for (ThreadNode p = thread_node_of(l, row), *once = &p; once; once = 0)
#endif

DEVICE void contact_half(
    BlockState& l, const Constants& c, const ThreadNode& one, const NodeHold& hold, u32 buffer,
    u32 tape, Sums& sums
) {
#if CONTACT
    synchronize_team(l.barrier, l.round);
#if ONE_ROW
    contact_adjoint(l, c, one, hold, buffer, tape, sums);
#else
    FOR_NODES(p) contact_adjoint(l, c, p, node_hold_of(l, p), buffer, tape, sums);
#endif
#endif
}

DEVICE void synchronize_lambda(BlockState& l, const Halo& halo, u32 buffer) {
    wait_for_copies();
    synchronize_halo(l.arrivals, buffer, l.barrier, l.round);
    fetch_vectors(l, halo, buffer, lambda_of(l, buffer));
}

// Of where held nodes stand when the frame begins; leaves d loss / d what they arrive with.
DEVICE void begin_frame_adjoint(
    const BlockState& l, const ThreadNode& p, const NodeHold& h, float3& x_bar, float3& v_bar
) {
    if (is_pinned(p, h) || is_carried(h)) {
        float3 jump = zero3();
#if FORCES
        const InstanceArgs& instance = *l.instance;
        float mass = instance.topology.masses[p.at];
        jump = scale(held_force_bar(l, p, h), mass / instance.step.frame_s);
#endif
        if (p.lane == 0) add_hold_path(l, p, h, 0.0f, x_bar, add(v_bar, jump));
        x_bar = zero3();
        v_bar = scale(jump, -1.0f);
#if FORCES
        // The first frame's meet the state that the rollout was given.
        if (instance.state.first_frame == 0 && instance.world.arrive_bars) {
            if (p.lane == 0) instance.world.arrive_bars[p.at] = with_w(v_bar, 0.0f);
            v_bar = zero3();
        }
#endif
    }
}

struct BackFrameArgs {
    const InstanceArgs* instances;
    u32 from, to;  // substeps
};

// Turns `AdjointArgs::bar_*` at the end of substep `to` - 1 of frame `StateArgs::first_frame` into
// that at the start of substep `from`; substep `from` is the tape's first.
extern "C" __global__ void __launch_bounds__(THREADS)
back_frame(const __grid_constant__ BackFrameArgs args) {
    const u32 from = args.from, to = args.to;
    const InstanceArgs& instance = args.instances[blockIdx.x / BLOCKS];
    BlockState l = block_state_of(&instance, blockIdx.x % BLOCKS, sizeof(float4));
    Constants c = {
        instance.step.dt,
        instance.parameters.decay,
        instance.step.ground,
        instance.parameters.ground_law,
        instance.parameters.dashpot,
        instance.step.substeps,
        instance.topology.node_count,
        instance.tape.x,
        instance.tape.v,
        instance.tape.before,
        instance.adjoint.spring_sums,
        threadIdx.x < l.share.local ? instance.tape.slot_of[l.graph_node(threadIdx.x)] : 0
    };
    u32 rows = l.share.rows + (instance.adjoint.control_sums ? l.share.control_rows : 0);
    Pairs pairs = pairs_of(l, rows, after_bars(l));
    float3* bends = bend_buffer(l);
    const u32* refs = instance.topology.arm_refs;
    HeldTriplet triplet = triplet_at(l, first_triplet());
#if RODS
    HeldRod rod = rod_at(l, threadIdx.x / 32);
    load_rod_bars(instance);
#endif
    Halo halo = halo_of(l);
    Sums sums = {};
    ThreadNode one = thread_node_of(l, threadIdx.x / 32);
    NodeHold hold = node_hold_of(l, one);
    for (u32 i = threadIdx.x; i < l.controls; i += THREADS) {
        float4 lambda = zero4();
#if FORCES
        // A control point exerts minus the force on it.
        const float* bars = instance.world.force_bars;
        float share = -instance.step.dt / instance.step.frame_s;
        if (bars) lambda = with_w(scale(load_v3(bars + 6 * i), share), 0.0f);
#endif
        lambda_of(l, 0)[l.control_base + i] = lambda;
        lambda_of(l, 1)[l.control_base + i] = lambda;
    }
    u32 now = 0;
    fetch_tape(l, c, now, to - 1 - from, to - 1);
    wait_for_copies();
    __syncthreads();
    // A cluster's blocks must all have started before one writes into another.
    synchronize_team(l.barrier, l.round);
    expect_halo(l.arrivals, now);
#if ONE_ROW
    node_adjoint(l, c, one, hold, now, to - 1, to - 1 - from, tape_entry_of(c, one, to - 1 - from),
                 xyz(instance.adjoint.bar_x[one.at]), xyz(instance.adjoint.bar_v[one.at]), sums);
#else
    FOR_NODES(p) {
        NodeHold hold = node_hold_of(l, p);
        node_adjoint(l, c, p, hold, now, to - 1, to - 1 - from, tape_entry_of(c, p, to - 1 - from),
                     xyz(instance.adjoint.bar_x[p.at]), xyz(instance.adjoint.bar_v[p.at]), sums);
    }
#endif
    contact_half(l, c, one, hold, now, to - 1 - from, sums);
    synchronize_lambda(l, halo, now);
    for (u32 s = to; s-- > from;) {
        u32 earlier = now ^ 1;
        if (s > from) {
            expect_halo(l.arrivals, earlier);
            fetch_tape(l, c, earlier, s - 1 - from, s - 1);
        }
#if RODS
        rod_adjoints(l, c, now, bends, rod, s - from);
#endif
        bend_adjoints(l, now, bends, triplet, sums);
#if ONE_ROW
        {
            const ThreadNode& p = one;
#else
        FOR_NODES(p) {
            NodeHold hold = node_hold_of(l, p);
#endif
            float3 x_bar, v_bar;
            // Loaded early: global memory is slow.
            TapeEntry entry = {};
            if (s > from) entry = tape_entry_of(c, p, s - 1 - from);
            force_adjoint(l, c, p, hold, now, s, pairs, bends, refs, x_bar, v_bar, sums);
            if (s > from) {
                node_adjoint(l, c, p, hold, earlier, s - 1, s - 1 - from, entry, x_bar, v_bar, sums);
            } else if (p.valid) {
                if (from == 0) begin_frame_adjoint(l, p, hold, x_bar, v_bar);
                if (p.lane == 0) {
                    instance.adjoint.bar_x[p.at] = with_w(x_bar, 0.0f);
                    instance.adjoint.bar_v[p.at] = with_w(v_bar, 0.0f);
                }
            }
        }
        control_adjoint(l, c, now, s, pairs, bends, refs);
        if (s > from) {
            contact_half(l, c, one, hold, earlier, s - 1 - from, sums);
            synchronize_lambda(l, halo, earlier);
        }
        now = earlier;
    }
    store_sums(l, c, one, triplet, sums);
#if RODS
    store_rod_bars(instance, from == 0);
#endif
}
