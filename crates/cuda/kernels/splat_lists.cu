// Projected Gaussians, and for each tile the list of those that touch it, by depth: sorts by depth, then by tile, both stable.

struct SplatProjectArgs {
    SplatSet set;
    SplatCamera camera;
    Splat* splats;      // [count]
    Extent* extents;    // [count]
    u32* counts;        // [count]: tiles that each touches
    u32* keys;          // [count]: depths as bits
    u32* indices;       // [count]
};

// Projects a Gaussian, a thread each.
extern "C" __global__ void splat_project(const __grid_constant__ SplatProjectArgs args) {
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= args.set.count) return;
    args.indices[i] = i;
    args.counts[i] = 0;
    args.keys[i] = UNSEEN;
    Projection p;
    if (!project(args.set, i, args.camera, p)) return;
    float opacity = args.set.opacities[i] * (p.area / sqrtf(p.determinant));
    if (!(opacity >= SPLAT_LEAST_ALPHA && isfinite(p.determinant))) return;
    // A little more than where alpha is the least: the pixels decide.
    float square = 2.0f * fmaxf(logf(opacity / SPLAT_LEAST_ALPHA), 0.0f) + 1e-4f;
    float2 center = make_float2(args.camera.fx * p.mean.x / p.mean.z + args.camera.cx,
                                args.camera.fy * p.mean.y / p.mean.z + args.camera.cy);
    float inverse = 1.0f / p.determinant;
    Extent extent;
    extent.reach = sqrtf(square * p.yy);
    extent.lean = p.xy * sqrtf(square / p.xx);
    extent.slope = p.xy / p.yy;
    extent.half_width = sqrtf(square * p.determinant / p.yy);
    Splat splat;
    splat.a = make_float4(center.x, center.y, p.yy * inverse, -p.xy * inverse);
    splat.b = make_float4(p.xx * inverse, opacity, p.mean.z, 0.0f);
    splat.c = with_w(at3(args.set.colors, i), 0.0f);
    args.splats[i] = splat;
    args.extents[i] = extent;
    u32 count = 0;
    each_tile(center, extent, args.camera, [&](u32) { count++; });
    args.counts[i] = count;
    args.keys[i] = __float_as_uint(p.mean.z);
}

struct SplatHistogramArgs {
    const u32* keys;    // [count]
    u32* counts;        // [RADIX][blocks]: keys of a block by digit
    u32 count;
    u32 shift;          // first bit of the digit
};

// Keys of a piece by digit, a block each.
extern "C" __global__ void __launch_bounds__(THREADS)
splat_histogram(const __grid_constant__ SplatHistogramArgs args) {
    __shared__ u32 counts[RADIX];
    counts[threadIdx.x] = 0;
    __syncthreads();
    for (u32 k = 0; k < SORT_ROUNDS; k++) {
        u32 i = blockIdx.x * SORT_BLOCK + k * THREADS + threadIdx.x;
        // Counts are the same in any order.
        if (i < args.count) atomicAdd(&counts[args.keys[i] >> args.shift & (RADIX - 1)], 1u);
    }
    __syncthreads();
    args.counts[threadIdx.x * gridDim.x + blockIdx.x] = counts[threadIdx.x];
}

// Numbers of a thread of a scan.
#define SCAN_EACH 16u

struct SplatScanArgs {
    u32* values;    // [count]: become sums of those before
    u64* total;
    u32 count;
    u32 pad;
};

// Sums of all before, by one block.
extern "C" __global__ void __launch_bounds__(THREADS)
splat_scan(const __grid_constant__ SplatScanArgs args) {
    __shared__ u64 sums[THREADS / 32];
    const u32 lane = threadIdx.x % 32, warp = threadIdx.x / 32;
    u64 carry = 0;
    for (u32 first = 0; first < args.count; first += THREADS * SCAN_EACH) {
        u32 own[SCAN_EACH], at = first + threadIdx.x * SCAN_EACH;
        u64 sum = 0;
#pragma unroll
        for (u32 k = 0; k < SCAN_EACH; k++) {
            own[k] = at + k < args.count ? args.values[at + k] : 0;
            sum += own[k];
        }
        u64 scanned = sum;
#pragma unroll
        for (u32 d = 1; d < 32; d *= 2) {
            u64 other = __shfl_up_sync(0xffffffffu, scanned, d);
            if (lane >= d) scanned += other;
        }
        if (lane == 31) sums[warp] = scanned;
        __syncthreads();
        u64 running = carry + scanned - sum;
        for (u32 w = 0; w < THREADS / 32; w++) {
            if (w < warp) running += sums[w];
            carry += sums[w];
        }
#pragma unroll
        for (u32 k = 0; k < SCAN_EACH; k++) {
            if (at + k < args.count) args.values[at + k] = (u32)running;
            running += own[k];
        }
        __syncthreads();
    }
    if (threadIdx.x == 0) *args.total = carry;
}

struct SplatScatterArgs {
    const u32* keys;        // [count]
    const u32* values;      // [count]
    u32* sorted_keys;       // [count]
    u32* sorted_values;     // [count]
    const u32* offsets;     // [RADIX][blocks]: the first place of a block's keys with a digit
    u32 count;
    u32 shift;
};

// Moves pairs to their places by a digit, those with the same in the order in which they were. A
// block has the piece of its histogram; each of its warps a contiguous part.
extern "C" __global__ void __launch_bounds__(THREADS)
splat_scatter(const __grid_constant__ SplatScatterArgs args) {
    __shared__ u32 places[THREADS / 32][RADIX];
    const u32 lane = threadIdx.x % 32, warp = threadIdx.x / 32;
    for (u32 w = 0; w < THREADS / 32; w++) places[w][threadIdx.x] = 0;
    __syncthreads();
    const u32 first = blockIdx.x * SORT_BLOCK + warp * SORT_PIECE + lane;
    u32 keys[SORT_ROUNDS], values[SORT_ROUNDS];
#pragma unroll
    for (u32 k = 0; k < SORT_ROUNDS; k++) {
        u32 i = first + 32 * k;
        if (i >= args.count) continue;
        keys[k] = args.keys[i];
        values[k] = args.values[i];
        atomicAdd(&places[warp][keys[k] >> args.shift & (RADIX - 1)], 1u);
    }
    __syncthreads();
    u32 place = args.offsets[threadIdx.x * gridDim.x + blockIdx.x];
    for (u32 w = 0; w < THREADS / 32; w++) {
        u32 count = places[w][threadIdx.x];
        places[w][threadIdx.x] = place;
        place += count;
    }
    __syncthreads();
#pragma unroll
    for (u32 k = 0; k < SORT_ROUNDS; k++) {
        bool is_there = first + 32 * k < args.count;
        u32 digit = is_there ? keys[k] >> args.shift & (RADIX - 1) : RADIX;
        u32 same = __match_any_sync(0xffffffffu, digit);
        u32 before = __popc(same & ((1u << lane) - 1));
        u32 to = is_there ? places[warp][digit] + before : 0;
        __syncwarp();
        if (is_there && before == 0) places[warp][digit] += __popc(same);
        __syncwarp();
        if (!is_there) continue;
        args.sorted_keys[to] = keys[k];
        args.sorted_values[to] = values[k];
    }
}

struct SplatCountsArgs {
    const u32* counts;  // [count] by index
    const u32* order;   // [count]: indices by depth
    u32* offsets;       // [count] by depth
    u32 count;
    u32 pad;
};

// Counts of tiles in the order of depths.
extern "C" __global__ void splat_counts(const __grid_constant__ SplatCountsArgs args) {
    u32 r = blockIdx.x * THREADS + threadIdx.x;
    if (r < args.count) args.offsets[r] = args.counts[args.order[r]];
}

struct SplatExpandArgs {
    SplatCamera camera;
    const Splat* splats;
    const Extent* extents;
    const u32* counts;      // [count] by index
    const u32* order;       // [count]: indices by depth
    const u32* offsets;     // [count]: first intersection of each, by depth
    u32* keys;              // [intersections]: tile
    u32* values;            // [intersections]: intersection
    u32* owners;            // [intersections]: index of the Gaussian
    u32 count;
    u32 pad;
};

// Intersections of Gaussians with tiles, by depth and then by tile, a thread for a Gaussian.
extern "C" __global__ void splat_expand(const __grid_constant__ SplatExpandArgs args) {
    u32 r = blockIdx.x * THREADS + threadIdx.x;
    if (r >= args.count) return;
    u32 i = args.order[r];
    if (args.counts[i] == 0) return;
    u32 at = args.offsets[r];
    float4 a = args.splats[i].a;
    each_tile(make_float2(a.x, a.y), args.extents[i], args.camera, [&](u32 tile) {
        args.keys[at] = tile;
        args.values[at] = at;
        args.owners[at] = i;
        at++;
    });
}

struct SplatRangesArgs {
    const u32* keys;    // [count]: tiles, sorted
    const u32* values;  // [count]: intersections in this order
    const u32* owners;  // [count]
    u32* entries;       // [count]: Gaussians in this order
    uint2* ranges;      // [tiles]: first entry and end; zeros before
    u32 count;
    u32 pad;
};

// Entries of each tile.
extern "C" __global__ void splat_ranges(const __grid_constant__ SplatRangesArgs args) {
    u32 k = blockIdx.x * THREADS + threadIdx.x;
    if (k >= args.count) return;
    args.entries[k] = args.owners[args.values[k]];
    u32 tile = args.keys[k];
    if (k == 0 || args.keys[k - 1] != tile) args.ranges[tile].x = k;
    if (k + 1 == args.count || args.keys[k + 1] != tile) args.ranges[tile].y = k + 1;
}
