// Adjoint of the projection, as in crates/splat/src/cpu/projection.rs.

struct SplatAdjointArgs {
    SplatSet set;
    SplatCamera camera;
    const Splat* splats;
    const u32* counts;      // [count] by index
    const u32* order;       // [count]: indices by depth
    const u32* offsets;     // [count]: first intersection of each, by depth
    const float* moments;   // [intersections][MOMENTS]
    float4* rotations;      // [count]: d loss / d each parameter
    float* means;           // [count][3]
    float* scales;          // [count][3]
    float* colors;          // [count][3]
    float* opacities;       // [count]
    float* screen;          // [count]
};

// Adds up a Gaussian's tiles, in their order, and passes the sum to its parameters: a thread for a Gaussian.
extern "C" __global__ void splat_adjoint(const __grid_constant__ SplatAdjointArgs args) {
    u32 r = blockIdx.x * THREADS + threadIdx.x;
    if (r >= args.set.count) return;
    u32 i = args.order[r], tiles = args.counts[i];
    Projection p;
    if (tiles == 0 || !project(args.set, i, args.camera, p)) {
        args.rotations[i] = zero4();
        put3(args.means, i, zero3());
        put3(args.scales, i, zero3());
        put3(args.colors, i, zero3());
        args.opacities[i] = 0.0f;
        args.screen[i] = 0.0f;
        return;
    }
    float m[MOMENTS] = {};
    const float* tile = args.moments + (size_t)args.offsets[r] * MOMENTS;
    for (u32 k = 0; k < tiles; k++, tile += MOMENTS) {
#pragma unroll
        for (u32 c = 0; c < MOMENTS; c++) m[c] += tile[c];
    }
    const Splat s = args.splats[i];
    const float a = s.a.z, b = s.a.w, c = s.b.x;
    const float center[2] = {a * m[1] + b * m[2], b * m[1] + c * m[2]};

    // Covariance: -K G K.
    float ga = -0.5f * m[3], gb = -0.5f * m[4], gc = -0.5f * m[5];
    float k00 = a * ga + b * gb, k01 = a * gb + b * gc;
    float k10 = b * ga + c * gb, k11 = b * gb + c * gc;
    float xx = -(k00 * a + k01 * b), xy = -2.0f * (k00 * b + k01 * c), yy = -(k10 * b + k11 * c);

    // Compensation.
    float root = sqrtf(p.determinant), compensation = p.area / root;
    float opacity_bar = m[0] / s.b.y, compensation_bar = opacity_bar * args.set.opacities[i];
    float area_bar = compensation_bar * (1.0f - compensation * compensation) / root;
    float spread = -0.5f * compensation_bar * compensation / p.determinant * SPLAT_BLUR_PX2;
    xx += spread;
    yy += spread;

    float3 normal = p.area > 0.0f ? scale(p.normal, area_bar / p.area) : zero3();
    float3 by_first = cross(p.axes[1], normal), by_second = cross(normal, p.axes[0]);
    float3 axes_bar[2] = {
        add_scaled(add_scaled(by_first, 2.0f * xx, p.axes[0]), xy, p.axes[1]),
        add_scaled(add_scaled(by_second, 2.0f * yy, p.axes[1]), xy, p.axes[0]),
    };
    float3 scales = at3(args.set.scales, i), scales_bar = zero3();
    float3 rotation_bar[3] = {zero3(), zero3(), zero3()};
    float mean_bar[3] = {0.0f, 0.0f, m[9]};
    const float ratios[2] = {p.mean.x / p.mean.z, p.mean.y / p.mean.z};
    const float focal[2] = {args.camera.fx / p.mean.z, args.camera.fy / p.mean.z};
    const float4 w[3] = {row(args.camera, 0), row(args.camera, 1), row(args.camera, 2)};
#pragma unroll
    for (int r = 0; r < 2; r++) {
        float3 bar = axes_bar[r], turned = p.turned[r], row = p.rows[r];
        scales_bar.x += bar.x * turned.x;
        scales_bar.y += bar.y * turned.y;
        scales_bar.z += bar.z * turned.z;
        float3 turned_bar = v3(bar.x * scales.x, bar.y * scales.y, bar.z * scales.z);
        rotation_bar[0] = add_scaled(rotation_bar[0], focal[r] * row.x, turned_bar);
        rotation_bar[1] = add_scaled(rotation_bar[1], focal[r] * row.y, turned_bar);
        rotation_bar[2] = add_scaled(rotation_bar[2], focal[r] * row.z, turned_bar);
        float3 row_bar = v3(dot(p.rotation[0], turned_bar), dot(p.rotation[1], turned_bar),
                            dot(p.rotation[2], turned_bar));
        mean_bar[2] -= dot(row_bar, row) * focal[r] / p.mean.z;
        float tangent_bar = -focal[r] * dot(row_bar, xyz(w[2]));
        if (p.is_free[r]) {
            mean_bar[r] += tangent_bar / p.mean.z;
            mean_bar[2] -= tangent_bar * p.tangents[r] / p.mean.z;
        }
        mean_bar[r] += center[r] * focal[r];
        mean_bar[2] -= center[r] * focal[r] * ratios[r];
    }

    const float3* g = rotation_bar;
    float x = p.unit.x, y = p.unit.y, z = p.unit.z, t = p.unit.w;
    float sxy = g[0].y + g[1].x, sxz = g[0].z + g[2].x, syz = g[1].z + g[2].y;
    float dx = g[2].y - g[1].z, dy = g[0].z - g[2].x, dz = g[1].x - g[0].y;
    float4 unit_bar = make_float4(
        2.0f * (y * sxy + z * sxz + t * dx - 2.0f * x * (g[1].y + g[2].z)),
        2.0f * (x * sxy + z * syz + t * dy - 2.0f * y * (g[0].x + g[2].z)),
        2.0f * (x * sxz + y * syz + t * dz - 2.0f * z * (g[0].x + g[1].y)),
        2.0f * (x * dx + y * dy + z * dz));
    float along = unit_bar.x * x + unit_bar.y * y + unit_bar.z * z + unit_bar.w * t;
    args.rotations[i] = make_float4((unit_bar.x - x * along) / p.length, (unit_bar.y - y * along) / p.length,
                                    (unit_bar.z - z * along) / p.length, (unit_bar.w - t * along) / p.length);
    float3 mean = add_scaled(add_scaled(scale(xyz(w[0]), mean_bar[0]), mean_bar[1], xyz(w[1])),
                             mean_bar[2], xyz(w[2]));
    put3(args.means, i, mean);
    put3(args.scales, i, scales_bar);
    put3(args.colors, i, v3(m[6], m[7], m[8]));
    args.opacities[i] = opacity_bar * compensation;
    args.screen[i] = sqrtf(center[0] * center[0] + center[1] * center[1]);
}
