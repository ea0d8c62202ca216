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
    float* pin_sums;
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

// Adds to one of the nine components of d loss / d (from, to, velocity); nothing where `sums` is
// null.
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
