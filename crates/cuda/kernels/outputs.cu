// Outputs of a rollout: recorded positions, and the extremes of strain and speed at frame ends.

struct OutputArgs {
    const float* states;    // [slots][6][N]
    const u32* frames;      // recorded frames
    const u32* nodes;       // recorded nodes, or null for all
    float* positions;       // [frames][nodes][3]
    const u32* springs;     // [E][2]
    const float* params;    // as in `params.cu`
    const float* controls;  // [frames + 1][C][3]
    float* extremes;        // [all frames][2]: largest strain, largest speed
    u32 node_count, recorded_nodes, recorded_frames, slot_count;
    u32 spring_count, control_count, frame_count, unused;
};

struct RecordArgs {
    const OutputArgs* outputs;
};

struct ExtremesArgs {
    const OutputArgs* outputs;
};

// Block (nodes, recorded frame, instance).
extern "C" __global__ void record(const __grid_constant__ RecordArgs args) {
    const OutputArgs& r = args.outputs[blockIdx.z];
    u32 k = blockIdx.x * THREADS + threadIdx.x;
    if (blockIdx.y >= r.recorded_frames || k >= r.recorded_nodes) return;
    u32 n = r.node_count, node = r.nodes ? r.nodes[k] : k;
    const float* s = r.states + (u64)(r.frames[blockIdx.y] % r.slot_count) * 6 * n;
    float* out = r.positions + ((u64)blockIdx.y * r.recorded_nodes + k) * 3;
    for (u32 c = 0; c < 3; c++) out[c] = s[c * n + node];
}

DEVICE float block_max(float value) {
    __shared__ float partial[THREADS / 32];
    for (int mask = 16; mask > 0; mask /= 2)
        value = fmaxf(value, __shfl_xor_sync(0xffffffffu, value, mask));
    __syncthreads();
    if (threadIdx.x % 32 == 0) partial[threadIdx.x / 32] = value;
    __syncthreads();
    for (u32 w = 0; w < THREADS / 32; w++) value = fmaxf(value, partial[w]);
    return value;
}

// Block (frame - 1, instance).
extern "C" __global__ void __launch_bounds__(THREADS)
extremes(const __grid_constant__ ExtremesArgs args) {
    const OutputArgs& r = args.outputs[blockIdx.y];
    u32 frame = blockIdx.x + 1, n = r.node_count;
    if (frame > r.frame_count) return;
    const float* s = r.states + (u64)(frame % r.slot_count) * 6 * n;
    const float* held = r.controls + (u64)frame * r.control_count * 3;
    float strain = 0.0f, square = 0.0f;
    for (u32 e = threadIdx.x; e < r.spring_count; e += THREADS) {
        float3 ends[2];
        for (u32 k = 0; k < 2; k++) {
            u32 i = r.springs[2 * (u64)e + k];
            ends[k] = i < n ? v3(s[i], s[n + i], s[2 * n + i]) : load_v3(held + 3 * (u64)(i - n));
        }
        float rest = r.params[2 * (u64)r.spring_count + e];
        float3 d = sub(ends[1], ends[0]);
        if (rest > 0.0f) strain = fmaxf(strain, fabsf(sqrtf(dot(d, d)) / rest - 1.0f));
    }
    for (u32 i = threadIdx.x; i < n; i += THREADS) {
        float3 v = v3(s[3 * n + i], s[4 * n + i], s[5 * n + i]);
        square = fmaxf(square, dot(v, v));
    }
    strain = block_max(strain);
    square = block_max(square);
    if (threadIdx.x == 0) {
        r.extremes[2 * blockIdx.x] = strain;
        r.extremes[2 * blockIdx.x + 1] = sqrtf(square);
    }
}
