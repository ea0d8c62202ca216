// What the host hands to the kernels. The host's mirror of these structs is in `src/job.rs`: same
// order, same sizes.

// A block's share of a graph. A block knows its own nodes, then the halo of nodes that its elements
// reach into, by local index; control points stand at `Topology::control_base` in every block.
struct Share {
    u32 own;             // nodes that it owns
    u32 local;           // own nodes and halo
    u32 nodes;           // first of its local nodes in `Topology::nodes`
    u32 rows;            // rows of half-springs of its own nodes
    u32 control_rows;    // rows of half-springs of control points on its nodes
    u32 row;             // first of its rows + control_rows + 1 row starts in `Topology::rows`
    u32 triplets;        // triplets with an end among its own nodes
    u32 triplet;         // first of them in `Topology::triplets`
    u32 arm;             // first of its own + controls + 1 arm starts in `Topology::arms`
    u32 pins;            // pinned nodes among its local ones
    u32 pin;             // first of them in `Topology::local_pins`
    u32 export_;         // first of its own + 1 export starts in `Topology::exports`
    u32 slot;            // where its own nodes begin on a tape that this cut writes
};

struct LocalPin {
    u32 local;  // local index of the node
    u32 pin;    // index of the pin in the graph
};

struct Pin {
    u32 control;
    float offset[3];
};

struct Triplet {
    u16 i, j, k;  // local indices
    u16 owned;    // whether this block reports its gradient; of a rod's inner node, whether `k` is an arm
};

// A graph as one shape of launch sees it.
struct Topology {
    const Share* shares;
    const u32* nodes;          // graph index of each local node
    const u32* rows;           // first pair of slots of each row; a slot is 32 half-springs
    const Triplet* triplets;
    const u32* arms;           // per own node and control point: first of its arm references
    const u32* arm_refs;       // triplet * 4 + role (0: i, 1: k, 2: j)
    const LocalPin* local_pins;
    const Pin* pins;           // as in the graph
    const int* pin_of;         // by graph index: the node's pin, -1 if it has none
    const u32* exports;        // per own node: first of its export references
    const u32* export_refs;    // block << 16 | local index there
    const float* inverse_mass; // by graph index; zero where pinned
    const u32* sum_rows;       // as `rows`: pairs with sums before each row
    const int* triplet_of;     // per triplet of a share: its index in the graph
    u32 node_count, controls;
    u32 control_base;          // local index of control point 0
    u32 stride;                // control_base + controls
    u32 max_triplets;          // of a share
    u32 max_pairs;             // pairs of half-springs of a share's nodes, padding included
    u32 max_all_pairs;         // and of its nodes and control points
    u32 rods;                  // R; a graph with rods has one share
    const u32* rod_turns;      // [R + 1]: where each rod's inner nodes begin in the share's list of triplets, behind these
};

// One simulation to run.
struct Job {
    Topology topology;
    const float4* rates;         // per pair of half-springs: rate, rest length, rate, rest length
    const u32* others;           // per pair: local indices of the other ends, 16 bits each
    const float2* dashpots;      // per pair; not looked at where all are `dashpot`
    const float4* bends;         // per triplet of a share, as in `BendParams`
    const float* controls;       // [frames + 1][C][3]
    float* states;               // [slots][6][N]: x, y, z, vx, vy, vz of frame f at f % slots
    u64* divergence;             // smallest frame << 32 | node
    const u32* tape_slots;       // by graph index: where a node is on a tape that is read
    float4* tape_x;              // [substeps on tape][N], in the order of the cut that writes it: x, v_x
    float2* tape_v;              // v_y, v_z
    float* tape_b;               // [3]: velocity before contact
    float4* bar_x;               // [N]: d loss / d state
    float4* bar_v;
    float* spring_sums;          // [pairs with sums][2][3][32 lanes], as in `SpringSums`
    float* bend_sums;            // [3][T], then [3][R] of rods
    float* law_sums;             // [blocks][5]: drag, ground restitution, friction, object restitution, friction
    float* control_sums;         // [blocks][9][C]: d loss / d from, to, velocity
    float* pin_sums;             // [9][pins]
    u32* partners;               // [N][max_partners]: who may touch whom
    u32* partner_counts;         // [N]
    u32* partner_scratch;        // [N]: nodes by cell
    const u32* object_ids;       // [N]
    const u32* joined_starts;    // [N + 1]: nodes that a spring joins to a node, ascending
    const u32* joined;
    float4* contact_x;           // [N]: x, inverse mass
    float4* contact_v;           // [N]: velocity before contact
    float4* exchange_x;          // [2][N]: where a grid's blocks meet
    float2* exchange_v;          // [2][N]
    u32* barrier;                // counts a grid's blocks
    float4* spill;               // per block: what does not fit shared memory
    float kick[3];               // gravity times dt
    Ground ground;
    Law ground_law, object_law;
    float dt, decay;             // decay is exp(-dt drag)
    float frame_s;
    float collision_distance;
    float dashpot;
    u32 substeps;
    u32 slots;
    u32 controls_move;
    u32 first;                   // frame that the launch's frame 0 is
    u32 frames;                  // frames of this job; it sits out the rest of a launch
    u32 triplets, pins;
    u32 max_partners;
    u32 between_objects, within_object;
    u32 spill_stride;            // float4s of a block's spill
    u32 unused;
    const float* rods;           // [3][R]: stiffness, damping, rest twist
    float* twists;               // [slots][R]: as `states`
    float* tape_twists;          // [substeps on tape][R]: where a substep begins
    float* twist_bars;           // [R]: d loss / d twist
};

// The host's idea of these structs must be the same.
static_assert(sizeof(Share) == SIZE_OF_SHARE && sizeof(Topology) == SIZE_OF_TOPOLOGY, "src/job.rs");
static_assert(sizeof(Job) == SIZE_OF_JOB && sizeof(Pin) == 16 && sizeof(Triplet) == 8, "src/job.rs");

DEVICE float3 load_v3(const float* p) { return v3(p[0], p[1], p[2]); }

// Control points of a frame.
struct Path {
    const float* from;
    const float* to;
    float frame_s;
    bool moves;
};

DEVICE Path path_of(const Job& job, u32 frame) {
    Path p;
    p.from = job.controls + (u64)frame * job.topology.controls * 3;
    // A job without frames stands still.
    p.to = frame < job.first + job.frames ? p.from + job.topology.controls * 3 : p.from;
    p.frame_s = job.frame_s;
    p.moves = job.controls_move != 0;
    return p;
}
DEVICE float3 control_velocity(const Path& p, u32 c) {
    if (!p.moves) return zero3();
    return scale(sub(load_v3(p.to + 3 * c), load_v3(p.from + 3 * c)), 1.0f / p.frame_s);
}
// How far into the frame the controls are in a substep: its end.
DEVICE float progress(u32 substep, u32 substeps) {
    return __fdiv_rn((float)(substep + 1), (float)substeps);
}
// Exact at both ends, so that a rollout may be cut at any frame.
DEVICE float3 control_position(const Path& p, float t, u32 c) {
    return add_scaled(scale(load_v3(p.from + 3 * c), 1.0f - t), t, load_v3(p.to + 3 * c));
}
