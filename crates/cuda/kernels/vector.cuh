// Three-vectors, and the two approximations that every force is built on.

typedef unsigned int u32;
typedef unsigned short u16;
typedef unsigned long long u64;

#define DEVICE static __device__ __forceinline__
#define DEVICE_MEMBER __device__ __forceinline__

// First byte of a field in a struct, as a constant: NVRTC has no `offsetof`, this is the one of its
// front end.
#define OFFSET_OF(type, field) __INTADDR__(&((type*)0)->field)

// Control points that a grasp has released stand this far away, out of reach of what they held.
#define FAR_M 1e18f
#define FAR_SQUARED_M2 1e30f

DEVICE float3 v3(float x, float y, float z) { return make_float3(x, y, z); }
DEVICE float3 xyz(float4 a) { return make_float3(a.x, a.y, a.z); }
DEVICE float4 with_w(float3 a, float w) { return make_float4(a.x, a.y, a.z, w); }
DEVICE float3 zero3() { return make_float3(0.0f, 0.0f, 0.0f); }
DEVICE float4 zero4() { return make_float4(0.0f, 0.0f, 0.0f, 0.0f); }
DEVICE float3 add(float3 a, float3 b) { return v3(a.x + b.x, a.y + b.y, a.z + b.z); }
DEVICE float3 sub(float3 a, float3 b) { return v3(a.x - b.x, a.y - b.y, a.z - b.z); }
DEVICE float3 scale(float3 a, float s) { return v3(a.x * s, a.y * s, a.z * s); }
// a + s b.
DEVICE float3 add_scaled(float3 a, float s, float3 b) {
    return v3(fmaf(s, b.x, a.x), fmaf(s, b.y, a.y), fmaf(s, b.z, a.z));
}
DEVICE float dot(float3 a, float3 b) { return fmaf(a.x, b.x, fmaf(a.y, b.y, a.z * b.z)); }
DEVICE float3 cross(float3 a, float3 b) {
    return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

// 1 / sqrt(x); zero where x is below the square of the shortest length that has a direction.
DEVICE float inverse_length(float square) {
    return square > MIN_LENGTH_SQUARED_M2 ? rsqrtf(square) : 0.0f;
}

// Sum over the LANES adjacent lanes that share a node; every one of them gets it, bit for bit.
DEVICE float sum_lanes(float x) {
#pragma unroll
    for (int mask = LANES / 2; mask > 0; mask /= 2) x += __shfl_xor_sync(0xffffffffu, x, mask);
    return x;
}
DEVICE float3 sum_lanes(float3 a) { return v3(sum_lanes(a.x), sum_lanes(a.y), sum_lanes(a.z)); }
