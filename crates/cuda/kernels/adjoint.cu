// A frame backward: the adjoint of `integrate.cu`, substep by substep from the tape, in exactly the
// reverse order. Everything is gathered: a node adds up what it gets from its half-springs and triplets.
//
// A substep has two halves. `node_adjoint` turns d loss / d state at its end into that before forces
// acted, and into lambda = d loss / d force, which the neighbours need; `force_adjoint` adds what the
// forces say about the state that they saw. The second of a substep and the first of the one before it
// concern the same node, so the team meets once a substep (and once more for contact).

#define NOT_TAPED 0xffffffffu

// Beside the tape's states: lambda, two buffers; then what is carried from substep to substep.
DEVICE float4* lambda_of(const Local& l, u32 buffer) { return l.after_states(buffer * l.stride); }
DEVICE float4* bar_x_of(const Local& l) { return l.after_states(2 * l.stride); }
DEVICE float4* bar_v_of(const Local& l) {
    return l.after_states(2 * l.stride + l.job->topology.control_base);
}
DEVICE float4* after_bars(const Local& l) {
    return l.after_states(2 * l.stride + 2 * l.job->topology.control_base);
}
// d loss / d (x_i, x_k, v_i, v_k), by triplet.
DEVICE float4* bend_buffer(const Local& l) {
    u32 before = HALF_SPRINGS_IN_SHARED ? l.job->topology.max_all_entries : 0;
    return BEND_IN_SHARED ? after_bars(l) + before : l.spill();
}

struct Constants {
    float dt, decay;
    Ground ground;
    Law law;
};

// What a thread adds up over a launch.
struct Sums {
    float decay;
    Law ground, object;
    float bend_stiffness, bend_damping, bend_rest;  // of the thread's first triplet
#if HELD > 0
    SpringSums springs[HELD_SUMS];
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
DEVICE void fetch_tape(const Local& l, u32 buffer, u32 frame, u32 tape, u32 substep) {
    const Job& job = *l.job;
    const Topology& t = job.topology;
    const float4* xs = job.tape_x + (u64)tape * t.node_count;
    const float4* vs = job.tape_v + (u64)tape * t.node_count;
    for (u32 i = threadIdx.x; i < l.share.local; i += THREADS) {
        u32 at = l.graph_node(i);
        copy_async(l.x(buffer, 0) + i, xs + at);
        copy_async(l.v(buffer, 0) + i, vs + at);
    }
    Path path = path_of(job, frame);
    float progressed = progress(substep, job.substeps);
    for (u32 c = threadIdx.x; c < t.controls; c += THREADS) {
        float3 at = control_position(path, progressed, c);
        l.x(buffer, 0)[t.control_base + c] = with_w(at, 0.0f);
        l.v(buffer, 0)[t.control_base + c] = with_w(control_velocity(path, c), 0.0f);
    }
}

// From d loss / d velocity before contact to that before forces acted, and to lambda.
DEVICE void accelerate_adjoint(
    const Local& l, const Constants& c, const Place& p, u32 buffer, float3 before, float3 x_bar,
    float3 v_bar, Sums& sums
) {
    if (p.pin >= 0) {
        if (p.lane == 0)
            add_path(l.job->pin_sums, l.job->pins, p.pin, 0.0f, zero3(), v_bar);
        v_bar = zero3();
    }
    if (p.lane == 0) sums.decay += dot(v_bar, before);
    v_bar = scale(v_bar, c.decay);
    if (p.lane == 0) {
        bar_x_of(l)[p.node] = with_w(x_bar, 0.0f);
        bar_v_of(l)[p.node] = with_w(v_bar, 0.0f);
    }
    float4 lambda = with_w(scale(v_bar, p.inverse_mass * c.dt), 0.0f);
    publish(l, p, lambda_of(l, buffer), exchange_of(*l.job, buffer, 0), lambda);
}

// First half of a substep, `bar` being d loss / d state at its end. With contact it ends before the
// meeting that `contact_adjoint` needs.
DEVICE void node_adjoint(
    const Local& l, const Constants& c, const Place& p, u32 buffer, u32 substep, u32 tape, float3 x_bar,
    float3 v_bar, Sums& sums
) {
    const Job& job = *l.job;
    u64 at = (u64)tape * job.topology.node_count + p.at;
    float4 x4 = job.tape_x[at];
    float3 before = v3(x4.w, job.tape_v[at].w, job.tape_b[at]);
    if (p.pin >= 0) {
        float t = progress(substep, job.substeps);
        if (p.lane == 0) add_path(job.pin_sums, job.pins, p.pin, t, x_bar, v_bar);
        x_bar = v_bar = zero3();
    }
    float3 after = before;
    Law law_bar = {0.0f, 0.0f};
#if CONTACT
    u64 start = (u64)tape * job.topology.node_count;
    Taped nodes = {job.tape_x + start, job.tape_v + start, job.tape_b + start,
                   job.topology.inverse_mass};
    float touches;
    after = collide(job, nodes, p.at, p.valid, p.lane, touches);
#endif
#if GROUND
    advance_adjoint(c.ground, c.law, c.dt, xyz(x4), after, x_bar, v_bar, law_bar);
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
    u64 start = (u64)tape * job.topology.node_count;
    Taped nodes = {job.tape_x + start, job.tape_v + start, job.tape_b + start,
                   job.topology.inverse_mass};
    float3 x_bar = xyz(bar_x_of(l)[p.node]), v_bar = xyz(bar_v_of(l)[p.node]);
    __syncwarp();
    collide_adjoint(job, nodes, p.at, p.valid, p.lane, job.contact_v, x_bar, v_bar, sums.object);
    float4 x4;
    float3 before;
    nodes.load(p.at, x4, before);
    if (p.valid) accelerate_adjoint(l, c, p, buffer, before, x_bar, v_bar, sums);
}

DEVICE void bend_adjoints(const Local& l, u32 now, Sums& sums) {
#if BENDING
    const Job& job = *l.job;
    float4* out = bend_buffer(l);
    const float4 *x = l.x(now, 0), *v = l.v(now, 0), *lambda = lambda_of(l, now);
    for (u32 t = threadIdx.x; t < l.share.triplets; t += THREADS) {
        Triplet ends = job.topology.triplets[l.share.triplet + t];
        float4 packed = job.bends[l.share.triplet + t];
        BendParams p = {packed.x, packed.y, packed.z};
        float3 xj = xyz(x[ends.j]), vj = xyz(v[ends.j]), lj = xyz(lambda[ends.j]);
        BendAdjoint a = bend_adjoint(
            p, sub(xyz(x[ends.i]), xj), sub(xyz(x[ends.k]), xj), sub(xyz(v[ends.i]), vj),
            sub(xyz(v[ends.k]), vj), sub(xyz(lambda[ends.i]), lj), sub(xyz(lambda[ends.k]), lj));
        out[4 * t] = with_w(a.x_i, 0.0f);
        out[4 * t + 1] = with_w(a.x_k, 0.0f);
        out[4 * t + 2] = with_w(a.v_i, 0.0f);
        out[4 * t + 3] = with_w(a.v_k, 0.0f);
        if (t < THREADS) {
            sums.bend_stiffness += a.stiffness;
            sums.bend_damping += a.damping;
            sums.bend_rest += a.rest;
        } else if (ends.owned) {
            u32 at = job.topology.triplet_of[l.share.triplet + t];
            job.bend_sums[at] += a.stiffness;
            job.bend_sums[job.triplets + at] += a.damping;
            job.bend_sums[2 * job.triplets + at] += a.rest;
        }
    }
    __syncthreads();
#endif
}

// A lane's part of what an endpoint gets from its triplets.
DEVICE void bend_share(
    const Local& l, u32 arm, u32 arms, u32 lane, float3& x_bar, float3& v_bar
) {
#if BENDING
    const float4* in = bend_buffer(l);
    const u32* refs = l.job->topology.arm_refs;
    for (u32 a = arm + lane; a < arms; a += LANES) {
        u32 ref = refs[a];
        const float4* t = in + 4 * (ref >> 2);
        u32 role = ref & 3;
        if (role < 2) {
            x_bar = add(x_bar, xyz(t[role]));
            v_bar = add(v_bar, xyz(t[2 + role]));
        } else {
            x_bar = sub(x_bar, add(xyz(t[0]), xyz(t[1])));
            v_bar = sub(v_bar, add(xyz(t[2]), xyz(t[3])));
        }
    }
#endif
}

// d loss / d state of an endpoint through its half-springs.
DEVICE void spring_adjoints(
    const Local& l, u32 self, u32 first, u32 slots, bool is_node, u32 now, const float4* half_springs,
    float3& x_bar, float3& v_bar, Sums& sums
) {
    const float4 *xs = l.x(now, 0), *vs = l.v(now, 0), *lambdas = lambda_of(l, now);
    float3 x = xyz(xs[self]), v = xyz(vs[self]), lambda = xyz(lambdas[self]);
#if HELD > 0
    if (is_node) {
#pragma unroll
        for (u32 s = 0; s < HELD; s++) {
            if (s < slots) {
                HalfSpring h = half_spring(half_springs[first + s * 32]);
                float3 r = sub(xyz(xs[h.other]), x), w = sub(xyz(vs[h.other]), v);
                float3 pull = sub(lambda, xyz(lambdas[h.other]));
                SpringSums unwanted = {0.0f, 0.0f, 0.0f};
                spring_adjoint(h, r, w, pull, x_bar, v_bar,
                               s < HELD_SUMS ? sums.springs[s < HELD_SUMS ? s : 0] : unwanted);
            }
        }
        return;
    }
#endif
    const int* spring_of = l.job->topology.spring_of + (u64)l.job->topology.rows[l.share.row] * 32;
    for (u32 s = 0; s < slots; s++) {
        u32 e = first + s * 32;
        HalfSpring h = half_spring(half_springs[e]);
        float3 r = sub(xyz(xs[h.other]), x), w = sub(xyz(vs[h.other]), v);
        float3 pull = sub(lambda, xyz(lambdas[h.other]));
        SpringSums own = {0.0f, 0.0f, 0.0f};
        spring_adjoint(h, r, w, pull, x_bar, v_bar, own);
        int spring = spring_of[e];
        if (spring >= 0) {
            float* to = l.job->spring_sums + spring;
            to[0] += own.stretch;
            to[l.job->springs] += own.pull;
            to[2 * (u64)l.job->springs] += own.rate;
        }
    }
}

// Second half of a substep for a node; leaves d loss / d state at its start in `x_bar`, `v_bar`.
DEVICE void force_adjoint(
    const Local& l, const Place& p, u32 now, const float4* half_springs, float3& x_bar, float3& v_bar,
    Sums& sums
) {
    float3 x_sum = zero3(), v_sum = zero3();
    spring_adjoints(l, p.node, p.first, p.slots, true, now, half_springs, x_sum, v_sum, sums);
    bend_share(l, p.arm, p.arms, p.lane, x_sum, v_sum);
    x_sum = sum_lanes(x_sum);
    v_sum = sum_lanes(v_sum);
    x_bar = add(xyz(bar_x_of(l)[p.node]), x_sum);
    v_bar = add(xyz(bar_v_of(l)[p.node]), v_sum);
    __syncwarp();
}

// The control points' part of the second half.
DEVICE void control_adjoint(
    const Local& l, u32 now, u32 substep, const float4* half_springs, Sums& sums
) {
    const Job& job = *l.job;
    const Topology& t = job.topology;
    if (!job.control_sums) return;
    const u32* rows = t.rows + l.share.row;
    u32 lane = threadIdx.x % LANES;
    for (u32 row = threadIdx.x / 32; row < l.share.control_rows; row += WARPS) {
        u32 c = row * NODES_A_ROW + threadIdx.x % 32 / LANES;
        bool valid = c < t.controls;
        u32 self = t.control_base + (valid ? c : 0);
        u32 start = rows[l.share.rows + row], end = rows[l.share.rows + row + 1];
        float3 x_bar = zero3(), v_bar = zero3();
        u32 first = (start - rows[0]) * 32 + threadIdx.x % 32;
        spring_adjoints(l, self, first, end - start, false, now, half_springs, x_bar, v_bar, sums);
        if (valid) {
            const u32* arms = t.arms + l.share.arm + l.share.own;
            bend_share(l, arms[c], arms[c + 1], lane, x_bar, v_bar);
        }
        x_bar = sum_lanes(x_bar);
        v_bar = sum_lanes(v_bar);
        if (valid && lane == 0) {
            float* to = job.control_sums + (u64)l.rank * 9 * t.controls;
            add_path(to, t.controls, c, progress(substep, job.substeps), x_bar, v_bar);
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

DEVICE void store_sums(const Local& l, const Constants& c, const Place& p, const Sums& sums) {
    const Job& job = *l.job;
#if HELD > 0
    if (p.valid) {
        const int* spring_of = job.topology.spring_of + (u64)job.topology.rows[l.share.row] * 32;
#pragma unroll
        for (u32 s = 0; s < HELD_SUMS; s++) {
            int spring = s < p.slots ? spring_of[p.first + s * 32] : -1;
            if (spring >= 0) {
                float* to = job.spring_sums + spring;
                to[0] += sums.springs[s].stretch;
                to[job.springs] += sums.springs[s].pull;
                to[2 * (u64)job.springs] += sums.springs[s].rate;
            }
        }
    }
#endif
#if BENDING
    if (threadIdx.x < l.share.triplets &&
        job.topology.triplets[l.share.triplet + threadIdx.x].owned) {
        u32 at = job.topology.triplet_of[l.share.triplet + threadIdx.x];
        job.bend_sums[at] += sums.bend_stiffness;
        job.bend_sums[job.triplets + at] += sums.bend_damping;
        job.bend_sums[2 * job.triplets + at] += sums.bend_rest;
    }
#endif
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
    meet(l.job->barrier, l.round);
#if ONE_ROW
    contact_adjoint(l, c, one, buffer, tape, sums);
#else
    FOR_PLACES(p) contact_adjoint(l, c, p, buffer, tape, sums);
#endif
#endif
}

DEVICE void meet_with_lambda(Local& l, u32 buffer) {
    wait_for_copies();
    meet(l.job->barrier, l.round);
    fetch_halo(l, lambda_of(l, buffer), exchange_of(*l.job, buffer, 0));
#if SHAPE == SHAPE_GRID
    __syncthreads();
#endif
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
    const Job* own = all + blockIdx.x / BLOCKS;
    Local l = local_of(own, blockIdx.x % BLOCKS);
    const Job& job = *own;
    const Topology& t = job.topology;
    Constants c = {job.dt, job.decay, job.ground, job.ground_law};
    const float4* half_springs = job.half_springs + (u64)t.rows[l.share.row] * 32;
#if HALF_SPRINGS_IN_SHARED
    float4* near = after_bars(l);
    u32 last_row = l.share.row + l.share.rows + l.share.control_rows;
    u32 entries = (t.rows[last_row] - t.rows[l.share.row]) * 32;
    for (u32 e = threadIdx.x; e < entries; e += THREADS) near[e] = half_springs[e];
    half_springs = near;
#endif
    Sums sums = {};
    Place one = place_of(l, threadIdx.x / 32);
    for (u32 i = threadIdx.x; i < t.controls; i += THREADS) {
        lambda_of(l, 0)[t.control_base + i] = zero4();
        lambda_of(l, 1)[t.control_base + i] = zero4();
    }
    u32 now = 0;
    fetch_tape(l, now, job.first, to - 1 - from, to - 1);
    wait_for_copies();
    __syncthreads();
    // A cluster's blocks must all have started before one writes into another.
    meet(job.barrier, l.round);
#if ONE_ROW
    node_adjoint(l, c, one, now, to - 1, to - 1 - from, xyz(job.bar_x[one.at]),
                 xyz(job.bar_v[one.at]), sums);
#else
    FOR_PLACES(p) {
        node_adjoint(l, c, p, now, to - 1, to - 1 - from, xyz(job.bar_x[p.at]),
                     xyz(job.bar_v[p.at]), sums);
    }
#endif
    contact_half(l, c, one, now, to - 1 - from, sums);
    meet_with_lambda(l, now);
    for (u32 s = to; s-- > from;) {
        u32 earlier = now ^ 1;
        if (s > from) fetch_tape(l, earlier, job.first, s - 1 - from, s - 1);
        bend_adjoints(l, now, sums);
#if ONE_ROW
        {
            const Place& p = one;
#else
        FOR_PLACES(p) {
#endif
            float3 x_bar, v_bar;
            force_adjoint(l, p, now, half_springs, x_bar, v_bar, sums);
            if (s > from) {
                node_adjoint(l, c, p, earlier, s - 1, s - 1 - from, x_bar, v_bar, sums);
            } else if (p.valid) {
                if (from == 0) begin_frame_adjoint(l, p, x_bar, v_bar);
                if (p.lane == 0) {
                    job.bar_x[p.at] = with_w(x_bar, 0.0f);
                    job.bar_v[p.at] = with_w(v_bar, 0.0f);
                }
            }
        }
        control_adjoint(l, now, s, half_springs, sums);
        if (s > from) contact_half(l, c, one, earlier, s - 1 - from, sums);
        meet_with_lambda(l, earlier);
        now = earlier;
    }
    store_sums(l, c, one, sums);
}
