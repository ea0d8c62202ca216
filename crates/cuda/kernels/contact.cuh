// Contact between nodes by impulses, and its adjoint. A node takes the mean of its pairs' impulses,
// all computed from the velocities before contact, so the order of pairs does not matter to the
// physics; it is fixed all the same.

struct ContactPair {
    float3 normal;  // from the first to the second
    float distance;
    float3 v;       // of the second relative to the first
    float mass;     // 1 / (1/m1 + 1/m2)
};

// Test of two nodes for contact; `a` and `b` carry the inverse masses in w.
DEVICE bool contact_pair(float limit, float4 a, float4 b, float3 v_a, float3 v_b, ContactPair& t) {
    float3 r = sub(xyz(b), xyz(a));
    t.v = sub(v_b, v_a);
    float square = dot(r, r);
    float inverse = a.w + b.w;
    if (!(square < limit * limit && dot(r, t.v) < -MIN_APPROACH_M2_S &&
          square > MIN_LENGTH_SQUARED_M2 && inverse > 0.0f))
        return false;
    t.distance = sqrtf(square);
    t.normal = scale(r, 1.0f / t.distance);
    t.mass = 1.0f / inverse;
    return true;
}

// Positions, velocities before contact and inverse masses of all nodes while a substep runs.
struct CurrentNodes {
    const float4 *x, *v;  // x with the inverse mass, v
    DEVICE_MEMBER void load(u32 node, float4& x_out, float3& v_out) const {
        x_out = __ldcg(x + node);
        v_out = xyz(__ldcg(v + node));
    }
};

// The same from a substep on tape.
struct TapedNodes {
    const float4* x;
    const float *b, *inverse_mass;
    const u32* slots;
    const InstanceArgs* instance;
    DEVICE_MEMBER void load(u32 node, float4& x_out, float3& v_out) const {
        u32 slot = slots[node];
        float inverse = inverse_mass[node];
        v_out = load_v3(b + 3 * (u64)slot);
#if GRASPS || FORCES
        u32 frame = instance->state.first_frame;
        inverse = inverse_mass_in(*instance, frame, node);
        // On tape is what held nodes would do if they were not.
        if (FORCES && inverse == 0.0f) v_out = held_velocity(*instance, frame, node);
#endif
        x_out = with_w(xyz(x[slot]), inverse);
    }
};

// Velocity of a node after contact; `contact_count` counts its pairs. The LANES lanes of a node
// share the work; lanes without a node come along, not active, for the sums' sake.
template <class Nodes>
DEVICE float3 collide(
    const InstanceArgs& instance, const Nodes& nodes, u32 node, bool active, u32 lane,
    float& contact_count
) {
    float4 own_x;
    float3 own_v;
    nodes.load(node, own_x, own_v);
    const u32* partners = instance.contact.partners + (u64)node * instance.contact.max_partners;
    u32 count = active ? instance.contact.partner_counts[node] : 0;
    float3 sum = zero3();
    float n = 0.0f;
    for (u32 k = lane; k < count; k += LANES) {
        u32 other = partners[k];
        float4 other_x;
        float3 other_v;
        nodes.load(other, other_x, other_v);
        ContactPair t;
        if (contact_pair(instance.contact.collision_distance, own_x, other_x, own_v, other_v, t)) {
            sum = add_scaled(sum, t.mass, impact(instance.parameters.object_law, t.v, t.normal));
            n += 1.0f;
        }
    }
    sum = sum_lanes(sum);
    contact_count = sum_lanes(n);
    return contact_count > 0.0f ? add_scaled(own_v, -(own_x.w / contact_count), sum) : own_v;
}

// Adjoint of `collide`, gathered: adds what a node's position and velocity before contact get from
// its own impulses and from its partners'. `share` holds, per node, d loss / d velocity after
// contact times -(1/m) / contact_count (zero where nothing contact_count); `law_bar` gets this
// node's impulses only.
template <class Nodes>
DEVICE void collide_adjoint(
    const InstanceArgs& instance, const Nodes& nodes, u32 node, bool active, u32 lane,
    const float4* share, float3& x_bar, float3& v_bar, Law& law_bar
) {
    float4 own_x;
    float3 own_v;
    nodes.load(node, own_x, own_v);
    float3 own_share = xyz(__ldcg(share + node));
    const u32* partners = instance.contact.partners + (u64)node * instance.contact.max_partners;
    u32 count = active ? instance.contact.partner_counts[node] : 0;
    float3 x_sum = zero3(), v_sum = zero3();
    for (u32 k = lane; k < count; k += LANES) {
        u32 other = partners[k];
        float4 other_x;
        float3 other_v;
        nodes.load(other, other_x, other_v);
        ContactPair t;
        if (!contact_pair(instance.contact.collision_distance, own_x, other_x, own_v, other_v, t))
            continue;
        ImpactAdjoint mine =
            impact_adjoint(instance.parameters.object_law, t.v, t.normal, scale(own_share, t.mass));
        law_bar.restitution += mine.restitution;
        law_bar.friction += mine.friction;
        float3 theirs_in = scale(xyz(__ldcg(share + other)), t.mass);
        ImpactAdjoint theirs = impact_adjoint(
            instance.parameters.object_law, scale(t.v, -1.0f), scale(t.normal, -1.0f), theirs_in
        );
        // Seen from the other end, this node is the second of the pair.
        float3 normal_bar = sub(theirs.normal, mine.normal);
        float3 flat = add_scaled(normal_bar, -dot(normal_bar, t.normal), t.normal);
        x_sum = add_scaled(x_sum, 1.0f / t.distance, flat);
        v_sum = add(v_sum, sub(theirs.v, mine.v));
    }
    x_bar = add(x_bar, sum_lanes(x_sum));
    v_bar = add(v_bar, sum_lanes(v_sum));
}
