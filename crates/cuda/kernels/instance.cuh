// Arguments of the kernels that simulate. The host declares the same structs in `src/device/args`;
// every field's place and size is checked when a kernel is compiled. A kernel takes one struct of
// its own as a `__grid_constant__`: without it NVVM unrolls fewer loops over memory that the struct
// points to.

// A block's share of a graph. A block knows its own nodes, then the halo of nodes that its elements
// reach into, by local index; control points stand at `TopologyArgs::control_base` in every block.
struct Share {
    u32 own;             // nodes that it owns
    u32 local;           // own nodes and halo
    u32 nodes;           // first of its local nodes in `TopologyArgs::nodes`
    u32 rows;            // rows of half-springs of the block's nodes
    u32 control_rows;    // rows of half-springs of control points on its nodes
    u32 row;             // first of its rows + control_rows + 1 row starts in `TopologyArgs::rows`
    u32 triplets;        // triplets with an end among its own nodes
    u32 triplet;         // first of them in `TopologyArgs::triplets`
    u32 pins;            // pinned nodes among its local ones
    u32 pin;             // first of them in `TopologyArgs::local_pins`
    u32 export_start;    // first of the block's own + 1 export starts in `TopologyArgs::exports`
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
    // 1 if this block reports its gradient; of a rod's inner node, 1 if `k` is an arm.
    u16 owned;
};

// A graph as one shape of launch sees it.
struct TopologyArgs {
    const Share* shares;
    const u32* nodes;          // graph index of each local node
    const u32* rows;           // first pair of slots of each row; a slot is 32 half-springs
    const Triplet* triplets;
    const u32* arm_rows;       // as `rows`: first slot of each row's references to triplets
    const u32* arm_refs;       // [slots][32]: as `arm_ref` says, or NO_ARM
    const LocalPin* local_pins;
    const Pin* pins;           // as in the graph
    const int* pin_of;         // by graph index: the node's pin, -1 if it has none
    const u32* exports;        // per own node: first of its export references
    const u32* export_refs;    // block << 16 | local index there
    const float* inverse_mass; // by graph index; zero where pinned
    const float* masses;       // by graph index
    const u32* sum_rows;       // as `rows`: pairs with sums before each row
    const u32* triplet_of;     // per triplet of a share: its index in the graph
    const u32* rod_turns;      // [R + 1]: first inner node of each rod among the share's triplets
    const float* rod_shares;   // by inner node: share of its rod's length
    u32 node_count;            // N
    u32 control_count;         // C
    u32 control_base;          // local index of control point 0
    u32 stride;                // control_base + control_count
    u32 max_triplets;          // of a share
    u32 max_pairs;             // pairs of half-springs of a share's nodes, padding included
    u32 max_all_pairs;         // the same, of its nodes and control points
    u32 rod_count;             // R; a graph with rods has one share
    u32 triplet_count;         // T
    u32 pin_count;
};

// Material parameters, packed for a shape of launch.
struct ParameterArgs {
    const float4* rates;     // per pair of half-springs: rate, rest length, rate, rest length
    const u32* others;       // per pair: local indices of the other ends, 16 bits each
    const float2* dashpots;  // per pair; not read where all are `dashpot`
    const float4* bends;     // per triplet of a share, as in `BendParams`
    const float* rods;       // [3][R]: stiffness, damping, rest twist
    Law ground_law, object_law;
    float dashpot;           // of all springs if it is the same [N s/m]
    float decay;             // exp(-dt drag)
};

// A substep: its length, external forces, and the frame that it is a part of.
struct StepArgs {
    float kick[3];  // gravity times dt [m/s]
    Ground ground;
    float dt;       // [s]
    float frame_s;
    u32 substeps;   // of a frame
    u32 controls_move;
    u32 pad;
};

// States that frames begin and end in.
struct StateArgs {
    const float* controls;  // [frames + 1][C][3]
    float* states;          // [slots][6][N]: x, y, z, vx, vy, vz of frame f at f % slot_count
    float* twists;          // [slots][R]: as `states`
    u64* divergence;        // smallest frame << 32 | node
    u32 slot_count;
    u32 first_frame;        // frame that the launch's frame 0 is
    u32 frame_count;        // frames to run; in the rest of a launch the instance does not change
    u32 pad;
};

// Records of substeps for the backward pass.
struct TapeArgs {
    const u32* slot_of;  // by graph index: the node's slot on a tape that is read
    float4* x;           // [substeps on tape][N], in the order of the cut that writes it: x, v_x
    float2* v;           // v_y, v_z
    float* before;       // [3]: velocity before contact
    float* twists;       // [substeps on tape][R]: at a substep's start
};

// Derivatives of the loss, and the sums that become gradients of parameters.
struct AdjointArgs {
    float4* bar_x;        // [N]: d loss / d position
    float4* bar_v;        // [N]: d loss / d velocity
    float* bar_twists;    // [R]: d loss / d twist
    float* spring_sums;   // [pairs with sums][2][3][32 lanes], as in `SpringSums`
    float* bend_sums;     // [3][T], then [3][R] of rods
    float* law_sums;      // [blocks][5]: drag, restitution and friction of ground and of objects
    float* control_sums;  // [blocks][9][C]: d loss / d from, to, velocity
    float* pin_sums;      // [9][pins]
};

// Contact between nodes.
struct ContactArgs {
    u32* partners;                // [N][max_partners]: candidates of each node
    u32* partner_counts;          // [N]
    u32* partner_scratch;         // [N]: nodes by cell
    const u32* object_ids;        // [N]
    const u32* neighbour_starts;  // [N + 1]: first neighbour of each node in `neighbours`
    const u32* neighbours;        // nodes that a spring joins to a node, ascending
    float4* x;                    // [N]: x, inverse mass
    float4* v;                    // [N]: velocity before contact
    float4* start;                // [N]: velocity at the substep's start
    const float4* rest;           // [N]: position at rest
    float collision_distance;     // [m]
    u32 max_partners;
    u32 between_objects, within_object;
};

// Global memory that a team's blocks work in.
struct TeamArgs {
    float4* exchange_x;  // [2][N]: states that a grid's blocks exchange
    float2* exchange_v;  // [2][N]
    u32* barrier;        // counts a grid's blocks
    float4* spill;       // per block: what shared memory has no room for
    u32 spill_stride;    // float4s of a block's spill
    u32 pad;
};

// A rigid obstacle: a capsule, or where it has faces the part of space behind all of them.
struct Collider {
    float from[3];   // one end of the capsule's axis, in the body's coordinates [m]
    float radius;
    float axis[3];   // from there to the other end
    float friction;
    float restitution;
    u32 body;        // NO_BODY: it stands in the world
    u32 face;        // first of its faces in `WorldArgs::faces`
    u32 faces;
};

// A hold on nodes by a body.
struct Grasp {
    u32 body;
    u32 region;      // REGION_*
    u32 attachment;  // HOLD_*
    u32 member;      // first of its nodes in `WorldArgs::members`, ascending
    u32 members;
    float stiffness, damping;
    float max_force;
    float low[3];    // least corner of a box, centre of a sphere [m]
    float high[3];   // greatest corner; the radius in all three
};

// What holds a node in a frame.
struct Hold {
    float place[3];  // in the coordinates of the grasp's body [m]
    int grasp;       // -1: none
};

// The part of a rod that is twisted in a frame, as `cpu/elements/rod/span.rs` says.
struct RodSpan {
    u32 first, end;       // inner nodes along the rod
    float inverse_share;  // of the rod's length
    float kept;           // share of the twist beyond its rest that the frame begins with
    float roll_rate;      // rate of the twist that clamps impose [rad/s]
    u32 pad;
};

// What surrounds the object, and the memory that goes with it. A boundary `f` is the start of frame
// `f`.
struct WorldArgs {
    const float4* poses;       // [frames + 1][B][3]: rows of [A | p] at boundaries
    const Collider* colliders; // [K]
    const float4* faces;       // normal, offset
    const Grasp* grasps;       // [G]
    const u32* members;
    const int* grasp_of;       // [C]: the grasp that a control point belongs to, or -1; may be null
    const u32* closed;         // [frames][G]
    const float* rolls;        // [frames + 1][R][2]: turns of clamps [rad]; may be null
    const float* initial;      // [6][N]: the state that the rollout was given
    Hold* holds;               // [slots][N]: before boundary 0, then in frame f at (f + 1) % slots
    u32* phases;               // [slots][G]: as `holds`
    RodSpan* spans;            // [slots][R]: as `holds`; null without rods
    float* impulses;           // [IMPULSES + 6 K][N] of a frame [N s], in the order of `IMPULSE_*`
    float* control_impulses;   // [blocks][6][C]: by springs of control points
    float* forces;             // [frames][6 C + 6 G + 3 + 6 K]
    float* hold_sums;          // [9][N]: d loss / d from, to, velocity of places
    float* body_sums;          // [B][24][N]: d loss / d poses at both ends of a frame
    float* roll_sums;          // [R]: d loss / d rates of twists that clamps impose
    float4* place_bars;        // [N]: d loss / d places
    float4* arrive_bars;       // [N]: d loss / d velocities that held nodes arrive with
    const float* force_bars;   // [6 C + 6 G + 3 + 6 K] of a frame: d loss / d its forces; may be null
    u32 body_count;            // B
    u32 collider_count;        // K
    u32 grasp_count;           // G
    u32 slot_count;
    float smoothing;           // width of the layer in which ground and colliders act [m]
    u32 pad;
};

// The skin of a model: points of its surface that nodes carry.
struct SkinArgs {
    const u32* starts;          // [M + 1]: first weight of each point
    const u32* nodes;           // [K]: node of each weight
    const float* weights;       // [K]
    const u32* frames;          // [M][3]: nodes a, b, c of each point's frame, or NO_FRAME
    const float* offsets;       // [M][3]: along the axes of the frame
    // For gradients, or null: the points that each node carries, ascending, and the weights.
    const u32* node_starts;     // [N + 1]
    const u32* carried;         // [K]
    const float* carried_weights;
    // For gradients, or null: points whose frame each node is in, ascending, and which of a, b, c it is.
    const u32* corner_starts;   // [N + 1]
    const u32* corners;         // [corners][2]
    const u32* borne_starts;    // [N + 1]: first of the points that each node bears
    const u32* borne;           // ascending for each node
    u32 point_count;            // M
    u32 pad;
};

// Contact of the skin: distances at which nodes touch the ground (row 0) and colliders (1 + k).
struct ClearanceArgs {
    SkinArgs skin;
    float* distances;   // [1 + K][N] [m]
    u32* points;        // [1 + K][N]: the point of the skin that decides, or NO_POINT
    float* bars;        // [1 + K][N]: d loss / d distances of a frame
    float4* by_points;  // [1 + K][N]: d loss / d the points that decide
    float* places;      // [3][M]: points where a frame begins, or d loss / d them
};

// One instance to simulate.
struct InstanceArgs {
    TopologyArgs topology;
    ParameterArgs parameters;
    StepArgs step;
    StateArgs state;
    TapeArgs tape;
    AdjointArgs adjoint;
    ContactArgs contact;
    TeamArgs team;
    WorldArgs world;
    ClearanceArgs clearance;
};

DEVICE float3 load_v3(const float* p) { return v3(p[0], p[1], p[2]); }

// Control points of a frame.
struct Path {
    const float* from;
    const float* to;
    float frame_s;
    bool moves;
};

DEVICE Path path_of(const InstanceArgs& instance, u32 frame) {
    Path p;
    p.from = instance.state.controls + (u64)frame * instance.topology.control_count * 3;
    // An instance without frames stands still.
    p.to = frame < instance.state.first_frame + instance.state.frame_count
               ? p.from + instance.topology.control_count * 3
               : p.from;
    p.frame_s = instance.step.frame_s;
    p.moves = instance.step.controls_move != 0;
    return p;
}
DEVICE float3 control_velocity(const Path& p, u32 c) {
    if (!p.moves) return zero3();
    return scale(sub(load_v3(p.to + 3 * c), load_v3(p.from + 3 * c)), 1.0f / p.frame_s);
}
// Share of the frame that the controls have moved by a substep's end.
DEVICE float progress(u32 substep, u32 substeps) {
    return __fdiv_rn((float)(substep + 1), (float)substeps);
}
// Exact at both ends, so that a rollout may be cut at any frame.
DEVICE float3 control_position(const Path& p, float t, u32 c) {
    return add_scaled(scale(load_v3(p.from + 3 * c), 1.0f - t), t, load_v3(p.to + 3 * c));
}
