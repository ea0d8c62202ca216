// Forces of a frame: the impulses of its nodes, added up in a fixed order and divided by its
// length.

struct SumForcesArgs {
    const InstanceArgs* instances;
    u32 frame;
    u32 blocks;  // of an instance's team
};

DEVICE float warp_sum(float x) {
    for (int mask = 16; mask > 0; mask /= 2) x += __shfl_xor_sync(0xffffffffu, x, mask);
    return x;
}

// Sum over nodes that `counts` of a wrench's components, and what control points add.
template <class Counts, class Controls>
DEVICE void sum_wrench(
    const InstanceArgs& instance, u32 components, u32 kind, u32 blocks, float* out, Counts counts,
    Controls controls
) {
    const u32 n = instance.topology.node_count, c = instance.topology.control_count;
    const u32 lane = threadIdx.x % 32;
    const float* from = instance.world.impulses + (u64)kind * n;
    float sum[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    for (u32 node = lane; node < n; node += 32) {
        if (!counts(node)) continue;
        for (u32 k = 0; k < components; k++) sum[k] += from[(u64)k * n + node];
    }
    for (u32 i = lane; i < c * blocks; i += 32) {
        u32 control = i % c;
        if (!controls(control)) continue;
        const float* own = instance.world.control_impulses + (u64)(i / c) * 6 * c + control;
        for (u32 k = 0; k < components; k++) sum[k] += own[(u64)k * c];
    }
    for (u32 k = 0; k < components; k++) {
        float total = warp_sum(sum[k]);
        if (lane == 0) out[k] = total / instance.step.frame_s;
    }
}

// Block (instance). Clears the impulses.
extern "C" __global__ void __launch_bounds__(THREADS)
sum_forces(const __grid_constant__ SumForcesArgs args) {
    const InstanceArgs& instance = args.instances[blockIdx.x];
    const WorldArgs& w = instance.world;
    const u32 frame = args.frame, blocks = args.blocks;
    if (!w.impulses || frame >= instance.state.frame_count) return;
    const u32 n = instance.topology.node_count, c = instance.topology.control_count;
    const u32 g = w.grasp_count, colliders = w.collider_count;
    const int* pin_of = instance.topology.pin_of;
    const Pin* pins = instance.topology.pins;
    const Hold* holds = g ? holds_of(instance, frame) : 0;
    float* out = w.forces + (u64)frame * (6 * (c + g + colliders) + 3);
    auto none = [](u32) { return false; };
    for (u32 k = threadIdx.x / 32; k < c + g + 1 + colliders; k += THREADS / 32) {
        if (k < c) {
            sum_wrench(
                instance, 6, IMPULSE_CONTROL, blocks, out + 6 * k,
                [&](u32 node) { return pin_of[node] >= 0 && pins[pin_of[node]].control == k; },
                [&](u32 control) { return control == k; }
            );
        } else if (k < c + g) {
            int grasp = (int)(k - c);
            if (w.grasps[grasp].region == REGION_CONTROLS) {
                auto has = [&](u32 control) { return w.grasp_of[control] == grasp; };
                sum_wrench(
                    instance, 6, IMPULSE_CONTROL, blocks, out + 6 * k,
                    [&](u32 node) { return pin_of[node] >= 0 && has(pins[pin_of[node]].control); },
                    has
                );
            } else {
                sum_wrench(
                    instance, 6, IMPULSE_HOLD, blocks, out + 6 * k,
                    [&](u32 node) { return holds[node].grasp == grasp; }, none
                );
            }
        } else if (k == c + g) {
            auto all = [](u32) { return true; };
            sum_wrench(instance, 3, IMPULSE_GROUND, blocks, out + 6 * k, all, none);
        } else {
            u32 collider = k - c - g - 1;
            auto all = [](u32) { return true; };
            sum_wrench(
                instance, 6, IMPULSES + 6 * collider, blocks, out + 6 * (c + g + collider) + 3, all,
                none
            );
        }
    }
    __syncthreads();
    for (u64 i = threadIdx.x; i < (u64)(IMPULSES + 6 * colliders) * n; i += THREADS)
        w.impulses[i] = 0.0f;
    for (u64 i = threadIdx.x; i < (u64)blocks * 6 * c; i += THREADS) w.control_impulses[i] = 0.0f;
}
