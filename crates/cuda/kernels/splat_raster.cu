// Images of Gaussians and the adjoint: a block for a tile, a thread for a pixel. The adjoint goes front to back like the image, with the same decisions; see crates/splat/src/cpu/backward.rs.

// Gaussians that a block has in shared memory at a time, forward and backward.
#define BATCH THREADS
#define BACK_BATCH 32u

struct SplatForwardArgs {
    SplatCamera camera;
    const Splat* splats;
    const u32* entries;
    const uint2* ranges;    // [tiles]
    float* color;           // [pixels][3]
    float* alpha;           // [pixels]
    float* depth;           // [pixels]
};

extern "C" __global__ void __launch_bounds__(THREADS)
splat_forward(const __grid_constant__ SplatForwardArgs args) {
    __shared__ Splat batch[BATCH];
    const uint2 pixel = own_pixel(args.camera), range = args.ranges[blockIdx.x];
    const bool is_inside = pixel.x < args.camera.width && pixel.y < args.camera.height;
    const float x = (float)pixel.x, y = (float)pixel.y;
    float left = is_inside ? 1.0f : 0.0f, alpha_sum = 0.0f, depth = 0.0f;
    float3 color = zero3();
    for (u32 first = range.x; first < range.y; first += BATCH) {
        if (__syncthreads_count(left > 0.0f) == 0) break;
        u32 count = min(range.y - first, BATCH);
        if (threadIdx.x < count) batch[threadIdx.x] = args.splats[args.entries[first + threadIdx.x]];
        __syncthreads();
        for (u32 k = 0; k < count && left > 0.0f; k++) {
            const Splat& s = batch[k];
            float alpha = fminf(opacity_at(s, x - s.a.x, y - s.a.y), SPLAT_MOST_ALPHA);
            if (alpha < SPLAT_LEAST_ALPHA) continue;
            float next = left * (1.0f - alpha);
            if (next < SPLAT_LEAST_TRANSMITTANCE) {
                left = 0.0f;
                break;
            }
            float weight = alpha * left;
            color = add_scaled(color, weight, xyz(s.c));
            alpha_sum += weight;
            depth += weight * s.b.z;
            left = next;
        }
    }
    if (!is_inside) return;
    u32 at = pixel.y * args.camera.width + pixel.x;
    put3(args.color, at, color);
    args.alpha[at] = alpha_sum;
    args.depth[at] = depth;
}

struct SplatBackwardArgs {
    SplatCamera camera;
    const Splat* splats;
    const u32* entries;
    const u32* places;      // [intersections]: intersection of each entry
    const uint2* ranges;    // [tiles]
    const float* color;     // [pixels][3]: the image
    const float* alpha;
    const float* depth;
    const float* color_bar; // [pixels][3]: d loss / d image
    const float* alpha_bar;
    const float* depth_bar;
    float* moments;         // [intersections][MOMENTS]
};

// Sum over a warp, in a fixed order.
DEVICE float warp_sum(float x) {
#pragma unroll
    for (int mask = 16; mask > 0; mask /= 2) x += __shfl_xor_sync(0xffffffffu, x, mask);
    return x;
}

// Moments of each entry: with s = alpha d loss / d alpha, sums over pixels of s, s dx, s dy, s dx²,
// s dx dy, s dy², and of weights times d loss / d red, green, blue, depth.
extern "C" __global__ void __launch_bounds__(THREADS)
splat_backward(const __grid_constant__ SplatBackwardArgs args) {
    __shared__ Splat batch[BACK_BATCH];
    __shared__ u32 places[BACK_BATCH];
    __shared__ float sums[THREADS / 32][BACK_BATCH][MOMENTS];
    const uint2 pixel = own_pixel(args.camera), range = args.ranges[blockIdx.x];
    const bool is_inside = pixel.x < args.camera.width && pixel.y < args.camera.height;
    const u32 lane = threadIdx.x % 32, warp = threadIdx.x / 32;
    const float x = (float)pixel.x, y = (float)pixel.y;
    float left = 0.0f, rest = 0.0f, alpha_bar = 0.0f, depth_bar = 0.0f;
    float3 color_bar = zero3();
    if (is_inside) {
        u32 at = pixel.y * args.camera.width + pixel.x;
        left = 1.0f;
        color_bar = at3(args.color_bar, at);
        alpha_bar = args.alpha_bar[at];
        depth_bar = args.depth_bar[at];
        rest = dot(at3(args.color, at), color_bar) + args.alpha[at] * alpha_bar +
               args.depth[at] * depth_bar;
    }
    u32 first = range.x;
    for (; first < range.y; first += BACK_BATCH) {
        if (__syncthreads_count(left > 0.0f) == 0) break;
        u32 count = min(range.y - first, BACK_BATCH);
        if (threadIdx.x < count) {
            batch[threadIdx.x] = args.splats[args.entries[first + threadIdx.x]];
            places[threadIdx.x] = args.places[first + threadIdx.x];
        }
        __syncthreads();
        for (u32 k = 0; k < count; k++) {
            const Splat& s = batch[k];
            float dx = x - s.a.x, dy = y - s.a.y;
            float raw = left > 0.0f ? opacity_at(s, dx, dy) : 0.0f;
            float alpha = fminf(raw, SPLAT_MOST_ALPHA), clear = 1.0f - alpha, next = left * clear;
            bool is_seen = alpha >= SPLAT_LEAST_ALPHA;
            bool counts = is_seen && next >= SPLAT_LEAST_TRANSMITTANCE;
            float m[MOMENTS] = {};
            bool any = __any_sync(0xffffffffu, counts);
            if (any) {
                float weight = 0.0f, moment = 0.0f;
                if (counts) {
                    weight = alpha * left;
                    float q = dot(color_bar, xyz(s.c)) + (alpha_bar + depth_bar * s.b.z);
                    rest -= weight * q;
                    if (raw < SPLAT_MOST_ALPHA) moment = alpha * (left * q - rest / clear);
                }
                m[0] = moment;
                m[1] = moment * dx;
                m[2] = moment * dy;
                m[3] = m[1] * dx;
                m[4] = m[1] * dy;
                m[5] = m[2] * dy;
                m[6] = weight * color_bar.x;
                m[7] = weight * color_bar.y;
                m[8] = weight * color_bar.z;
                m[9] = weight * depth_bar;
#pragma unroll
                for (u32 c = 0; c < MOMENTS; c++) m[c] = warp_sum(m[c]);
            }
            if (is_seen) left = counts ? next : 0.0f;
            if (lane == 0) {
#pragma unroll
                for (u32 c = 0; c < MOMENTS; c++) sums[warp][k][c] = m[c];
            }
        }
        __syncthreads();
        for (u32 n = threadIdx.x; n < count * MOMENTS; n += THREADS) {
            u32 k = n / MOMENTS, c = n % MOMENTS;
            float sum = 0.0f;
            for (u32 w = 0; w < THREADS / 32; w++) sum += sums[w][k][c];
            args.moments[(size_t)places[k] * MOMENTS + c] = sum;
        }
    }
    // Behind what is opaque nothing changes the loss.
    for (u32 k = first + threadIdx.x; k < range.y; k += THREADS) {
        float* out = args.moments + (size_t)args.places[k] * MOMENTS;
        for (u32 c = 0; c < MOMENTS; c++) out[c] = 0.0f;
    }
}
