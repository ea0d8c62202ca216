// Parameters and their gradients. Both are one array of floats in the order of the host's `Params`:
// stiffness [E], dashpot [E], rest length [E], bend stiffness [T], bend damping [T], rest angle [T], twist stiffness [R],
// twist damping [R], rest twist [R]; then drag and the restitution and friction of ground and objects.

#define NONE 0xffffffffu

// Half-springs as one shape of launch wants them, in pairs: combined with rest lengths, beside the other ends'
// indices.
extern "C" __global__ void pack_half_springs(
    float4* rates, u32* packed_others, float2* dashpots, const u32* springs, const u32* others,
    const float* params, u32 pairs, u32 e
) {
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= pairs) return;
    float rate[2] = {0.0f, 0.0f}, rest[2] = {0.0f, 0.0f}, dashpot[2] = {0.0f, 0.0f};
    for (u32 k = 0; k < 2; k++) {
        u32 spring = springs[2 * i + k];
        if (spring == NONE) continue;
        rest[k] = params[2 * (u64)e + spring];
        float r = params[spring] / rest[k];
        rate[k] = rest[k] > 0.0f && isfinite(r) ? r : 0.0f;
        dashpot[k] = params[e + spring];
    }
    rates[i] = make_float4(rate[0], rest[0], rate[1], rest[1]);
    packed_others[i] = others[2 * i] | others[2 * i + 1] << 16;
    dashpots[i] = make_float2(dashpot[0], dashpot[1]);
}

extern "C" __global__ void
pack_bends(float4* out, const u32* triplets, const float* params, u32 count, u32 e, u32 t) {
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= count) return;
    const float* bend = params + 3 * (u64)e + triplets[i];
    // A float's pi is not quite pi: straight rest angles are exactly so.
    double rest = 3.14159265358979323846 - (double)bend[2 * (u64)t];
    float rest_bend = fabs(rest) < 1e-6 ? 0.0f : (float)rest;
    out[i] = make_float4(bend[0], bend[t], rest_bend, 0.0f);
}

// Adds up what the windows of an instance have summed, `stride` floats apart: per spring from `sum_of` on, then
// `others` more behind `first_other`. `total` is [3][E], then those.
extern "C" __global__ void gather_sums(
    float* total, const float* sums, const u32* sum_of, u32 windows, u64 stride, u32 e, u32 others,
    u32 first_other
) {
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= e + others) return;
    if (i >= e) {
        u64 k = i - e;
        float sum = total[3 * (u64)e + k];
        for (u32 w = 0; w < windows; w++) sum += sums[w * stride + first_other + k];
        total[3 * (u64)e + k] = sum;
        return;
    }
    float sum[3];
    for (u32 k = 0; k < 3; k++) sum[k] = total[k * (u64)e + i];
    for (u32 w = 0; w < windows; w++) {
        const float* own = sums + w * stride + sum_of[i];
        for (u32 k = 0; k < 3; k++) sum[k] += own[32 * k];
    }
    for (u32 k = 0; k < 3; k++) total[k * (u64)e + i] = sum[k];
}

// d loss / d parameters from the spring sums [3][E], the bend sums [3][T], those of rods [3][R] and the law sums
// [blocks][5]; `t` counts triplets and rods.
extern "C" __global__ void
finish_gradient(float* out, const float* sums, const float* params, u32 e, u32 t, u32 blocks) {
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
        for (u32 b = 0; b < blocks; b++) sum += sums[laws + 5 * b + (i - laws)];
        out[i] = sum;
    }
}

// Adds a frame's d loss / d (from, to, velocity) of control points and pins to d loss / d controls, shape
// [frames + 1][C][3], and clears them.
extern "C" __global__ void collect_controls(const Job* jobs, float* const* outs, u32 blocks) {
    const Job& job = jobs[blockIdx.y];
    const u32 c = job.topology.controls;
    u32 control = blockIdx.x * THREADS + threadIdx.x;
    if (control >= c) return;
    float sum[9];
    for (u32 k = 0; k < 9; k++) {
        sum[k] = 0.0f;
        for (u32 b = 0; b < blocks; b++) {
            float* from = job.control_sums + ((u64)b * 9 + k) * c + control;
            sum[k] += *from;
            *from = 0.0f;
        }
        for (u32 p = 0; p < job.pins; p++) {
            if (job.topology.pins[p].control != control) continue;
            float* from = job.pin_sums + k * job.pins + p;
            sum[k] += *from;
            *from = 0.0f;
        }
    }
    float rate = job.controls_move ? 1.0f / job.frame_s : 0.0f;
    float* from = outs[blockIdx.y] + ((u64)job.first * c + control) * 3;
    float* to = from + 3 * c;
    for (u32 k = 0; k < 3; k++) {
        from[k] += sum[k] - rate * sum[6 + k];
        to[k] += sum[3 + k] + rate * sum[6 + k];
    }
}

// Starts or goes on with a window: d loss / d state at the end of frame `Job::first` - 1 is what came back so
// far (nothing if `begins`) plus the seed of that frame's own terms.
extern "C" __global__ void add_seeds(const Job* jobs, const float* const* seeds, u32 begins) {
    const Job& job = jobs[blockIdx.y];
    const u32 n = job.topology.node_count;
    u32 node = blockIdx.x * THREADS + threadIdx.x;
    // Nothing is measured of twists by themselves.
    for (u32 r = node; begins && r < job.topology.rods; r += gridDim.x * THREADS)
        job.twist_bars[r] = 0.0f;
    if (node >= n) return;
    const float* s = seeds[blockIdx.y];
    float3 x = begins ? zero3() : xyz(job.bar_x[node]);
    float3 v = begins ? zero3() : xyz(job.bar_v[node]);
    x = add(x, v3(s[node], s[n + node], s[2 * n + node]));
    job.bar_x[node] = with_w(x, 0.0f);
    job.bar_v[node] = with_w(v, 0.0f);
}
