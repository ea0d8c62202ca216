// Starts of instances: the initial state, which many may share, with pinned nodes on their control
// points.

// Initial state of an instance.
struct InitialArgs {
    const float* initial;   // [6][N]: x, y, z, vx, vy, vz
    float* states;          // the same, of frame 0
    const float* controls;  // [frames + 1][C][3]
    const int* pin_of;      // by node: its pin, -1 if it has none
    const Pin* pins;
    const float* initial_twists;  // [R]
    float* twists;          // the same, of frame 0
    float frame_s;
    u32 node_count;         // N
    u32 rod_count;          // R
    u32 control_count;      // C
    u32 controls_move;      // whether there is a next frame, towards which pinned nodes move
    u32 frame_count;
    WorldArgs world;
};

struct StartArgs {
    const InitialArgs* instances;
};

// True for a control point that its grasp does not hold when the first frame begins.
DEVICE bool begins_released(const InitialArgs& s, u32 control) {
    int grasp = s.world.grasp_of ? s.world.grasp_of[control] : -1;
    if (grasp < 0) return false;
    return s.world.phases[grasp] != PHASE_CLOSED || (s.frame_count > 0 && !s.world.closed[grasp]);
}

// Block (nodes, instance).
extern "C" __global__ void start(const __grid_constant__ StartArgs args) {
    const InitialArgs& s = args.instances[blockIdx.y];
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    for (u32 r = i; r < s.rod_count; r += gridDim.x * THREADS) s.twists[r] = s.initial_twists[r];
    if (i >= s.node_count) return;
    u64 n = s.node_count;
    float3 x = v3(s.initial[i], s.initial[n + i], s.initial[2 * n + i]);
    float3 v = v3(s.initial[3 * n + i], s.initial[4 * n + i], s.initial[5 * n + i]);
    int pin = s.pin_of[i];
    if (pin >= 0 && begins_released(s, s.pins[pin].control)) pin = -1;
    if (pin >= 0) {
        Pin held = s.pins[pin];
        Path path = {
            s.controls, s.controls + 3 * (u64)s.control_count, s.frame_s, s.controls_move != 0
        };
        x = add(load_v3(path.from + 3 * held.control), load_v3(held.offset));
        v = control_velocity(path, held.control);
    }
    float* to = s.states + i;
    to[0] = x.x;
    to[n] = x.y;
    to[2 * n] = x.z;
    to[3 * n] = v.x;
    to[4 * n] = v.y;
    to[5 * n] = v.z;
}
