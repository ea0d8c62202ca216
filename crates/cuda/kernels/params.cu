// Parameters and their gradients. Both are one array of floats in the order of the host's `Params`:
// stiffness [E], dashpot [E], rest length [E], bend stiffness [T], bend damping [T], rest angle
// [T], twist stiffness [R], twist damping [R], rest twist [R]; then drag and the restitution and
// friction of ground and objects.

#define NONE 0xffffffffu

struct PackHalfSpringsArgs {
    float4* rates;         // [pairs]
    u32* packed_others;    // [pairs]
    float2* dashpots;      // [pairs]
    const u32* springs;    // [pairs][2]
    const u32* others;     // [pairs][2]
    const float* params;
    u32 pair_count;
    u32 spring_count;      // E
};

// Half-springs as one shape of launch wants them, in pairs: combined with rest lengths, beside the
// other ends' indices.
extern "C" __global__ void pack_half_springs(const __grid_constant__ PackHalfSpringsArgs args) {
    const float* params = args.params;
    const u32 e = args.spring_count;
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= args.pair_count) return;
    float rate[2] = {0.0f, 0.0f}, rest[2] = {0.0f, 0.0f}, dashpot[2] = {0.0f, 0.0f};
    for (u32 k = 0; k < 2; k++) {
        u32 spring = args.springs[2 * i + k];
        if (spring == NONE) continue;
        rest[k] = params[2 * (u64)e + spring];
        float r = params[spring] / rest[k];
        rate[k] = rest[k] > 0.0f && isfinite(r) ? r : 0.0f;
        dashpot[k] = params[e + spring];
    }
    args.rates[i] = make_float4(rate[0], rest[0], rate[1], rest[1]);
    args.packed_others[i] = args.others[2 * i] | args.others[2 * i + 1] << 16;
    args.dashpots[i] = make_float2(dashpot[0], dashpot[1]);
}

struct PackBendsArgs {
    float4* out;            // [count]
    const u32* triplets;    // [count]: index in the graph
    const float* params;
    u32 count;
    u32 spring_count;       // E
    u32 triplet_count;      // T
    u32 pad;
};

// Triplets as one shape of launch wants them.
extern "C" __global__ void pack_bends(const __grid_constant__ PackBendsArgs args) {
    const u32 e = args.spring_count, t = args.triplet_count;
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= args.count) return;
    const float* bend = args.params + 3 * (u64)e + args.triplets[i];
    // A float's pi is not quite pi: straight rest angles are exactly so.
    double rest = 3.14159265358979323846 - (double)bend[2 * (u64)t];
    float rest_bend = fabs(rest) < STRAIGHT_RAD ? 0.0f : (float)rest;
    args.out[i] = make_float4(bend[0], bend[t], rest_bend, 0.0f);
}

struct GatherSumsArgs {
    float* total;         // [3][E], then `other_count` more
    const float* sums;    // [window_count], `stride` floats apart
    const u32* sum_of;    // [E]: where a spring's sums begin
    u64 stride;
    u32 window_count;
    u32 spring_count;     // E
    u32 other_count;
    u32 first_other;
};

// Adds up what the windows of an instance have summed: per spring from `sum_of` on, then the others
// from `first_other` on.
extern "C" __global__ void gather_sums(const __grid_constant__ GatherSumsArgs args) {
    float* total = args.total;
    const float* sums = args.sums;
    const u64 stride = args.stride;
    const u32 e = args.spring_count, windows = args.window_count;
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= e + args.other_count) return;
    if (i >= e) {
        u64 k = i - e;
        float sum = total[3 * (u64)e + k];
        for (u32 w = 0; w < windows; w++) sum += sums[w * stride + args.first_other + k];
        total[3 * (u64)e + k] = sum;
        return;
    }
    float sum[3];
    for (u32 k = 0; k < 3; k++) sum[k] = total[k * (u64)e + i];
    for (u32 w = 0; w < windows; w++) {
        const float* own = sums + w * stride + args.sum_of[i];
        for (u32 k = 0; k < 3; k++) sum[k] += own[32 * k];
    }
    for (u32 k = 0; k < 3; k++) total[k * (u64)e + i] = sum[k];
}

struct FinishGradientArgs {
    float* out;            // as the parameters
    const float* sums;
    const float* params;
    u32 spring_count;      // E
    u32 hinge_count;       // triplets and rods
    u32 block_count;
    u32 pad;
};

// d loss / d parameters from the spring sums [3][E], the bend sums [3][T], those of rods [3][R] and
// the law sums [blocks][5].
extern "C" __global__ void finish_gradient(const __grid_constant__ FinishGradientArgs args) {
    float* out = args.out;
    const float *sums = args.sums, *params = args.params;
    const u32 e = args.spring_count, t = args.hinge_count;
    u64 i = (u64)blockIdx.x * THREADS + threadIdx.x;
    const u64 laws = 3 * (u64)e + 3 * (u64)t;
    if (i < e) {
        float stretch = sums[i], pull = sums[e + i];
        float rest = params[2 * (u64)e + i];
        float rate = params[i] / rest;
        bool has_rest = rest > 0.0f;
        rate = has_rest && isfinite(rate) ? rate : 0.0f;
        out[i] = has_rest ? stretch / rest : 0.0f;
        out[e + i] = sums[2 * (u64)e + i];
        out[2 * (u64)e + i] = has_rest ? -rate * (fmaf(rest, pull, stretch) / rest) : 0.0f;
    } else if (i >= 3 * (u64)e && i < laws) {
        out[i] = sums[i];
    } else if (i >= laws && i < laws + 5) {
        float sum = 0.0f;
        for (u32 b = 0; b < args.block_count; b++) sum += sums[laws + 5 * b + (i - laws)];
        out[i] = sum;
    }
}

struct CollectControlsArgs {
    const InstanceArgs* instances;
    float* const* outs;    // by instance: [frames + 1][C][3]
    u32 block_count;
    u32 pad;
};

// Adds a frame's d loss / d (from, to, velocity) of control points and pins to d loss / d controls,
// shape [frames + 1][C][3], and clears them.
extern "C" __global__ void collect_controls(const __grid_constant__ CollectControlsArgs args) {
    const InstanceArgs& instance = args.instances[blockIdx.y];
    const u32 c = instance.topology.control_count;
    u32 control = blockIdx.x * THREADS + threadIdx.x;
    if (control >= c) return;
    float sum[9];
    for (u32 k = 0; k < 9; k++) {
        sum[k] = 0.0f;
        for (u32 b = 0; b < args.block_count; b++) {
            float* from = instance.adjoint.control_sums + ((u64)b * 9 + k) * c + control;
            sum[k] += *from;
            *from = 0.0f;
        }
        for (u32 p = 0; p < instance.topology.pin_count; p++) {
            if (instance.topology.pins[p].control != control) continue;
            float* from = instance.adjoint.pin_sums + k * instance.topology.pin_count + p;
            sum[k] += *from;
            *from = 0.0f;
        }
    }
    float rate = instance.step.controls_move ? 1.0f / instance.step.frame_s : 0.0f;
    float* from = args.outs[blockIdx.y] + ((u64)instance.state.first_frame * c + control) * 3;
    float* to = from + 3 * c;
    for (u32 k = 0; k < 3; k++) {
        from[k] += sum[k] - rate * sum[6 + k];
        to[k] += sum[3 + k] + rate * sum[6 + k];
    }
}

struct NormBarsArgs {
    const InstanceArgs* instances;
    double* const* outs;  // by instance
};

// Norm of d loss / d positions of the nodes that nothing pins: a block for an instance.
extern "C" __global__ void __launch_bounds__(THREADS)
norm_bars(const __grid_constant__ NormBarsArgs args) {
    const InstanceArgs& instance = args.instances[blockIdx.x];
    double sum = 0.0;
    for (u32 i = threadIdx.x; i < instance.topology.node_count; i += THREADS) {
        if (instance.topology.pin_of[i] >= 0) continue;
        float4 x = instance.adjoint.bar_x[i];
        sum += (double)x.x * x.x + (double)x.y * x.y + (double)x.z * x.z;
    }
    sum = block_sum(sum);
    if (threadIdx.x == 0) *args.outs[blockIdx.x] = sqrt(sum);
}

struct AddSeedsArgs {
    const InstanceArgs* instances;
    const float* const* seeds;  // by instance: d loss / d positions, [3][N]
    u32 begins;                 // whether the backward pass begins here
    u32 pad;
};

// Starts or resumes a window: d loss / d state at the end of frame `StateArgs::first_frame` - 1 is
// the adjoint so far (nothing if `begins`) plus the seed of that frame's terms.
extern "C" __global__ void add_seeds(const __grid_constant__ AddSeedsArgs args) {
    const InstanceArgs& instance = args.instances[blockIdx.y];
    const u32 begins = args.begins;
    const u32 n = instance.topology.node_count;
    u32 node = blockIdx.x * THREADS + threadIdx.x;
    // Nothing is measured of twists by themselves.
    for (u32 r = node; begins && r < instance.topology.rod_count; r += gridDim.x * THREADS)
        instance.adjoint.bar_twists[r] = 0.0f;
    if (node >= n) return;
    const float* s = args.seeds[blockIdx.y];
    float3 x = begins ? zero3() : xyz(instance.adjoint.bar_x[node]);
    float3 v = begins ? zero3() : xyz(instance.adjoint.bar_v[node]);
    x = add(x, v3(s[node], s[n + node], s[2 * n + node]));
    instance.adjoint.bar_x[node] = with_w(x, 0.0f);
    instance.adjoint.bar_v[node] = with_w(v, 0.0f);
}
