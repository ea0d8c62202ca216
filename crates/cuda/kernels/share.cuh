// Storage of a block. In shared memory: local state, two buffers of it per instance, a node in a
// float4 and a float2; then the half-springs, if they are held there; then what triplets exert, if
// it fits, or else in the block's spill. Values of global memory that every substep needs are read
// once, into registers.

#define NODES_A_ROW (32 / LANES)
// Floats of a warp's pairs' sums.
#define PAIR_SUMS (6 * 32)
#define WARPS (THREADS / 32)
// Halos that a lane writes its node's new state to, and halo nodes that a thread fetches, held in
// registers.
#define HELD_EXPORTS 2
#define HELD_HALO 4
// References to its node's triplets that a lane holds in registers.
#define HELD_ARMS 4
#define NO_ARM 0xffffffffu
// Roles of an endpoint in a triplet, and the reference to what triplet t exerts on it: 32 triplets
// stand together, for each role 32 numbers of each component.
#define ROLE_I 0
#define ROLE_K 1
#define ROLE_J 2
#define ROLES 3
#define VECTORS (3 * 32)  // numbers of 32 vectors
DEVICE u32 arm_ref(u32 t, u32 role) { return (t / 32 * ROLES + role) * VECTORS + t % 32; }
DEVICE u32 triplet_of(u32 ref) { return ref / (ROLES * VECTORS) * 32 + ref % 32; }
DEVICE u32 role_of(u32 ref) { return ref % (ROLES * VECTORS) / VECTORS; }

struct State {
    float3 x, v;
};

struct BlockState {
    const InstanceArgs* instance;
    Share share;
    u32 rank;    // of this block in its team
    u32 stride;
    u32 round;   // arrivals of a grid's blocks so far
    u32 control_base, controls;
    u32* barrier;
    Arrivals arrivals;

    // x, y, z, vx.
    DEVICE_MEMBER float4* xs(u32 buffer, u32 m) const {
        return shared_memory + (buffer * INSTANCES + m) * stride;
    }
    // vy, vz.
    DEVICE_MEMBER float2* vs(u32 buffer, u32 m) const {
        return reinterpret_cast<float2*>(shared_memory + 2 * INSTANCES * stride) +
               (buffer * INSTANCES + m) * stride;
    }
    DEVICE_MEMBER State state(u32 buffer, u32 m, u32 local) const {
        float4 a = xs(buffer, m)[local];
        float2 b = vs(buffer, m)[local];
        State s;
        s.x = xyz(a);
        s.v = v3(a.w, b.x, b.y);
        return s;
    }
    DEVICE_MEMBER void put(u32 buffer, u32 m, u32 local, float3 x, float3 v) const {
        xs(buffer, m)[local] = with_w(x, v.x);
        vs(buffer, m)[local] = make_float2(v.y, v.z);
    }
    // Shared memory behind the states, from `offset` float4s on.
    DEVICE_MEMBER float4* after_states(u32 offset) const {
        return shared_memory + 3 * INSTANCES * stride + offset;
    }
    DEVICE_MEMBER float4* spill() const {
        return instance->team.spill + (u64)rank * instance->team.spill_stride;
    }
    DEVICE_MEMBER u32 graph_node(u32 local) const {
        return instance->topology.nodes[share.nodes + local];
    }
};

// An array of shared memory that indices will be added to: its address is kept in a register, or
// the compiler would compute it again for every index.
template <class T>
DEVICE const T* opaque_shared(const T* p) {
    u32 address = shared_address(p);
    asm volatile("" : "+r"(address));
    return reinterpret_cast<const T*>(__cvta_shared_to_generic(address));
}

DEVICE State state_at(const float4* xs, const float2* vs, u32 local) {
    float4 a = xs[local];
    float2 b = vs[local];
    State s;
    s.x = xyz(a);
    s.v = v3(a.w, b.x, b.y);
    return s;
}

// `halo_bytes` are those that a node in a halo receives in a substep.
DEVICE BlockState block_state_of(const InstanceArgs* instance, u32 rank, u32 halo_bytes) {
    BlockState l;
    l.instance = instance;
    l.rank = rank;
    l.share = instance->topology.shares[rank];
    l.stride = instance->topology.stride;
    l.round = 0;
    l.control_base = instance->topology.control_base;
    l.controls = instance->topology.control_count;
    l.barrier = instance->team.barrier;
    l.arrivals = count_bytes((l.share.local - l.share.own) * halo_bytes);
    return l;
}

// Puts a control point where it is at a share of a frame of the rollout.
DEVICE void put_control(
    const BlockState& l, const InstanceArgs& instance, u32 buffer, u32 m, u32 control, u32 frame,
    float t
) {
    Path path = path_of(instance, frame);
    float3 x = control_position(path, t, control), v = control_velocity(path, control);
#if GRASPS
    if (is_released(instance, frame, control)) {
        x = v3(FAR_M, FAR_M, FAR_M);
        v = zero3();
    }
#endif
    l.put(buffer, m, l.control_base + control, x, v);
}

// Float4s that `pairs` pairs of half-springs take.
DEVICE u32 pairs_size(u32 pairs) {
    u32 floats = UNIFORM_DASHPOT ? 5 : 7;
    return (pairs * floats + 3) / 4;
}

// The half-springs of rows `0..rows` of a block: where they are, after a copy to `near` if they are
// held there.
DEVICE Pairs pairs_of(const BlockState& l, u32 rows, float4* near) {
    const TopologyArgs& t = l.instance->topology;
    u32 first = t.rows[l.share.row] * 32;
    Pairs far = {
        l.instance->parameters.rates + first, l.instance->parameters.others + first,
        l.instance->parameters.dashpots + first
    };
#if HALF_SPRINGS_IN_SHARED
    u32 count = t.rows[l.share.row + rows] * 32 - first;
    float4* rates = near;
    float2* dashpots = reinterpret_cast<float2*>(rates + count);
    u32* others = reinterpret_cast<u32*>(UNIFORM_DASHPOT ? dashpots : dashpots + count);
    for (u32 i = threadIdx.x; i < count; i += THREADS) {
        rates[i] = far.rates[i];
        others[i] = far.others[i];
        if (!UNIFORM_DASHPOT) dashpots[i] = far.dashpots[i];
    }
    Pairs here = {rates, others, dashpots};
    return here;
#else
    return far;
#endif
}

// Data of the node that a thread works on: one of a row of NODES_A_ROW, LANES lanes to each.
struct ThreadNode {
    u32 node;             // local index; a lane without a node reads node 0 and writes nothing
    u32 at;               // graph index
    u32 slot;             // where it is on tape; known in the backward pass only
    u32 lane;             // which of the node's lanes this is
    bool valid;
    int pin;              // -1 if it is free
    u32 pin_control;      // local index of its control point
    float3 pin_offset;
    float inverse_mass;
    u32 first, pairs;     // its half-springs: every 32nd pair from `first` on
    u32 summed, sums;     // how many of them, from the first on, have sums, and where
    u32 arm, arms;        // references to triplets: every 32nd from `arm` on, `arms` slots
    u32 held_arms[HELD_ARMS];
    u32 export_from, exports; // its export references; the first of them:
    u32 refs[HELD_EXPORTS];
};

DEVICE ThreadNode thread_node_of(const BlockState& l, u32 row) {
    const TopologyArgs& t = l.instance->topology;
    ThreadNode p;
    p.lane = threadIdx.x % LANES;
    u32 node = row * NODES_A_ROW + threadIdx.x % 32 / LANES;
    p.valid = row < l.share.rows && node < l.share.own;
    p.node = p.valid ? node : 0;
    p.at = l.share.own > 0 ? l.graph_node(p.node) : 0;
    p.slot = l.instance->tape.slot_of ? l.instance->tape.slot_of[p.at] : 0;
    p.pin = p.valid ? t.pin_of[p.at] : -1;
    p.pin_control = 0;
    p.pin_offset = zero3();
    if (p.pin >= 0) {
        p.pin_control = l.control_base + t.pins[p.pin].control;
        p.pin_offset = load_v3(t.pins[p.pin].offset);
    }
    p.inverse_mass = p.valid ? t.inverse_mass[p.at] : 0.0f;
    const u32* rows = t.rows + l.share.row;
    bool has_row = row < l.share.rows;
    p.first = has_row ? (rows[row] - rows[0]) * 32 + threadIdx.x % 32 : 0;
    p.pairs = has_row ? rows[row + 1] - rows[row] : 0;
    const u32* sums = t.sum_rows + l.share.row;
    p.summed = has_row ? sums[row + 1] - sums[row] : 0;
    p.sums = has_row ? sums[row] * PAIR_SUMS + threadIdx.x % 32 : 0;
    const u32* arm_rows = t.arm_rows + l.share.row;
    p.arm = has_row ? arm_rows[row] * 32 + threadIdx.x % 32 : 0;
    p.arms = has_row ? arm_rows[row + 1] - arm_rows[row] : 0;
    p.export_from = p.exports = 0;
    if (p.valid) {
        p.export_from = t.exports[l.share.export_start + p.node] + p.lane;
        p.exports = t.exports[l.share.export_start + p.node + 1];
    }
#if BENDING
#pragma unroll
    for (u32 k = 0; k < HELD_ARMS; k++)
        p.held_arms[k] = k < p.arms ? t.arm_refs[p.arm + k * 32] : NO_ARM;
#endif
#if SHAPE == SHAPE_CLUSTER
#pragma unroll
    for (u32 k = 0; k < HELD_EXPORTS; k++) {
        u32 e = p.export_from + k * LANES;
        p.refs[k] = e < p.exports ? t.export_refs[e] : 0xffffffffu;
    }
#endif
    return p;
}

// Calls `publish(block, local index there)` for the halos that this lane writes its node to.
template <class Publish>
DEVICE void for_exports(const BlockState& l, const ThreadNode& p, Publish publish) {
#pragma unroll
    for (u32 k = 0; k < HELD_EXPORTS; k++) {
        if (p.refs[k] != 0xffffffffu) publish(p.refs[k] >> 16, p.refs[k] & 0xffff);
    }
    for (u32 e = p.export_from + HELD_EXPORTS * LANES; e < p.exports; e += LANES) {
        u32 ref = l.instance->topology.export_refs[e];
        publish(ref >> 16, ref & 0xffff);
    }
}

// Writes a node's new state here and, its lanes together, into all halos that it belongs to.
DEVICE void
publish_state(const BlockState& l, const ThreadNode& p, u32 next, u32 m, float3 x, float3 v) {
    float4 a = with_w(x, v.x);
    float2 b = make_float2(v.y, v.z);
    float4* xs = l.xs(next, m);
    float2* vs = l.vs(next, m);
    if (p.lane == 0) {
        xs[p.node] = a;
        vs[p.node] = b;
    }
#if SHAPE == SHAPE_CLUSTER
    for_exports(l, p, [&](u32 block, u32 there) {
        send(xs + there, l.arrivals.of(next), block, a);
        send(vs + there, l.arrivals.of(next), block, b);
    });
#elif SHAPE == SHAPE_GRID
    u32 n = l.instance->topology.node_count;
    if (p.lane == 0) {
        __stcg(l.instance->team.exchange_x + next * (u64)n + p.at, a);
        __stcg(l.instance->team.exchange_v + next * (u64)n + p.at, b);
    }
#endif
}

// The same for a vector that stands in `here`.
DEVICE void
publish_vector(const BlockState& l, const ThreadNode& p, u32 next, float4* here, float4 value) {
    if (p.lane == 0) here[p.node] = value;
#if SHAPE == SHAPE_CLUSTER
    for_exports(l, p, [&](u32 block, u32 there) {
        send(here + there, l.arrivals.of(next), block, value);
    });
#elif SHAPE == SHAPE_GRID
    if (p.lane == 0)
        __stcg(
            l.instance->team.exchange_x + next * (u64)l.instance->topology.node_count + p.at, value
        );
#endif
}

// Graph indices of the halo nodes that a thread fetches, for a grid's blocks.
struct Halo {
    u32 at[HELD_HALO];
    u32 nodes;
};

DEVICE Halo halo_of(const BlockState& l) {
    Halo h;
    h.nodes = 0;
#if SHAPE == SHAPE_GRID
    h.nodes = l.instance->topology.node_count;
#pragma unroll
    for (u32 k = 0; k < HELD_HALO; k++) {
        u32 i = l.share.own + threadIdx.x + k * THREADS;
        h.at[k] = i < l.share.local ? l.graph_node(i) : 0xffffffffu;
    }
#endif
    return h;
}

// Calls `fetch(local index, graph index)` for the thread's halo nodes.
template <class Fetch>
DEVICE void for_halo(const BlockState& l, const Halo& h, Fetch fetch) {
#if SHAPE == SHAPE_GRID
#pragma unroll
    for (u32 k = 0; k < HELD_HALO; k++) {
        u32 i = l.share.own + threadIdx.x + k * THREADS;
        if (h.at[k] != 0xffffffffu) fetch(i, h.at[k]);
    }
    for (u32 i = l.share.own + threadIdx.x + HELD_HALO * THREADS; i < l.share.local; i += THREADS)
        fetch(i, l.graph_node(i));
    __syncthreads();
#endif
}

DEVICE void fetch_states(const BlockState& l, const Halo& h, u32 next) {
#if SHAPE == SHAPE_GRID
    const float4* from_x = l.instance->team.exchange_x + next * (u64)h.nodes;
    const float2* from_v = l.instance->team.exchange_v + next * (u64)h.nodes;
    for_halo(l, h, [&](u32 i, u32 at) {
        l.xs(next, 0)[i] = __ldcg(from_x + at);
        l.vs(next, 0)[i] = __ldcg(from_v + at);
    });
#endif
}

DEVICE void fetch_vectors(const BlockState& l, const Halo& h, u32 next, float4* here) {
#if SHAPE == SHAPE_GRID
    const float4* from = l.instance->team.exchange_x + next * (u64)h.nodes;
    for_halo(l, h, [&](u32 i, u32 at) { here[i] = __ldcg(from + at); });
#endif
}

// Calls `add(reference)` for a lane's share of its node's triplets.
template <class Add>
DEVICE void for_arms(const ThreadNode& p, const u32* refs, Add add) {
#pragma unroll
    for (u32 k = 0; k < HELD_ARMS; k++) {
        if (p.held_arms[k] != NO_ARM) add(p.held_arms[k]);
    }
#pragma unroll 4
    for (u32 k = HELD_ARMS; k < p.arms; k++) {
        u32 ref = refs[p.arm + k * 32];
        if (ref != NO_ARM) add(ref);
    }
}

// The same for a lane of a control point, which has these rows of references behind the nodes'.
template <class Add>
DEVICE void for_control_arms(const BlockState& l, u32 row, const u32* refs, Add add) {
    const u32* rows = l.instance->topology.arm_rows + l.share.row + l.share.rows + row;
    for (u32 k = rows[0]; BENDING && k < rows[1]; k++) {
        u32 ref = refs[k * 32 + threadIdx.x % 32];
        if (ref != NO_ARM) add(ref);
    }
}

// The first triplet of a thread. The last threads have the shortest rows, so they begin.
DEVICE u32 first_triplet() { return THREADS - 1 - threadIdx.x; }

// Barrier after the forces of triplets are written. With one row a thread it comes when the row's
// half-springs are done, so that no thread waits idly for a triplet.
DEVICE void synchronize_bends() {
#if BENDING
    __syncthreads();
#endif
}

// A triplet of a thread: the first is held in registers.
struct HeldTriplet {
    Triplet ends;
    BendParams params;
    bool has;
};

#if RODS
// Twists of a block's rods (in the backward pass: d loss / d twist), by instance and rod.
DEVICE float* rod_twists() {
    static __shared__ float twists[RODS * INSTANCES];
    return twists;
}

// A rod of a warp: the first is held in registers.
struct HeldRod {
    u32 first, end;  // its inner nodes, as triplets with their neighbours
    float stiffness, damping, rest_twist;
};

DEVICE HeldRod rod_at(const BlockState& l, u32 r) {
    HeldRod h = {0, 0, 0.0f, 0.0f, 0.0f};
    if (r < RODS) {
        h.first = l.instance->topology.rod_turns[r];
        h.end = l.instance->topology.rod_turns[r + 1];
        h.stiffness = l.instance->parameters.rods[r];
        h.damping = l.instance->parameters.rods[RODS + r];
        h.rest_twist = l.instance->parameters.rods[2 * RODS + r];
    }
    return h;
}

// Calls `work(rod, what is held of it)` for the rods of a warp, all of its lanes together.
template <class Work>
DEVICE void for_rods(const BlockState& l, const HeldRod& first, Work work) {
    u32 r = threadIdx.x / 32;
    if (r < RODS) work(r, first);
    for (r += WARPS; r < RODS; r += WARPS) work(r, rod_at(l, r));
}

// The inner node `t` of a rod: its turn, and its neighbours' velocities relative to its own.
struct InnerNode {
    Triplet ends;
    Turn turn;
    float3 v_before, v_after;
};

DEVICE InnerNode inner_node_at(const BlockState& l, u32 now, u32 m, u32 t) {
    InnerNode in;
    in.ends = l.instance->topology.triplets[l.share.triplet + t];
    State i = l.state(now, m, in.ends.i), j = l.state(now, m, in.ends.j);
    State k = l.state(now, m, in.ends.k);
    float3 e = sub(j.x, i.x), g = sub(k.x, j.x);
    in.turn = in.ends.owned ? arm_of(e, g) : turn_of(e, g);
    in.v_before = sub(i.v, j.v);
    in.v_after = sub(k.v, j.v);
    return in;
}
#endif

DEVICE HeldTriplet triplet_at(const BlockState& l, u32 t) {
    HeldTriplet h;
    h.has = BENDING && t < l.share.triplets;
    h.ends.i = h.ends.j = h.ends.k = h.ends.owned = 0;
    h.params.stiffness = h.params.damping = h.params.rest_bend = 0.0f;
    if (h.has) {
        h.ends = l.instance->topology.triplets[l.share.triplet + t];
        float4 packed = l.instance->parameters.bends[l.share.triplet + t];
        h.params.stiffness = packed.x;
        h.params.damping = packed.y;
        h.params.rest_bend = packed.z;
    }
    return h;
}
