// Storage of the backward pass: in shared memory beside the tape's states, in registers, and its
// sums.

// Lambda, two buffers; then what is carried from substep to substep.
DEVICE float4* lambda_of(const BlockState& l, u32 buffer) {
    return l.after_states(buffer * l.stride);
}
DEVICE float4* bar_x_of(const BlockState& l) { return l.after_states(2 * l.stride); }
DEVICE float4* bar_v_of(const BlockState& l) {
    return l.after_states(2 * l.stride + l.control_base);
}
DEVICE float4* after_bars(const BlockState& l) {
    return l.after_states(2 * l.stride + 2 * l.control_base);
}
// d loss / d (x_i, x_k, v_i, v_k), by triplet.
DEVICE float3* bend_buffer(const BlockState& l) {
    u32 before = HALF_SPRINGS_IN_SHARED ? pairs_size(l.instance->topology.max_all_pairs) : 0;
    return reinterpret_cast<float3*>(BEND_IN_SHARED ? after_bars(l) + before : l.spill());
}

// Values of all substeps, kept in registers.
struct Constants {
    float dt, decay;
    Ground ground;
    Law law;
    float dashpot;
    u32 substeps, nodes;
    const float4* tape_x;
    const float2* tape_v;
    const float* tape_b;
    float* sums;
    u32 first_slot;  // on tape, of the thread's first local node
};

// Sums of a thread over a launch.
struct Sums {
    float decay;
    Law ground, object;
    float bend_stiffness, bend_damping, bend_rest;  // of the thread's first triplet
#if HELD > 0
    SpringSums springs[2 * HELD_SUMS];
#endif
};

// What holds a thread's node in the frame.
struct NodeHold {
#if GRASPS
    Held of;
#endif
};

DEVICE NodeHold node_hold_of(const BlockState& l, const ThreadNode& p) {
    NodeHold h;
#if GRASPS
    h.of = held_of(*l.instance, l.instance->state.first_frame, p.at, p.valid, p.pin);
#endif
    return h;
}

// True if a control point holds the node.
DEVICE bool is_pinned(const ThreadNode& p, const NodeHold& h) {
#if GRASPS
    return h.of.by == BY_CONTROL;
#else
    return p.pin >= 0;
#endif
}

// True if a body holds the node by a pin.
DEVICE bool is_carried(const NodeHold& h) {
#if GRASPS
    return h.of.by == BY_PIN;
#else
    return false;
#endif
}

// Zero where the node is held.
DEVICE float inverse_mass_of(const ThreadNode& p, const NodeHold& h) {
#if GRASPS
    return h.of.inverse_mass;
#else
    return p.inverse_mass;
#endif
}

// d loss / d the mean force in the frame with which a node is held.
DEVICE float3 held_force_bar(const BlockState& l, const ThreadNode& p, const NodeHold& h) {
#if FORCES
    const InstanceArgs& instance = *l.instance;
    const float* bars = instance.world.force_bars;
    if (!bars) return zero3();
    if (is_pinned(p, h)) return load_v3(bars + 6 * instance.topology.pins[p.pin].control);
#if GRASPS
    if (h.of.by == BY_PIN || h.of.by == BY_SPRING)
        return load_v3(bars + 6 * (instance.topology.control_count + h.of.grasp));
#endif
#endif
    return zero3();
}

// Adds to d loss / d the path of what holds a node.
DEVICE void add_hold_path(
    const BlockState& l, const ThreadNode& p, const NodeHold& h, float t, float3 x_bar, float3 v_bar
) {
    const InstanceArgs& instance = *l.instance;
    if (is_pinned(p, h)) {
        add_path(instance.adjoint.pin_sums, instance.topology.pin_count, p.pin, t, x_bar, v_bar);
#if GRASPS
    } else {
        u32 n = instance.topology.node_count;
        add_path(instance.world.hold_sums, n, p.at, t, x_bar, v_bar);
#endif
    }
}
