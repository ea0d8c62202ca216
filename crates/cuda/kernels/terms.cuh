// Terms that are not about distances to targets: strains, regions, forces and clearances.

DEVICE float3 second_difference(const ObjectiveArgs& m, u32 frame, u32 node) {
    float3 two = position(m, frame - 2, node), one = position(m, frame - 1, node);
    return add(add_scaled(position(m, frame, node), -2.0f, one), two);
}

// A spring at the end of a frame.
struct Stretch {
    u32 from, to;
    float3 along;
    float length, rest;
};

// False for a spring that no strain is measured of.
DEVICE bool stretch(const ObjectiveArgs& m, u32 frame, u32 spring, Stretch& s) {
    s.from = m.springs[2 * (u64)spring];
    s.to = m.springs[2 * (u64)spring + 1];
    s.rest = m.params[2 * (u64)m.spring_count + spring];
    if (!(s.rest > 0.0f) || max(s.from, s.to) >= m.node_count) return false;
    s.along = sub(position(m, frame, s.to), position(m, frame, s.from));
    s.length = sqrtf(dot(s.along, s.along));
    return true;
}

// max(0, |strain| - limit), with the strain's sign.
DEVICE float excess(const Term& t, const Stretch& s) {
    float strain = s.length / s.rest - 1.0f;
    return copysignf(fmaxf(fabsf(strain) - t.beta, 0.0f), strain);
}

// d loss / d position of a node by a strain.
DEVICE float3 strain_seed(const ObjectiveArgs& m, const Term& t, u32 frame, u32 node) {
    float3 sum = zero3();
    const float w = 2.0f * t.weight / max(m.strained_count, 1u);
    for (u32 k = m.spring_starts[node]; k < m.spring_starts[node + 1]; k++) {
        Stretch s;
        if (!stretch(m, frame, m.node_springs[k], s)) continue;
        float slope = w * excess(t, s);
        // Ends in one point have no direction in which to part.
        if (slope == 0.0f || !(s.length > 0.0f)) continue;
        float pull = slope / (s.rest * s.length);
        sum = add_scaled(sum, node == s.to ? pull : -pull, s.along);
    }
    return sum;
}
// From the nearest point of a half space or a box to a node; zero within.
DEVICE float3 beyond(const Term& t, float3 x) {
    float3 low = load_v3(t.low), high = load_v3(t.high);
    if (t.kind == ABOVE) return scale(low, -fmaxf(t.beta - dot(low, x), 0.0f));
    return v3(
        x.x - fminf(fmaxf(x.x, low.x), high.x), x.y - fminf(fmaxf(x.y, low.y), high.y),
        x.z - fminf(fmaxf(x.z, low.z), high.z)
    );
}
// Floats of a frame's forces.
DEVICE u32 force_stride(const ObjectiveArgs& m) {
    return 6 * (m.control_count + m.world.grasp_count + m.world.collider_count) + 3;
}

// Where a force stands among those of a frame.
DEVICE u32 force_place(const ObjectiveArgs& m, const Term& t) {
    u32 grasps = 6 * m.control_count, ground = grasps + 6 * m.world.grasp_count;
    if (t.loss == BY_ONE_CONTROL) return 6 * t.part;
    if (t.loss == BY_GRASP) return grasps + 6 * t.part;
    return t.loss == BY_GROUND ? ground : ground + 3 + 6 * t.part;
}

// The mean force over the frame that ends with a term's; zero before the first.
DEVICE float3 force_of(const ObjectiveArgs& m, const Term& t) {
    float3 sum = zero3();
    if (t.frame == 0) return sum;
    const float* forces = m.world.forces + (u64)(t.frame - 1) * force_stride(m);
    if (t.loss != BY_CONTROLS) return load_v3(forces + force_place(m, t));
    for (u32 c = 0; c < m.control_count; c++) sum = add(sum, load_v3(forces + 6 * c));
    return sum;
}

// Pose of a collider at the end of a frame.
DEVICE Pose collider_pose(const ObjectiveArgs& m, const Collider& c, u32 frame) {
    if (c.body == NO_BODY) return identity();
    return load_pose(m.world.poses + ((u64)frame * m.world.body_count + c.body) * 3);
}

// Distance that a node lacks to a term's collider; `q` is where it is in the body's coordinates.
DEVICE float lack_of(const ObjectiveArgs& m, const Term& t, float3 q, float3& normal) {
    const Collider& c = m.world.colliders[t.part];
    return fmaxf(t.beta - shape_distance(m.world, c, q, 3.4e38f, normal), 0.0f);
}
