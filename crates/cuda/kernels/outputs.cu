// Outputs of a rollout: recorded positions and velocities, and the extremes of strain and speed by
// frame.

struct OutputArgs {
    const float* states;    // [slots][6][N]
    const u32* frames;      // recorded frames
    const u32* nodes;       // recorded nodes, or null for all
    float* positions;       // [frames][nodes][3]
    const u32* springs;     // [E][2]
    const float* params;    // as in `params.cu`
    const float* controls;  // [frames + 1][C][3]
    float* velocities;      // as `positions`, or null
    float* extremes;        // [all frames][3]: largest strain, that to a control point, speed
    u32 node_count, recorded_nodes, recorded_frames, slot_count;
    u32 spring_count, control_count, frame_count;
    u32 pad;
};

struct RecordArgs {
    const OutputArgs* outputs;
};

struct ExtremesArgs {
    const OutputArgs* outputs;
};

// Words somewhere on the device, and their place among those that are gathered.
struct GatherPiece {
    const u32* from;
    u64 at;
    u64 count;
};

struct GatherArgs {
    const GatherPiece* pieces;
    u32* gathered;
};

// Block (nodes, recorded frame, instance).
extern "C" __global__ void record(const __grid_constant__ RecordArgs args) {
    const OutputArgs& r = args.outputs[blockIdx.z];
    u32 k = blockIdx.x * THREADS + threadIdx.x;
    if (blockIdx.y >= r.recorded_frames || k >= r.recorded_nodes) return;
    u32 n = r.node_count, node = r.nodes ? r.nodes[k] : k, frame = r.frames[blockIdx.y];
    const float* s = r.states + (u64)(frame % r.slot_count) * 6 * n;
    const u64 at = ((u64)blockIdx.y * r.recorded_nodes + k) * 3;
    for (u32 c = 0; c < 3; c++) r.positions[at + c] = s[c * n + node];
    if (!r.velocities) return;
    for (u32 c = 0; c < 3; c++) r.velocities[at + c] = s[(3 + c) * n + node];
}

// Block (frame - 1, instance).
extern "C" __global__ void __launch_bounds__(THREADS)
extremes(const __grid_constant__ ExtremesArgs args) {
    const OutputArgs& r = args.outputs[blockIdx.y];
    u32 frame = blockIdx.x + 1, n = r.node_count;
    if (frame > r.frame_count) return;
    const float* s = r.states + (u64)(frame % r.slot_count) * 6 * n;
    const float* held = r.controls + (u64)frame * r.control_count * 3;
    float strains[2] = {0.0f, 0.0f}, square = 0.0f;
    for (u32 e = threadIdx.x; e < r.spring_count; e += THREADS) {
        float3 ends[2];
        u32 held_ends = 0;
        for (u32 k = 0; k < 2; k++) {
            u32 i = r.springs[2 * (u64)e + k];
            held_ends |= i >= n;
            ends[k] = i < n ? v3(s[i], s[n + i], s[2 * n + i]) : load_v3(held + 3 * (u64)(i - n));
        }
        float rest = r.params[2 * (u64)r.spring_count + e];
        float3 d = sub(ends[1], ends[0]);
        if (!(rest > 0.0f)) continue;
        float& most = strains[held_ends];
        most = fmaxf(most, fabsf(sqrtf(dot(d, d)) / rest - 1.0f));
    }
    for (u32 i = threadIdx.x; i < n; i += THREADS) {
        float3 v = v3(s[3 * n + i], s[4 * n + i], s[5 * n + i]);
        square = fmaxf(square, dot(v, v));
    }
    for (u32 k = 0; k < 2; k++) strains[k] = block_max(strains[k]);
    square = block_max(square);
    if (threadIdx.x == 0) {
        float* out = r.extremes + 3 * (u64)blockIdx.x;
        out[0] = strains[0];
        out[1] = strains[1];
        out[2] = sqrtf(square);
    }
}

// Block (words, piece).
extern "C" __global__ void gather(const __grid_constant__ GatherArgs args) {
    const GatherPiece& p = args.pieces[blockIdx.y];
    const u64 step = (u64)gridDim.x * THREADS;
    for (u64 k = blockIdx.x * THREADS + threadIdx.x; k < p.count; k += step) {
        args.gathered[p.at + k] = p.from[k];
    }
}
