// A frame backward: the adjoint of `integrate.cu`, substep by substep from the tape, in exactly the
// reverse order. Everything is gathered: a node adds up what it gets from its half-springs and triplets.
//
// A substep has two halves. `node_adjoint` turns d loss / d state at its end into that before forces
// acted, and into lambda = d loss / d force, which the neighbours need; `force_adjoint` adds what the
// forces say about the state that they saw. The second of a substep and the first of the one before it
// concern the same node, so the team meets once a substep (and once more for contact).

// Beside the tape's states: lambda, two buffers; then what is carried from substep to substep.
DEVICE float4* lambda_of(const Local& l, u32 buffer) { return l.after_states(buffer * l.stride); }
DEVICE float4* bar_x_of(const Local& l) { return l.after_states(2 * l.stride); }
DEVICE float4* bar_v_of(const Local& l) { return l.after_states(2 * l.stride + l.control_base); }
DEVICE float4* after_bars(const Local& l) { return l.after_states(2 * l.stride + 2 * l.control_base); }
// d loss / d (x_i, x_k, v_i, v_k), by triplet.
DEVICE float3* bend_buffer(const Local& l) {
    u32 before = HALF_SPRINGS_IN_SHARED ? pairs_size(l.job->topology.max_all_pairs) : 0;
    return reinterpret_cast<float3*>(BEND_IN_SHARED ? after_bars(l) + before : l.spill());
}

// What all substeps need, kept in registers.
struct Constants {
    float dt, decay;
    Ground ground;
    Law law;
    float dashpot;
    u32 substeps, nodes;
    const float4* tape_x;
    const float2* tape_v;
    const float* tape_b;
    float* pin_sums;
    float* sums;
    u32 first_slot;  // on tape, of the thread's first local node
};

// What a thread adds up over a launch.
struct Sums {
    float decay;
    Law ground, object;
    float bend_stiffness, bend_damping, bend_rest;  // of the thread's first triplet
#if HELD > 0
    SpringSums springs[2 * HELD_SUMS];
#endif
};

// Adds to one of the nine components of d loss / d (from, to, velocity); nothing if nobody asks.
DEVICE void add_path(float* sums, u32 stride, u32 i, float t, float3 x_bar, float3 v_bar) {
    if (!sums) return;
    float from = 1.0f - t;
    sums[0 * stride + i] += from * x_bar.x;
    sums[1 * stride + i] += from * x_bar.y;
    sums[2 * stride + i] += from * x_bar.z;
    sums[3 * stride + i] += t * x_bar.x;
    sums[4 * stride + i] += t * x_bar.y;
    sums[5 * stride + i] += t * x_bar.z;
    sums[6 * stride + i] += v_bar.x;
    sums[7 * stride + i] += v_bar.y;
    sums[8 * stride + i] += v_bar.z;
}

// Starts copying a substep of the tape to a buffer and puts the control points there.
DEVICE void fetch_tape(const Local& l, const Constants& c, u32 buffer, u32 tape, u32 substep) {
    const Job& job = *l.job;
    const u32* nodes = job.topology.nodes + l.share.nodes;
    const float4* xs = c.tape_x + (u64)tape * c.nodes;
    const float2* vs = c.tape_v + (u64)tape * c.nodes;
    for (u32 i = threadIdx.x; i < l.share.local; i += THREADS) {
        u32 at = i == threadIdx.x ? c.first_slot : job.tape_slots[nodes[i]];
        copy_async(l.xs(buffer, 0) + i, xs + at);
        copy_async(l.vs(buffer, 0) + i, vs + at);
    }
    Path path = path_of(job, job.first);
    float t = progress(substep, c.substeps);
    // The last threads: their rows are the shortest.
    for (u32 i = THREADS - 1 - threadIdx.x; i < l.controls; i += THREADS)
        l.put(buffer, 0, l.control_base + i, control_position(path, t, i), control_velocity(path, i));
}

// From d loss / d velocity before contact to that before forces acted, and to lambda.
DEVICE void accelerate_adjoint(
    const Local& l, const Constants& c, const Place& p, u32 buffer, float3 before, float3 x_bar,
    float3 v_bar, Sums& sums
) {
    if (p.pin >= 0) {
        if (p.lane == 0) add_path(c.pin_sums, l.job->pins, p.pin, 0.0f, zero3(), v_bar);
        v_bar = zero3();
    }
    if (p.lane == 0) sums.decay += dot(v_bar, before);
    v_bar = scale(v_bar, c.decay);
    if (p.lane == 0) {
        bar_x_of(l)[p.node] = with_w(x_bar, 0.0f);
        bar_v_of(l)[p.node] = with_w(v_bar, 0.0f);
    }
    float4 lambda = with_w(scale(v_bar, p.inverse_mass * c.dt), 0.0f);
    publish_vector(l, p, buffer, lambda_of(l, buffer), lambda);
}

// What the tape says of a node at a substep: position, and velocity before contact.
struct Entry {
    float3 x, before;
};

DEVICE Entry entry_of(const Constants& c, const Place& p, u32 tape) {
    u64 at = (u64)tape * c.nodes + p.slot;
    Entry e;
    e.x = xyz(c.tape_x[at]);
    e.before = load_v3(c.tape_b + 3 * at);
    return e;
}

// First half of a substep, `bar` being d loss / d state at its end. With contact it ends before the
// meeting that `contact_adjoint` needs.
DEVICE void node_adjoint(
    const Local& l, const Constants& c, const Place& p, u32 buffer, u32 substep, u32 tape,
    const Entry& entry, float3 x_bar, float3 v_bar, Sums& sums
) {
    const Job& job = *l.job;
    float3 x = entry.x, before = entry.before;
    if (p.pin >= 0) {
        float t = progress(substep, c.substeps);
        if (p.lane == 0) add_path(c.pin_sums, job.pins, p.pin, t, x_bar, v_bar);
        x_bar = v_bar = zero3();
    }
    float3 after = before;
    Law law_bar = {0.0f, 0.0f};
#if CONTACT
    u64 start = (u64)tape * c.nodes;
    Taped nodes = {c.tape_x + start, c.tape_b + 3 * start, job.topology.inverse_mass, job.tape_slots};
    float touches;
    after = collide(job, nodes, p.at, p.valid, p.lane, touches);
#endif
#if GROUND
    advance_adjoint(c.ground, c.law, c.dt, x, after, x_bar, v_bar, law_bar);
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
        float share = touches > 0.0f ? -(p.inverse_mass / touches) : 0.0f;
        __stcg(job.contact_v + p.at, with_w(scale(v_bar, share), 0.0f));
        bar_x_of(l)[p.node] = with_w(x_bar, 0.0f);
        bar_v_of(l)[p.node] = with_w(v_bar, 0.0f);
    }
#else
    accelerate_adjoint(l, c, p, buffer, before, x_bar, v_bar, sums);
#endif
}

// The rest of it with contact, after the team has met.
DEVICE void contact_adjoint(
    const Local& l, const Constants& c, const Place& p, u32 buffer, u32 tape, Sums& sums
) {
    const Job& job = *l.job;
    u64 start = (u64)tape * c.nodes;
    Taped nodes = {c.tape_x + start, c.tape_b + 3 * start, job.topology.inverse_mass, job.tape_slots};
    float3 x_bar = zero3(), v_bar = zero3();
    if (p.valid) {
        x_bar = xyz(bar_x_of(l)[p.node]);
        v_bar = xyz(bar_v_of(l)[p.node]);
    }
    __syncwarp();
    collide_adjoint(job, nodes, p.at, p.valid, p.lane, job.contact_v, x_bar, v_bar, sums.object);
    float4 x4;
    float3 before;
    nodes.load(p.at, x4, before);
    if (p.valid) accelerate_adjoint(l, c, p, buffer, before, x_bar, v_bar, sums);
}

DEVICE BendAdjoint
bend_one(const Local& l, u32 now, float3* out, u32 t, const HeldTriplet& h) {
    const float4* lambda = lambda_of(l, now);
    State i = l.state(now, 0, h.ends.i), j = l.state(now, 0, h.ends.j), k = l.state(now, 0, h.ends.k);
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
bend_adjoints(const Local& l, u32 now, float3* out, const HeldTriplet& first, Sums& sums) {
#if BENDING
    if (first.has) {
        BendAdjoint a = bend_one(l, now, out, first_triplet(), first);
        sums.bend_stiffness += a.stiffness;
        sums.bend_damping += a.damping;
        sums.bend_rest += a.rest;
    }
    const Job& job = *l.job;
    for (u32 t = first_triplet() + THREADS; t < l.share.triplets; t += THREADS) {
        HeldTriplet h = triplet_at(l, t);
        BendAdjoint a = bend_one(l, now, out, t, h);
        if (h.ends.owned) {
            u32 at = job.topology.triplet_of[l.share.triplet + t];
            job.bend_sums[at] += a.stiffness;
            job.bend_sums[job.triplets + at] += a.damping;
            job.bend_sums[2 * job.triplets + at] += a.rest;
        }
    }
#if !ONE_ROW
    meet_for_bends();
#endif
#endif
}

// Adds what an endpoint gets from a triplet.
DEVICE void add_bend(const float3* in, u32 triplet, u32 role, float3& x_bar, float3& v_bar) {
    const float3* t = in + 4 * triplet;
    if (role < 2) {
        x_bar = add(x_bar, t[role]);
        v_bar = add(v_bar, t[2 + role]);
    } else {
        x_bar = sub(x_bar, add(t[0], t[1]));
        v_bar = sub(v_bar, add(t[2], t[3]));
    }
}

// What an endpoint's half-springs are worked on with.
struct Self {
    State s;
    float3 lambda;
    const float4 *xs, *lambdas;
    const float2* vs;
};

DEVICE Self self_of(const Local& l, u32 now, u32 local) {
    Self self;
    self.xs = anchored(l.xs(now, 0));
    self.vs = anchored(l.vs(now, 0));
    self.lambdas = anchored<float4>(lambda_of(l, now));
    self.s = state_at(self.xs, self.vs, local);
    self.lambda = xyz(self.lambdas[local]);
    return self;
}

DEVICE void half_adjoint(
    const Local& l, const Self& self, const HalfSpring& h, float3& x_bar, float3& v_bar, SpringSums& sums
) {
    State other = state_at(self.xs, self.vs, h.other);
    float3 pull = sub(self.lambda, xyz(self.lambdas[h.other]));
    spring_adjoint(h, sub(other.x, self.s.x), sub(other.v, self.s.v), pull, x_bar, v_bar, sums);
}

// Sums of a pair in memory, where a warp's stand side by side. Those of ends that report nothing are not looked at.
DEVICE void add_sums(float* to, const float* before, const SpringSums& one, const SpringSums& two) {
    to[0] = before[0] + one.stretch;
    to[32] = before[1] + one.pull;
    to[64] = before[2] + one.rate;
    to[96] = before[3] + two.stretch;
    to[128] = before[4] + two.pull;
    to[160] = before[5] + two.rate;
}

// A pair with its sums in memory; they are asked for before there is anything to add.
DEVICE void summed_pair(
    const Local& l, const Constants& c, const Self& self, const Pair& pair, float* to, float3& x_bar,
    float3& v_bar
) {
    float before[6];
#pragma unroll
    for (u32 k = 0; k < 6; k++) before[k] = to[32 * k];
    SpringSums one = {0.0f, 0.0f, 0.0f}, two = {0.0f, 0.0f, 0.0f};
    half_adjoint(l, self, first_of(pair, c.dashpot), x_bar, v_bar, one);
    half_adjoint(l, self, second_of(pair, c.dashpot), x_bar, v_bar, two);
    add_sums(to, before, one, two);
}

// Second half of a substep for a node; leaves d loss / d state at its start in `x_bar`, `v_bar`.
DEVICE void force_adjoint(
    const Local& l, const Constants& c, const Place& p, u32 now, const Pairs& pairs, const float3* bends,
    const u32* refs, float3& x_bar, float3& v_bar, Sums& sums
) {
    float3 x_sum = zero3(), v_sum = zero3();
    Self self = self_of(l, now, p.node);
#if HELD > 0
#pragma unroll
    for (u32 k = 0; k < HELD_SUMS; k++) {
        if (k < p.pairs) {
            Pair pair = load_pair(pairs, p.first + k * 32);
            half_adjoint(l, self, first_of(pair, c.dashpot), x_sum, v_sum, sums.springs[2 * k]);
            half_adjoint(l, self, second_of(pair, c.dashpot), x_sum, v_sum, sums.springs[2 * k + 1]);
        }
    }
#endif
    // Those with sums come first; the others' are their other ends' business.
    u32 k = HELD_SUMS;
    for (; k < p.summed; k++)
        summed_pair(l, c, self, load_pair(pairs, p.first + k * 32), c.sums + p.sums + k * PAIR_SUMS,
                    x_sum, v_sum);
    SpringSums unwanted;
#pragma unroll 2
    for (; k < p.pairs; k++) {
        Pair pair = load_pair(pairs, p.first + k * 32);
        half_adjoint(l, self, first_of(pair, c.dashpot), x_sum, v_sum, unwanted);
        half_adjoint(l, self, second_of(pair, c.dashpot), x_sum, v_sum, unwanted);
    }
#if ONE_ROW
    meet_for_bends();
#endif
#if BENDING
    for_arms(p, refs, [&](u32 t, u32 role) { add_bend(bends, t, role, x_sum, v_sum); });
#endif
    x_sum = sum_lanes(x_sum);
    v_sum = sum_lanes(v_sum);
    x_bar = v_bar = zero3();
    // Lanes without a node keep their hands off the node that they look at: its own warp writes there.
    if (p.valid) {
        x_bar = add(xyz(bar_x_of(l)[p.node]), x_sum);
        v_bar = add(xyz(bar_v_of(l)[p.node]), v_sum);
    }
    __syncwarp();
}

// The control points' part of the second half.
DEVICE void control_adjoint(
    const Local& l, const Constants& c, u32 now, u32 substep, const Pairs& pairs, const float3* bends,
    const u32* refs
) {
    const Job& job = *l.job;
    if (!job.control_sums) return;
    const Topology& t = job.topology;
    const u32* rows = t.rows + l.share.row;
    u32 lane = threadIdx.x % LANES;
    for (u32 row = threadIdx.x / 32; row < l.share.control_rows; row += WARPS) {
        u32 control = row * NODES_A_ROW + threadIdx.x % 32 / LANES;
        bool valid = control < l.controls;
        u32 start = rows[l.share.rows + row], end = rows[l.share.rows + row + 1];
        float3 x_bar = zero3(), v_bar = zero3();
        Self self = self_of(l, now, l.control_base + (valid ? control : 0));
        u32 first = (start - rows[0]) * 32 + threadIdx.x % 32;
        SpringSums unwanted;
        for (u32 k = 0; k < end - start; k++) {
            Pair pair = load_pair(pairs, first + k * 32);
            half_adjoint(l, self, first_of(pair, c.dashpot), x_bar, v_bar, unwanted);
            half_adjoint(l, self, second_of(pair, c.dashpot), x_bar, v_bar, unwanted);
        }
        if (valid) {
            const u32* arms = t.arms + l.share.arm + l.share.own;
            for (u32 a = arms[control] + lane; BENDING && a < arms[control + 1]; a += LANES)
                add_bend(bends, refs[a] >> 2, refs[a] & 3, x_bar, v_bar);
        }
        x_bar = sum_lanes(x_bar);
        v_bar = sum_lanes(v_bar);
        if (valid && lane == 0) {
            float* to = job.control_sums + (u64)l.rank * 9 * l.controls;
            add_path(to, l.controls, control, progress(substep, c.substeps), x_bar, v_bar);
        }
    }
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

DEVICE void
store_sums(const Local& l, const Constants& c, const Place& p, const HeldTriplet& triplet, const Sums& sums) {
    const Job& job = *l.job;
#if HELD > 0
#pragma unroll
    for (u32 k = 0; k < HELD_SUMS; k++) {
        if (k >= p.summed) continue;
        float* to = job.spring_sums + p.sums + k * PAIR_SUMS;
        float before[6];
        for (u32 i = 0; i < 6; i++) before[i] = to[32 * i];
        add_sums(to, before, sums.springs[2 * k], sums.springs[2 * k + 1]);
    }
#endif
    if (triplet.has && triplet.ends.owned) {
        u32 at = job.topology.triplet_of[l.share.triplet + first_triplet()];
        job.bend_sums[at] += sums.bend_stiffness;
        job.bend_sums[job.triplets + at] += sums.bend_damping;
        job.bend_sums[2 * job.triplets + at] += sums.bend_rest;
    }
    float* laws = job.law_sums + 5 * l.rank;
    add_block_sum(-c.dt * sums.decay, laws);
    add_block_sum(sums.ground.restitution, laws + 1);
    add_block_sum(sums.ground.friction, laws + 2);
    add_block_sum(sums.object.restitution, laws + 3);
    add_block_sum(sums.object.friction, laws + 4);
}

#if ONE_ROW
#define FOR_PLACES(p)
#else
#define FOR_PLACES(p)                                                                            \
    for (u32 row = threadIdx.x / 32; row < l.share.rows; row += WARPS)                           \
        for (Place p = place_of(l, row), *once = &p; once; once = 0)
#endif

DEVICE void contact_half(
    Local& l, const Constants& c, const Place& one, u32 buffer, u32 tape, Sums& sums
) {
#if CONTACT
    meet(l.barrier, l.round);
#if ONE_ROW
    contact_adjoint(l, c, one, buffer, tape, sums);
#else
    FOR_PLACES(p) contact_adjoint(l, c, p, buffer, tape, sums);
#endif
#endif
}

DEVICE void meet_with_lambda(Local& l, const Halo& halo, u32 buffer) {
    wait_for_copies();
    meet_for_halo(l.arrivals, buffer, l.barrier, l.round);
    fetch_vectors(l, halo, buffer, lambda_of(l, buffer));
}

DEVICE void begin_frame_adjoint(const Local& l, const Place& p, float3& x_bar, float3& v_bar) {
    if (p.pin >= 0) {
        if (p.lane == 0) add_path(l.job->pin_sums, l.job->pins, p.pin, 0.0f, x_bar, v_bar);
        x_bar = v_bar = zero3();
    }
}

// Turns `Job::bar_*` at the end of substep `to` - 1 of frame `Job::first` into that at the start of
// substep `from`; substep `from` is the tape's first.
extern "C" __global__ void __launch_bounds__(THREADS) back_frame(const Job* all, u32 from, u32 to) {
    const Job& job = all[blockIdx.x / BLOCKS];
    Local l = local_of(&job, blockIdx.x % BLOCKS, sizeof(float4));
    Constants c = {job.dt,       job.decay,    job.ground, job.ground_law, job.dashpot, job.substeps,
                   job.topology.node_count, job.tape_x, job.tape_v, job.tape_b, job.pin_sums, job.spring_sums,
                   threadIdx.x < l.share.local ? job.tape_slots[l.graph_node(threadIdx.x)] : 0};
    u32 rows = l.share.rows + (job.control_sums ? l.share.control_rows : 0);
    Pairs pairs = pairs_of(l, rows, after_bars(l));
    float3* bends = bend_buffer(l);
    const u32* refs = job.topology.arm_refs;
    HeldTriplet triplet = triplet_at(l, first_triplet());
    Halo halo = halo_of(l);
    Sums sums = {};
    Place one = place_of(l, threadIdx.x / 32);
    for (u32 i = threadIdx.x; i < l.controls; i += THREADS) {
        lambda_of(l, 0)[l.control_base + i] = zero4();
        lambda_of(l, 1)[l.control_base + i] = zero4();
    }
    u32 now = 0;
    fetch_tape(l, c, now, to - 1 - from, to - 1);
    wait_for_copies();
    __syncthreads();
    // A cluster's blocks must all have started before one writes into another.
    meet(l.barrier, l.round);
    expect_halo(l.arrivals, now);
#if ONE_ROW
    node_adjoint(l, c, one, now, to - 1, to - 1 - from, entry_of(c, one, to - 1 - from),
                 xyz(job.bar_x[one.at]), xyz(job.bar_v[one.at]), sums);
#else
    FOR_PLACES(p) {
        node_adjoint(l, c, p, now, to - 1, to - 1 - from, entry_of(c, p, to - 1 - from),
                     xyz(job.bar_x[p.at]), xyz(job.bar_v[p.at]), sums);
    }
#endif
    contact_half(l, c, one, now, to - 1 - from, sums);
    meet_with_lambda(l, halo, now);
    for (u32 s = to; s-- > from;) {
        u32 earlier = now ^ 1;
        if (s > from) {
            expect_halo(l.arrivals, earlier);
            fetch_tape(l, c, earlier, s - 1 - from, s - 1);
        }
        bend_adjoints(l, now, bends, triplet, sums);
#if ONE_ROW
        {
            const Place& p = one;
#else
        FOR_PLACES(p) {
#endif
            float3 x_bar, v_bar;
            // Asked for early: it comes from far away.
            Entry entry = {};
            if (s > from) entry = entry_of(c, p, s - 1 - from);
            force_adjoint(l, c, p, now, pairs, bends, refs, x_bar, v_bar, sums);
            if (s > from) {
                node_adjoint(l, c, p, earlier, s - 1, s - 1 - from, entry, x_bar, v_bar, sums);
            } else if (p.valid) {
                if (from == 0) begin_frame_adjoint(l, p, x_bar, v_bar);
                if (p.lane == 0) {
                    job.bar_x[p.at] = with_w(x_bar, 0.0f);
                    job.bar_v[p.at] = with_w(v_bar, 0.0f);
                }
            }
        }
        control_adjoint(l, c, now, s, pairs, bends, refs);
        if (s > from) {
            contact_half(l, c, one, earlier, s - 1 - from, sums);
            meet_with_lambda(l, halo, earlier);
        }
        now = earlier;
    }
    store_sums(l, c, one, triplet, sums);
}
