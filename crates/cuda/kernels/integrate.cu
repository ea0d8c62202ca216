// Frames forward: all substeps of all frames of a launch without leaving the kernel. For every substep:
// forces, velocities, contact between nodes, ground, pins, in the order of the model's definition.
//
// Jobs come in groups of INSTANCES that share a graph and its parameters, so that a half-spring is
// loaded once for all of them. The lanes of a node sum their forces by shuffles in a fixed order, and all
// of them then know the node's new state.

// What all substeps need, kept in registers.
struct Constants {
    float3 kick;
    float dt, decay;
    Ground ground;
    Law law;
};

DEVICE Constants constants_of(const Job& job) {
    Constants c;
    c.kick = load_v3(job.kick);
    c.dt = job.dt;
    c.decay = job.decay;
    c.ground = job.ground;
    c.law = job.ground_law;
    return c;
}

// Forces of the ends i and k, by triplet and instance.
DEVICE float4* bend_buffer(const Local& l) {
    u32 before = HALF_SPRINGS_IN_SHARED ? l.job->topology.max_entries : 0;
    return BEND_IN_SHARED ? l.after_states(before) : l.spill();
}

DEVICE void bend_forces(const Local& l, u32 now) {
#if BENDING
    float4* forces = bend_buffer(l);
    const Triplet* triplets = l.job->topology.triplets + l.share.triplet;
    const float4* bends = l.job->bends + l.share.triplet;
    for (u32 t = threadIdx.x; t < l.share.triplets; t += THREADS) {
        Triplet ends = triplets[t];
        float4 packed = bends[t];
        BendParams p = {packed.x, packed.y, packed.z};
#pragma unroll
        for (u32 m = 0; m < INSTANCES; m++) {
            const float4 *x = l.x(now, m), *v = l.v(now, m);
            float3 xj = xyz(x[ends.j]), vj = xyz(v[ends.j]);
            float3 f_i, f_k;
            bend_force(p, sub(xyz(x[ends.i]), xj), sub(xyz(x[ends.k]), xj),
                       sub(xyz(v[ends.i]), vj), sub(xyz(v[ends.k]), vj), f_i, f_k);
            forces[(t * INSTANCES + m) * 2] = with_w(f_i, 0.0f);
            forces[(t * INSTANCES + m) * 2 + 1] = with_w(f_k, 0.0f);
        }
    }
    __syncthreads();
#endif
}

// A lane's part of the forces of its node's triplets.
DEVICE float3 bend_share(const Local& l, const Place& p, u32 m) {
    float3 sum = zero3();
#if BENDING
    const float4* forces = bend_buffer(l);
    const u32* refs = l.job->topology.arm_refs;
    for (u32 a = p.arm + p.lane; a < p.arms; a += LANES) {
        u32 ref = refs[a];
        u32 at = ((ref >> 2) * INSTANCES + m) * 2;
        u32 role = ref & 3;
        if (role < 2) {
            sum = add(sum, xyz(forces[at + role]));
        } else {
            sum = sub(sum, add(xyz(forces[at]), xyz(forces[at + 1])));
        }
    }
#endif
    return sum;
}

// Velocity of a node before contact.
DEVICE float3 accelerate(const Constants& c, float inverse_mass, float3 force, float3 v) {
    float3 change = add_scaled(c.kick, inverse_mass * c.dt, force);
    return scale(add(v, change), c.decay);
}

// Ends a node's substep: from its velocity after contact to its new state, for everyone to see.
DEVICE void travel(
    const Local& l, const Constants& c, const Place& p, u32 m, u32 now, float3 x, float3 before,
    float3 after, u32 tape
) {
    const Job& job = *l.job;
#if TAPE
    // Substeps before the segment on tape have wrapped around to large numbers.
    if (p.lane == 0 && tape < 0x80000000u) {
        u64 at = (u64)tape * job.topology.node_count + p.at;
        job.tape_x[at] = with_w(x, before.x);
        job.tape_v[at] = with_w(xyz(l.v(now, m)[p.node]), before.y);
        job.tape_b[at] = before.z;
    }
#endif
    float3 v = after;
    if (p.pin >= 0) {
        Pin pin = job.topology.pins[p.pin];
        u32 control = job.topology.control_base + pin.control;
        x = add(xyz(l.x(now, m)[control]), load_v3(pin.offset));
        v = xyz(l.v(now, m)[control]);
    } else {
#if GROUND
        advance(c.ground, c.law, c.dt, x, v);
#else
        x = add_scaled(x, c.dt, v);
#endif
    }
    publish(l, p, l.x(now ^ 1, m), exchange_of(job, now ^ 1, 0), with_w(x, 0.0f));
    publish(l, p, l.v(now ^ 1, m), exchange_of(job, now ^ 1, 1), with_w(v, 0.0f));
}

// The half-springs of the one row that a warp has, in registers.
struct Held {
#if HELD > 0
    HalfSpring springs[HELD];
#endif
};

DEVICE void work_on(
    const Local& l, const Constants& c, const Place& p, const Held& held, u32 now, u32 tape,
    const float4* half_springs
) {
    float3 x[INSTANCES], v[INSTANCES], force[INSTANCES];
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++) {
        x[m] = xyz(l.x(now, m)[p.node]);
        v[m] = xyz(l.v(now, m)[p.node]);
        force[m] = zero3();
    }
#if HELD > 0
#pragma unroll
    for (u32 s = 0; s < HELD; s++) {
        const HalfSpring& h = held.springs[s];
#else
#pragma unroll 4
    for (u32 s = 0; s < p.slots; s++) {
        HalfSpring h = half_spring(half_springs[p.first + s * 32]);
#endif
#pragma unroll
        for (u32 m = 0; m < INSTANCES; m++) {
            float3 r = sub(xyz(l.x(now, m)[h.other]), x[m]);
            float3 w = sub(xyz(l.v(now, m)[h.other]), v[m]);
            spring_force(h, r, w, force[m]);
        }
    }
#pragma unroll
    for (u32 m = 0; m < INSTANCES; m++) {
        float3 total = sum_lanes(add(force[m], bend_share(l, p, m)));
        float3 before = accelerate(c, p.inverse_mass, total, v[m]);
        if (p.pin >= 0) {
            u32 control = l.job->topology.pins[p.pin].control;
            before = xyz(l.v(now, m)[l.job->topology.control_base + control]);
        }
#if CONTACT
        if (p.valid && p.lane == 0) {
            __stcg(l.job->contact_x + p.at, with_w(x[m], p.inverse_mass));
            __stcg(l.job->contact_v + p.at, with_w(before, 0.0f));
        }
#else
        if (p.valid) travel(l, c, p, m, now, x[m], before, before, tape);
#endif
    }
}

DEVICE void work_on_contact(
    const Local& l, const Constants& c, const Place& p, u32 now, u32 tape
) {
    const Job& job = *l.job;
    float touches;
    Live nodes = {job.contact_x, job.contact_v};
    float3 after = collide(job, nodes, p.at, p.valid, p.lane, touches);
    float3 before = xyz(__ldcg(job.contact_v + p.at));
    if (p.valid) travel(l, c, p, 0, now, xyz(l.x(now, 0)[p.node]), before, after, tape);
}

// A frame of a job; one that has ended stays in its last.
DEVICE u32 frame_of(const Job& job, u32 frame) {
    return job.first + min(frame, max(job.frames, 1u) - 1);
}

// Control points and pinned nodes stand at the frame's start, and move.
DEVICE void begin_frame(const Local& l, const Job* jobs, u32 now, u32 frame) {
    const Topology& t = l.job->topology;
    for (u32 m = 0; m < INSTANCES; m++) {
        Path path = path_of(jobs[m], frame_of(jobs[m], frame));
        for (u32 c = threadIdx.x; c < t.controls; c += THREADS) {
            float3 at = control_position(path, progress(0, jobs[m].substeps), c);
            float4 velocity = with_w(control_velocity(path, c), 0.0f);
            l.x(now, m)[t.control_base + c] = with_w(at, 0.0f);
            l.v(now, m)[t.control_base + c] = velocity;
            l.v(now ^ 1, m)[t.control_base + c] = velocity;
        }
        for (u32 i = threadIdx.x; i < l.share.pins; i += THREADS) {
            LocalPin local = t.local_pins[l.share.pin + i];
            Pin pin = t.pins[local.pin];
            float3 held = load_v3(path.from + 3 * pin.control);
            l.x(now, m)[local.local] = with_w(add(held, load_v3(pin.offset)), 0.0f);
            l.v(now, m)[local.local] = with_w(control_velocity(path, pin.control), 0.0f);
        }
    }
    __syncthreads();
}

DEVICE void place_controls(const Local& l, const Job* jobs, u32 next, u32 frame, u32 substep) {
    const Topology& t = l.job->topology;
    for (u32 m = 0; m < INSTANCES; m++) {
        Path path = path_of(jobs[m], frame_of(jobs[m], frame));
        for (u32 c = threadIdx.x; c < t.controls; c += THREADS) {
            float3 at = control_position(path, progress(substep, jobs[m].substeps), c);
            l.x(next, m)[t.control_base + c] = with_w(at, 0.0f);
        }
    }
}

DEVICE void load_states(const Local& l, const Job* jobs, u32 now, u32 frame) {
    u32 n = l.job->topology.node_count;
    for (u32 m = 0; m < INSTANCES; m++) {
        const float* s = jobs[m].states + (u64)(frame_of(jobs[m], frame) % jobs[m].slots) * 6 * n;
        for (u32 i = threadIdx.x; i < l.share.local; i += THREADS) {
            u32 g = l.graph_node(i);
            l.x(now, m)[i] = make_float4(s[g], s[n + g], s[2 * n + g], 0.0f);
            l.v(now, m)[i] = make_float4(s[3 * n + g], s[4 * n + g], s[5 * n + g], 0.0f);
        }
    }
    __syncthreads();
}

// Nodes farther out than 1 km, or not finite, have diverged.
DEVICE bool inside(float4 x, float4 v) {
    return fabsf(x.x) <= 1000.0f && fabsf(x.y) <= 1000.0f && fabsf(x.z) <= 1000.0f &&
           isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

DEVICE void store_states(const Local& l, const Job* jobs, u32 now, u32 frame) {
    u32 n = l.job->topology.node_count;
    for (u32 m = 0; m < INSTANCES; m++) {
        const Job& job = jobs[m];
        if (frame >= job.frames) continue;
        u32 reached = job.first + frame + 1;
        float* s = job.states + (u64)(reached % job.slots) * 6 * n;
        for (u32 i = threadIdx.x; i < l.share.own; i += THREADS) {
            u32 g = l.graph_node(i);
            float4 x = l.x(now, m)[i], v = l.v(now, m)[i];
            s[g] = x.x;
            s[n + g] = x.y;
            s[2 * n + g] = x.z;
            s[3 * n + g] = v.x;
            s[4 * n + g] = v.y;
            s[5 * n + g] = v.z;
            if (!inside(x, v)) atomicMin(job.divergence, (u64)reached << 32 | g);
        }
    }
    __syncthreads();
}

DEVICE u32 longest(const Job* jobs) {
    u32 longest = 0;
    for (u32 m = 0; m < INSTANCES; m++) longest = max(longest, jobs[m].frames);
    return longest;
}

// Runs frames `first..end` of each job's. With TAPE: one frame as far as substep `to`, on tape from `from`
// on; it ends without a state.
extern "C" __global__ void __launch_bounds__(THREADS)
    advance_frames(const Job* all, u32 first, u32 end, u32 from, u32 to) {
    const Job* jobs = all + (u64)(blockIdx.x / BLOCKS) * INSTANCES;
    Local l = local_of(jobs, blockIdx.x % BLOCKS);
    const Topology& t = jobs->topology;
    const float4* half_springs = jobs->half_springs + (u64)t.rows[l.share.row] * 32;
#if HALF_SPRINGS_IN_SHARED
    float4* near = l.after_states(0);
    u32 entries = (t.rows[l.share.row + l.share.rows] - t.rows[l.share.row]) * 32;
    for (u32 e = threadIdx.x; e < entries; e += THREADS) near[e] = half_springs[e];
    half_springs = near;
#endif
    Constants c = constants_of(*jobs);
    Held held;
#if ONE_ROW
    Place p = place_of(l, threadIdx.x / 32);
#if HELD > 0
#pragma unroll
    for (u32 s = 0; s < HELD; s++) {
        // A slot that the row does not have joins the node with itself, without stiffness.
        float4 none = make_float4(0.0f, 0.0f, 0.0f, __int_as_float((int)p.node));
        held.springs[s] = half_spring(s < p.slots ? half_springs[p.first + s * 32] : none);
    }
#endif
#endif
    u32 now = 0;
    load_states(l, jobs, now, first);
    // A cluster's blocks must all have started before one writes into another.
    meet(jobs->barrier, l.round);
    u32 last_frame = min(end, longest(jobs));
    for (u32 frame = first; frame < last_frame; frame++) {
        begin_frame(l, jobs, now, frame);
        u32 last = TAPE ? to : jobs->substeps;
        for (u32 s = 0; s < last; s++) {
            bend_forces(l, now);
#if ONE_ROW
            work_on(l, c, p, held, now, s - from, half_springs);
#else
            for (u32 row = threadIdx.x / 32; row < l.share.rows; row += WARPS)
                work_on(l, c, place_of(l, row), held, now, s - from, half_springs);
#endif
#if CONTACT
            meet(jobs->barrier, l.round);
#if ONE_ROW
            work_on_contact(l, c, p, now, s - from);
#else
            for (u32 row = threadIdx.x / 32; row < l.share.rows; row += WARPS)
                work_on_contact(l, c, place_of(l, row), now, s - from);
#endif
#endif
            now ^= 1;
            place_controls(l, jobs, now, frame, s + 1);
            meet(jobs->barrier, l.round);
            fetch_halo(l, l.x(now, 0), exchange_of(*jobs, now, 0));
            fetch_halo(l, l.v(now, 0), exchange_of(*jobs, now, 1));
#if SHAPE == SHAPE_GRID
            __syncthreads();
#endif
        }
        if (!TAPE) store_states(l, jobs, now, frame);
    }
    // None may end while another still writes into it.
    meet(jobs->barrier, l.round);
}
