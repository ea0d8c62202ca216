// The skin of a model: points of its surface that nodes carry, p = sum of w_i x_i + o, with an offset
// o that is constant in a frame of three nodes. Formulas and their derivatives as in the core crate's
// `twin/skin.rs`, in single precision.

// Marks a point whose offset is along the axes of the world.
#define NO_FRAME 0xffffffffu
// Shorter edges [m] give a frame no direction.
#define LEAST_EDGE_M 1e-12f

// Positions of a frame's nodes.
struct Positions {
    const float* x;  // [3][count]
    u32 count;
};

DEVICE float3 node_at(const Positions& p, u32 node) {
    return v3(p.x[node], p.x[p.count + node], p.x[2 * (u64)p.count + node]);
}

// A frame of nodes a, b, c: e1 along b - a, n along (b - a) x (c - a), e2 = n x e1.
struct Axes {
    float3 e1, e2, n;
    float3 u, v;                       // b - a, c - a
    float inverse_edge, inverse_area;  // of the lengths of u and u x v
};

// False if the nodes span no triangle.
DEVICE bool axes_of(const Positions& p, const u32* frame, Axes& axes) {
    const float3 a = node_at(p, frame[0]);
    axes.u = sub(node_at(p, frame[1]), a);
    axes.v = sub(node_at(p, frame[2]), a);
    const float3 normal = cross(axes.u, axes.v);
    const float edge = sqrtf(dot(axes.u, axes.u)), area = sqrtf(dot(normal, normal));
    const float sides = edge * sqrtf(dot(axes.v, axes.v));
    if (!(edge > LEAST_EDGE_M && area > LEAST_FRAME_SINE * sides)) return false;
    axes.inverse_edge = 1.0f / edge;
    axes.inverse_area = 1.0f / area;
    axes.e1 = scale(axes.u, axes.inverse_edge);
    axes.n = scale(normal, axes.inverse_area);
    axes.e2 = cross(axes.n, axes.e1);
    return true;
}

// Position of a point.
DEVICE float3 skin_at(const SkinArgs& skin, const Positions& p, u32 point) {
    const u32 end = skin.starts[point + 1];
    float3 sum = zero3();
#pragma unroll 4
    for (u32 k = skin.starts[point]; k < end; k++)
        sum = add_scaled(sum, skin.weights[k], node_at(p, skin.nodes[k]));
    const float3 o = load_v3(skin.offsets + 3 * (u64)point);
    if (o.x == 0.0f && o.y == 0.0f && o.z == 0.0f) return sum;
    const u32* frame = skin.frames + 3 * (u64)point;
    if (frame[0] == NO_FRAME) return add(sum, o);
    Axes axes;
    if (!axes_of(p, frame, axes)) return sum;
    return add_scaled(add_scaled(add_scaled(sum, o.x, axes.e1), o.y, axes.e2), o.z, axes.n);
}

// d loss / d the vector that a unit vector was made of, from 1 / its length.
DEVICE float3 before_unit(float3 unit, float3 bar, float inverse) {
    return scale(add_scaled(bar, -dot(unit, bar), unit), inverse);
}

// d loss / d position of the first, second or third node of a point's frame by its offset, from that
// of the point.
DEVICE float3 corner_bar(
    const SkinArgs& skin, const Positions& p, u32 point, u32 corner, float3 bar
) {
    Axes axes;
    if (!axes_of(p, skin.frames + 3 * (u64)point, axes)) return zero3();
    const float3 o = load_v3(skin.offsets + 3 * (u64)point);
    const float3 e2_bar = scale(bar, o.y);
    const float3 n_bar = add(scale(bar, o.z), cross(axes.e1, e2_bar));
    const float3 normal_bar = before_unit(axes.n, n_bar, axes.inverse_area);
    const float3 v_bar = cross(normal_bar, axes.u);
    if (corner == 2) return v_bar;
    const float3 e1_bar = add(scale(bar, o.x), cross(e2_bar, axes.n));
    const float3 u_bar =
        add(before_unit(axes.e1, e1_bar, axes.inverse_edge), cross(axes.v, normal_bar));
    return corner == 1 ? u_bar : scale(add(u_bar, v_bar), -1.0f);
}

// d loss / d position of a node by d loss / d those of points, [3][M].
DEVICE float3 carried_bar(const SkinArgs& skin, const Positions& p, const float* bars, u32 node) {
    const Positions points = {bars, skin.point_count};
    float3 sum = zero3();
    u32 end = skin.node_starts[node + 1];
#pragma unroll 4
    for (u32 k = skin.node_starts[node]; k < end; k++)
        sum = add_scaled(sum, skin.carried_weights[k], node_at(points, skin.carried[k]));
    end = skin.corner_starts[node + 1];
    for (u32 k = skin.corner_starts[node]; k < end; k++) {
        const u32 point = skin.corners[2 * (u64)k], corner = skin.corners[2 * (u64)k + 1];
        sum = add(sum, corner_bar(skin, p, point, corner, node_at(points, point)));
    }
    return sum;
}
