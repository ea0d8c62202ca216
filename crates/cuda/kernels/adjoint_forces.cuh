// The second half of a substep backward: the forces' contribution to d loss / d state.

DEVICE BendAdjoint
bend_one(const BlockState& l, u32 now, float3* out, u32 t, const HeldTriplet& h) {
    const float4* lambda = lambda_of(l, now);
    State i = l.state(now, 0, h.ends.i), j = l.state(now, 0, h.ends.j),
          k = l.state(now, 0, h.ends.k);
    float3 lj = xyz(lambda[h.ends.j]);
    BendAdjoint a = bend_adjoint(
        h.params, sub(i.x, j.x), sub(k.x, j.x), sub(i.v, j.v), sub(k.v, j.v),
        sub(xyz(lambda[h.ends.i]), lj), sub(xyz(lambda[h.ends.k]), lj));
    out[4 * t] = a.x_i;
    out[4 * t + 1] = a.x_k;
    out[4 * t + 2] = a.v_i;
    out[4 * t + 3] = a.v_k;
    return a;
}

DEVICE void
bend_adjoints(const BlockState& l, u32 now, float3* out, const HeldTriplet& first, Sums& sums) {
#if BENDING
    if (first.has) {
        BendAdjoint a = bend_one(l, now, out, first_triplet(), first);
        sums.bend_stiffness += a.stiffness;
        sums.bend_damping += a.damping;
        sums.bend_rest += a.rest;
    }
    const InstanceArgs& instance = *l.instance;
    for (u32 t = first_triplet() + THREADS; t < l.share.triplets; t += THREADS) {
        HeldTriplet h = triplet_at(l, t);
        BendAdjoint a = bend_one(l, now, out, t, h);
        if (h.ends.owned) {
            u32 at = instance.topology.triplet_of[l.share.triplet + t];
            instance.adjoint.bend_sums[at] += a.stiffness;
            instance.adjoint.bend_sums[instance.topology.triplet_count + at] += a.damping;
            instance.adjoint.bend_sums[2 * instance.topology.triplet_count + at] += a.rest;
        }
    }
#if !ONE_ROW
    synchronize_bends();
#endif
#endif
}

#if RODS
// Sums of d loss / d (stiffness, damping, rest twist), [3][R].
DEVICE float* rod_sums() {
    static __shared__ float sums[3 * RODS];
    return sums;
}

DEVICE void load_rod_bars(const InstanceArgs& instance) {
    for (u32 r = threadIdx.x; r < RODS; r += THREADS)
        rod_twists()[r] = instance.adjoint.bar_twists[r];
    for (u32 i = threadIdx.x; i < 3 * RODS; i += THREADS) rod_sums()[i] = 0.0f;
}

// `begins` where that is the start of the frame.
DEVICE void store_rod_bars(const InstanceArgs& instance, bool begins) {
    __syncthreads();
    for (u32 r = threadIdx.x; r < RODS; r += THREADS) {
        float bar = rod_twists()[r];
        float kept = rod_span_of(instance, instance.state.first_frame, r, 0).kept;
        if (begins) {
            rod_sums()[2 * RODS + r] += (1.0f - kept) * bar;
            bar *= kept;
        }
        instance.adjoint.bar_twists[r] = bar;
    }
    __syncthreads();
    for (u32 i = threadIdx.x; i < 3 * RODS; i += THREADS)
        instance.adjoint.bend_sums[3 * instance.topology.triplet_count + i] += rod_sums()[i];
}

// The rods' part of a substep: from d loss / d twist at its end to that at its start, and what
// neighbours of inner nodes get, where triplets leave theirs. With pull = grad . lambda: torque_bar
// = -pull, twist_bar += k torque_bar, rate_bar = dt twist_bar + damping torque_bar; the adjoint of
// grad is rate_bar v - torque lambda.
DEVICE void rod_adjoints(
    const BlockState& l, const Constants& c, u32 now, float3* out, const HeldRod& first, u32 tape
) {
    const InstanceArgs& instance = *l.instance;
    const float4* lambda = lambda_of(l, now);
    for_rods(l, first, [&](u32 r, const HeldRod& h) {
        u32 lane = threadIdx.x % 32;
        float before = l.instance->tape.twists[(u64)tape * RODS + r];
        RodSpan span = rod_span_of(instance, instance.state.first_frame, r, h.end - h.first);
        u32 begin = h.first + span.first, end = h.first + span.end;
        float rate = 0.0f, pull = 0.0f;
        for (u32 t = begin + lane; t < end; t += 32) {
            InnerNode in = inner_node_at(l, now, 0, t);
            float3 own = xyz(lambda[in.ends.j]);
            rate += along(in.turn, in.v_before, in.v_after);
            pull +=
                along(in.turn, sub(xyz(lambda[in.ends.i]), own), sub(xyz(lambda[in.ends.k]), own));
        }
        rate = (sum_warp(rate) + span.roll_rate) * span.inverse_share;
        pull = sum_warp(pull);
        float deviation = before + rate * c.dt - h.rest_twist;
        float torque = h.stiffness * deviation + h.damping * rate;
        float bar = rod_twists()[r] - pull * h.stiffness;
        float rate_bar = (c.dt * bar - h.damping * pull) * span.inverse_share;
        __syncwarp();
        if (lane == 0) {
            rod_twists()[r] = bar;
            rod_sums()[r] -= pull * deviation;
            rod_sums()[RODS + r] -= pull * rate;
            rod_sums()[2 * RODS + r] += pull * h.stiffness;
            if ((ROLLS || GRASPS) && instance.world.roll_sums) instance.world.roll_sums[r] += rate_bar;
        }
        for (u32 t = h.first + lane; t < h.end; t += 32) {
            if (t < begin || t >= end) {
                for (u32 k = 0; k < 4; k++) out[4 * t + k] = zero3();
                continue;
            }
            InnerNode in = inner_node_at(l, now, 0, t);
            float3 own = xyz(lambda[in.ends.j]);
            float3 by_before = sub(xyz(lambda[in.ends.i]), own);
            float3 by_after = sub(xyz(lambda[in.ends.k]), own);
            float3 a_bar = add_scaled(scale(in.v_before, rate_bar), -torque, by_before);
            float3 c_bar = add_scaled(scale(in.v_after, rate_bar), -torque, by_after);
            turn_adjoint(in.turn, a_bar, c_bar, out[4 * t], out[4 * t + 1]);
            out[4 * t + 2] = scale(in.turn.a, rate_bar);
            out[4 * t + 3] = scale(in.turn.c, rate_bar);
        }
        __syncwarp();
    });
}
#endif

// Adds what an endpoint gets from a triplet.
DEVICE void add_bend(const float3* in, u32 ref, float3& x_bar, float3& v_bar) {
    const float3* t = in + 4 * triplet_of(ref);
    u32 role = role_of(ref);
    if (role < 2) {
        x_bar = add(x_bar, t[role]);
        v_bar = add(v_bar, t[2 + role]);
    } else {
        x_bar = sub(x_bar, add(t[0], t[1]));
        v_bar = sub(v_bar, add(t[2], t[3]));
    }
}

// State and lambda of an endpoint, and the arrays that its half-springs read.
struct Endpoint {
    State s;
    float3 lambda;
    const float4 *xs, *lambdas;
    const float2* vs;
};

DEVICE Endpoint endpoint_of(const BlockState& l, u32 now, u32 local) {
    Endpoint own;
    own.xs = opaque_shared(l.xs(now, 0));
    own.vs = opaque_shared(l.vs(now, 0));
    own.lambdas = opaque_shared<float4>(lambda_of(l, now));
    own.s = state_at(own.xs, own.vs, local);
    own.lambda = xyz(own.lambdas[local]);
    return own;
}

DEVICE void half_spring_adjoint(
    const BlockState& l, const Endpoint& own, const HalfSpring& h, float3& x_bar, float3& v_bar,
    SpringSums& sums
) {
    State other = state_at(own.xs, own.vs, h.other);
    float3 pull = sub(own.lambda, xyz(own.lambdas[h.other]));
    spring_adjoint(h, sub(other.x, own.s.x), sub(other.v, own.s.v), pull, x_bar, v_bar, sums);
}

// Sums of a pair in memory, where a warp's stand side by side. Those of ends that report nothing
// are not read.
DEVICE void add_sums(float* to, const float* before, const SpringSums& one, const SpringSums& two) {
    to[0] = before[0] + one.stretch;
    to[32] = before[1] + one.pull;
    to[64] = before[2] + one.rate;
    to[96] = before[3] + two.stretch;
    to[128] = before[4] + two.pull;
    to[160] = before[5] + two.rate;
}

// A pair with its sums in memory; they are loaded before there is anything to add.
DEVICE void summed_pair(
    const BlockState& l, const Constants& c, const Endpoint& own, const Pair& pair, float* to,
    float3& x_bar, float3& v_bar
) {
    float before[6];
#pragma unroll
    for (u32 k = 0; k < 6; k++) before[k] = to[32 * k];
    SpringSums one = {0.0f, 0.0f, 0.0f}, two = {0.0f, 0.0f, 0.0f};
    half_spring_adjoint(l, own, first_of(pair, c.dashpot), x_bar, v_bar, one);
    half_spring_adjoint(l, own, second_of(pair, c.dashpot), x_bar, v_bar, two);
    add_sums(to, before, one, two);
}

// Second half of a substep for a node; leaves d loss / d state at its start in `x_bar`, `v_bar`.
DEVICE void force_adjoint(
    const BlockState& l, const Constants& c, const ThreadNode& p, const NodeHold& h, u32 now,
    u32 substep, const Pairs& pairs, const float3* bends, const u32* refs, float3& x_bar,
    float3& v_bar, Sums& sums
) {
    float3 x_sum = zero3(), v_sum = zero3();
    Endpoint own = endpoint_of(l, now, p.node);
#if HELD > 0
#pragma unroll
    for (u32 k = 0; k < HELD_SUMS; k++) {
        if (k < p.pairs) {
            Pair pair = load_pair(pairs, p.first + k * 32);
            half_spring_adjoint(
                l, own, first_of(pair, c.dashpot), x_sum, v_sum, sums.springs[2 * k]
            );
            half_spring_adjoint(
                l, own, second_of(pair, c.dashpot), x_sum, v_sum, sums.springs[2 * k + 1]
            );
        }
    }
#endif
    // Those with sums come first; the others' sums are kept at their other ends.
    u32 k = HELD_SUMS;
    for (; k < p.summed; k++)
        summed_pair(l, c, own, load_pair(pairs, p.first + k * 32), c.sums + p.sums + k * PAIR_SUMS,
                    x_sum, v_sum);
    SpringSums unwanted;
#pragma unroll 2
    for (; k < p.pairs; k++) {
        Pair pair = load_pair(pairs, p.first + k * 32);
        half_spring_adjoint(l, own, first_of(pair, c.dashpot), x_sum, v_sum, unwanted);
        half_spring_adjoint(l, own, second_of(pair, c.dashpot), x_sum, v_sum, unwanted);
    }
#if ONE_ROW
    synchronize_bends();
#endif
#if BENDING
    for_arms(p, refs, [&](u32 ref) { add_bend(bends, ref, x_sum, v_sum); });
#endif
    x_sum = sum_lanes(x_sum);
    v_sum = sum_lanes(v_sum);
    x_bar = v_bar = zero3();
    // Lanes without a node do not read these: the warp of the node that they point at writes there.
    if (p.valid) {
        x_bar = add(xyz(bar_x_of(l)[p.node]), x_sum);
        v_bar = add(xyz(bar_v_of(l)[p.node]), v_sum);
#if GRASPS
        if (h.of.by == BY_SPRING) {
            // f = -stiffness (x - place) - damping (v - v_place), seen by the node and measured.
            float share = c.dt / l.instance->step.frame_s;
            float3 pull = add_scaled(own.lambda, share, held_force_bar(l, p, h));
            float3 x = scale(pull, h.of.stiffness), v = scale(pull, h.of.damping);
            x_bar = sub(x_bar, x);
            v_bar = sub(v_bar, v);
            if (p.lane == 0) add_hold_path(l, p, h, progress(substep, c.substeps), x, v);
        }
#endif
    }
    __syncwarp();
}

// The control points' part of the second half.
DEVICE void control_adjoint(
    const BlockState& l, const Constants& c, u32 now, u32 substep, const Pairs& pairs,
    const float3* bends, const u32* refs
) {
    const InstanceArgs& instance = *l.instance;
    if (!instance.adjoint.control_sums) return;
    const TopologyArgs& t = instance.topology;
    const u32* rows = t.rows + l.share.row;
    u32 lane = threadIdx.x % LANES;
    for (u32 row = threadIdx.x / 32; row < l.share.control_rows; row += WARPS) {
        u32 control = row * NODES_A_ROW + threadIdx.x % 32 / LANES;
        bool valid = control < l.controls;
        u32 start = rows[l.share.rows + row], end = rows[l.share.rows + row + 1];
        float3 x_bar = zero3(), v_bar = zero3();
        Endpoint own = endpoint_of(l, now, l.control_base + (valid ? control : 0));
        u32 first = (start - rows[0]) * 32 + threadIdx.x % 32;
        SpringSums unwanted;
        for (u32 k = 0; k < end - start; k++) {
            Pair pair = load_pair(pairs, first + k * 32);
            half_spring_adjoint(l, own, first_of(pair, c.dashpot), x_bar, v_bar, unwanted);
            half_spring_adjoint(l, own, second_of(pair, c.dashpot), x_bar, v_bar, unwanted);
        }
        for_control_arms(l, row, refs, [&](u32 ref) { add_bend(bends, ref, x_bar, v_bar); });
        x_bar = sum_lanes(x_bar);
        v_bar = sum_lanes(v_bar);
        if (valid && lane == 0) {
            float* to = instance.adjoint.control_sums + (u64)l.rank * 9 * l.controls;
            add_path(to, l.controls, control, progress(substep, c.substeps), x_bar, v_bar);
        }
    }
}
