// Gaussian splats: sets of them, cameras, and the projection of one, as in crates/splat/src/cpu/projection.rs.

// Digits of a pass of the sort.
#define RADIX 256u
// Pairs that a block of the sort takes: a contiguous piece for each of its warps.
#define SORT_ROUNDS 8u
#define SORT_PIECE (32u * SORT_ROUNDS)
#define SORT_BLOCK (THREADS * SORT_ROUNDS)
// Floats of a projected Gaussian's derivatives from a tile.
#define MOMENTS 10u
// Key of an invisible Gaussian: behind all others.
#define UNSEEN 0xffffffffu

struct SplatCamera {
    float rows[3][4];   // world to camera
    float fx, fy, cx, cy;
    u32 width, height;
    u32 columns, tiles; // tiles of a row, and of the image
};

struct SplatSet {
    const float4* rotations;    // [count]
    const float* means;         // [count][3]
    const float* scales;        // [count][3]
    const float* colors;        // [count][3]
    const float* opacities;     // [count]
    u32 count;
    u32 pad;
};

DEVICE float4 row(const SplatCamera& camera, int r) {
    const float* a = camera.rows[r];
    return make_float4(a[0], a[1], a[2], a[3]);
}

DEVICE float3 at3(const float* values, u32 i) {
    return v3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
}

DEVICE void put3(float* values, u32 i, float3 a) {
    values[3 * i] = a.x;
    values[3 * i + 1] = a.y;
    values[3 * i + 2] = a.z;
}

// Intermediate values of a projection. Rows of matrices are vectors; `turned` and `axes` are of the
// two coordinates of the image.
struct Projection {
    float3 mean;            // in the camera's frame
    float tangents[2];
    bool is_free[2];        // a tangent is not clamped
    float4 unit;            // quaternion
    float length;           // of the quaternion before normalisation
    float3 rotation[3];     // its matrix
    float3 rows[2];         // W_1 - t_x W_3, W_2 - t_y W_3
    float3 turned[2];
    float3 axes[2];
    float3 normal;          // of both axes
    float area;
    float xx, xy, yy;       // covariance with the blur
    float determinant;
};

DEVICE float3 turned_back(const float3* rotation, float3 a) {
    return add_scaled(add_scaled(scale(rotation[0], a.x), a.y, rotation[1]), a.z, rotation[2]);
}

// False in front of the near plane.
DEVICE bool project(const SplatSet& set, u32 i, const SplatCamera& camera, Projection& p) {
    const float4 w[3] = {row(camera, 0), row(camera, 1), row(camera, 2)};
    float3 mean = at3(set.means, i);
    p.mean = v3(dot(xyz(w[0]), mean) + w[0].w, dot(xyz(w[1]), mean) + w[1].w,
                dot(xyz(w[2]), mean) + w[2].w);
    if (!(p.mean.z >= SPLAT_NEAR_M)) return false;
    const float ratios[2] = {p.mean.x / p.mean.z, p.mean.y / p.mean.z};
    const float focal[2] = {camera.fx / p.mean.z, camera.fy / p.mean.z};
    float4 q = set.rotations[i];
    p.length = sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    float x = q.x / p.length, y = q.y / p.length, z = q.z / p.length, s = q.w / p.length;
    p.unit = make_float4(x, y, z, s);
    p.rotation[0] = v3(1 - 2 * (y * y + z * z), 2 * (x * y - s * z), 2 * (x * z + s * y));
    p.rotation[1] = v3(2 * (x * y + s * z), 1 - 2 * (x * x + z * z), 2 * (y * z - s * x));
    p.rotation[2] = v3(2 * (x * z - s * y), 2 * (y * z + s * x), 1 - 2 * (x * x + y * y));
    float3 scales = at3(set.scales, i);
#pragma unroll
    for (int r = 0; r < 2; r++) {
        p.tangents[r] = fminf(fmaxf(ratios[r], -SPLAT_MOST_TANGENT), SPLAT_MOST_TANGENT);
        p.is_free[r] = p.tangents[r] == ratios[r];
        p.rows[r] = add_scaled(xyz(w[r]), -p.tangents[r], xyz(w[2]));
        p.turned[r] = turned_back(p.rotation, scale(p.rows[r], focal[r]));
        p.axes[r] = v3(p.turned[r].x * scales.x, p.turned[r].y * scales.y, p.turned[r].z * scales.z);
    }
    p.normal = cross(p.axes[0], p.axes[1]);
    p.area = sqrtf(dot(p.normal, p.normal));
    p.xy = dot(p.axes[0], p.axes[1]);
    float xx = dot(p.axes[0], p.axes[0]), yy = dot(p.axes[1], p.axes[1]);
    p.xx = xx + SPLAT_BLUR_PX2;
    p.yy = yy + SPLAT_BLUR_PX2;
    p.determinant =
        p.area * p.area + SPLAT_BLUR_PX2 * (xx + yy) + SPLAT_BLUR_PX2 * SPLAT_BLUR_PX2;
    return true;
}

// What tiles need of a projected Gaussian beside its centre.
struct Extent {
    float reach;        // half the height of its ellipse
    float lean;         // row of its largest column, from the centre
    float slope;        // columns by which its middle moves from a row to the next
    float half_width;   // in the row of the centre
};

// First and last whole number of an interval within 0 and `last`; false if the interval has none.
DEVICE bool whole(float from, float to, float last, u32& first, u32& end) {
    from = fmaxf(ceilf(from), 0.0f);
    to = fminf(floorf(to), last);
    if (!(from <= to)) return false;
    first = (u32)from;
    end = (u32)to;
    return true;
}

DEVICE float edge(const Extent& e, float side, float from, float to) {
    float dy = fminf(fmaxf(side * e.lean, from), to), share = dy / e.reach;
    return e.slope * dy + side * e.half_width * sqrtf(fmaxf(1.0f - share * share, 0.0f));
}

// Calls `touch` with each tile that an ellipse touches, row by row.
template <typename Touch>
DEVICE void each_tile(float2 center, const Extent& e, const SplatCamera& camera, Touch touch) {
    u32 top, bottom;
    if (!whole(center.y - e.reach, center.y + e.reach, (float)(camera.height - 1), top, bottom))
        return;
    for (u32 row = top / SPLAT_TILE_PX; row <= bottom / SPLAT_TILE_PX; row++) {
        float from = (float)max(top, row * SPLAT_TILE_PX) - center.y;
        float to = (float)min(bottom, row * SPLAT_TILE_PX + SPLAT_TILE_PX - 1) - center.y;
        u32 left, right;
        if (!whole(center.x + edge(e, -1.0f, from, to), center.x + edge(e, 1.0f, from, to),
                   (float)(camera.width - 1), left, right))
            continue;
        for (u32 column = left / SPLAT_TILE_PX; column <= right / SPLAT_TILE_PX; column++)
            touch(row * camera.columns + column);
    }
}

// Pixel of a thread in a block's tile: a warp has 8 x 4 pixels.
DEVICE uint2 own_pixel(const SplatCamera& camera) {
    u32 warp = threadIdx.x / 32, lane = threadIdx.x % 32;
    u32 column = blockIdx.x % camera.columns, row = blockIdx.x / camera.columns;
    return make_uint2(column * SPLAT_TILE_PX + warp % 2 * 8 + lane % 8,
                      row * SPLAT_TILE_PX + warp / 2 * 4 + lane / 8);
}

// A projected Gaussian, as pixels need it.
struct Splat {
    float4 a;   // centre, A, B
    float4 b;   // C, opacity, depth
    float4 c;   // colour
};

// Its opacity at a pixel, before it is limited.
DEVICE float opacity_at(const Splat& s, float dx, float dy) {
    float power = 0.5f * (s.a.z * dx * dx + s.b.x * dy * dy) + s.a.w * dx * dy;
    return s.b.y * __expf(-fmaxf(power, 0.0f));
}
