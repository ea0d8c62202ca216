// Where a block keeps things: local state in shared memory, two buffers of positions and velocities per
// instance; then the half-springs, if they are held there; then bending forces, in shared memory if they
// fit and in the block's spill otherwise.

#define NODES_A_ROW (32 / LANES)
#define WARPS (THREADS / 32)

struct Local {
    const Job* job;
    Share share;
    u32 rank;    // of this block in its team
    u32 stride;
    u32 round;   // meetings so far

    DEVICE_MEMBER float4* x(u32 buffer, u32 instance) const {
        return shared_memory + (buffer * 2 * INSTANCES + instance) * stride;
    }
    DEVICE_MEMBER float4* v(u32 buffer, u32 instance) const {
        return shared_memory + ((buffer * 2 + 1) * INSTANCES + instance) * stride;
    }
    // What follows the states, from so many float4s on.
    DEVICE_MEMBER float4* after_states(u32 offset) const {
        return shared_memory + 4 * INSTANCES * stride + offset;
    }
    DEVICE_MEMBER float4* spill() const { return job->spill + (u64)rank * job->spill_stride; }
    DEVICE_MEMBER u32 graph_node(u32 local) const { return job->topology.nodes[share.nodes + local]; }
};

DEVICE Local local_of(const Job* job, u32 rank) {
    Local l;
    l.job = job;
    l.rank = rank;
    l.share = job->topology.shares[rank];
    l.stride = job->topology.stride;
    l.round = 0;
    return l;
}

// What a thread knows of the node that it works on: one of a row of NODES_A_ROW, LANES lanes to each.
struct Place {
    u32 node;             // local index; a lane without a node looks at node 0 and keeps silent
    u32 at;               // graph index
    u32 lane;             // which of the node's lanes this is
    bool valid;
    int pin;              // -1 if it is free
    float inverse_mass;
    u32 first, slots;     // its half-springs: every 32nd from `first` on
    u32 arm, arms;        // its arm references
    u32 export_, exports; // its export references
};

DEVICE Place place_of(const Local& l, u32 row) {
    const Topology& t = l.job->topology;
    Place p;
    p.lane = threadIdx.x % LANES;
    u32 node = row * NODES_A_ROW + threadIdx.x % 32 / LANES;
    p.valid = row < l.share.rows && node < l.share.own;
    p.node = p.valid ? node : 0;
    p.at = l.share.own > 0 ? l.graph_node(p.node) : 0;
    p.pin = p.valid ? t.pin_of[p.at] : -1;
    p.inverse_mass = p.valid ? t.inverse_mass[p.at] : 0.0f;
    const u32* rows = t.rows + l.share.row;
    bool has_row = row < l.share.rows;
    p.first = has_row ? (rows[row] - rows[0]) * 32 + threadIdx.x % 32 : 0;
    p.slots = has_row ? rows[row + 1] - rows[row] : 0;
    p.arm = p.arms = p.export_ = p.exports = 0;
    if (p.valid) {
        p.arm = t.arms[l.share.arm + p.node];
        p.arms = t.arms[l.share.arm + p.node + 1];
        p.export_ = t.exports[l.share.export_ + p.node];
        p.exports = t.exports[l.share.export_ + p.node + 1];
    }
    return p;
}

// Writes a value of a node here and, its lanes together, into all halos that it belongs to.
// `exchange` is where a grid's blocks find it, by graph index.
DEVICE void publish(const Local& l, const Place& p, float4* here, float4* exchange, float4 value) {
    if (p.lane == 0) here[p.node] = value;
#if SHAPE == SHAPE_CLUSTER
    for (u32 e = p.export_ + p.lane; e < p.exports; e += LANES) {
        u32 ref = l.job->topology.export_refs[e];
        store_remote(here + (ref & 0xffff), ref >> 16, value);
    }
#elif SHAPE == SHAPE_GRID
    if (p.lane == 0) __stcg(exchange + p.at, value);
#endif
}

// Fetches the halo of a grid's block.
DEVICE void fetch_halo(const Local& l, float4* here, const float4* exchange) {
#if SHAPE == SHAPE_GRID
    for (u32 h = l.share.own + threadIdx.x; h < l.share.local; h += THREADS)
        here[h] = __ldcg(exchange + l.graph_node(h));
#endif
}

// Where a grid's blocks exchange arrays, two buffers of so many.
DEVICE float4* exchange_of(const Job& job, u32 buffer, u32 array) {
    return job.exchange + (u64)(2 * buffer + array) * job.topology.node_count;
}
