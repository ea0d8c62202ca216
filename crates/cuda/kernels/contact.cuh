// Contact between nodes by impulses, and its adjoint. A node takes the mean of its pairs' impulses,
// all computed from the velocities before contact, so the order of pairs does not matter to the
// physics; it is fixed all the same.

// A touching pair as seen from its first node, `a`.
struct ContactPair {
    float3 normal;      // from the first to the second
    float distance;
    float inside;       // by which they are farther apart than the collision distance; below zero
    Approach approach;  // of the second relative to the first
    Contact contact;
    float mass;         // 1 / (1/m1 + 1/m2)
};

// Positions, inverse masses and velocities, at a substep's start and before contact, of all nodes
// while it runs.
struct CurrentNodes {
    const float4 *x, *v, *start;  // x with the inverse mass
    DEVICE_MEMBER float4 position(u32 node) const { return __ldcg(x + node); }
    DEVICE_MEMBER Approach velocity(u32 node) const {
        return {xyz(__ldcg(start + node)), xyz(__ldcg(v + node))};
    }
};

// The same from a substep on tape.
struct TapedNodes {
    const float4* x;
    const float2* v;
    const float *b, *inverse_mass;
    const u32* slots;
    const InstanceArgs* instance;
    DEVICE_MEMBER float inverse_mass_at(u32 node) const {
#if GRASPS || FORCES
        return inverse_mass_in(*instance, instance->state.first_frame, node);
#else
        return inverse_mass[node];
#endif
    }
    DEVICE_MEMBER float4 position(u32 node) const {
        return with_w(xyz(x[slots[node]]), inverse_mass_at(node));
    }
    DEVICE_MEMBER Approach velocity(u32 node) const {
        u32 slot = slots[node];
        float2 rest = v[slot];
        Approach u = {v3(x[slot].w, rest.x, rest.y), load_v3(b + 3 * (u64)slot)};
#if FORCES
        // On tape is what held nodes would do if they were not.
        if (inverse_mass_at(node) == 0.0f)
            u.now = held_velocity(*instance, instance->state.first_frame, node);
#endif
        return u;
    }
};

// Test of two nodes for contact, the first having the given position and velocity.
template <class Nodes>
DEVICE bool contact_pair(
    const InstanceArgs& instance, const Nodes& nodes, u32 a, u32 b, float4 own_x,
    const Approach& own, ContactPair& t
) {
    const float limit = instance.contact.collision_distance;
    float4 other_x = nodes.position(b);
    float3 r = sub(xyz(other_x), xyz(own_x));
    float square = dot(r, r);
    float inverse = own_x.w + other_x.w;
    if (!(square < limit * limit && square > MIN_LENGTH_SQUARED_M2 && inverse > 0.0f)) return false;
    Approach other = nodes.velocity(b);
    t.approach = {sub(other.start, own.start), sub(other.now, own.now)};
    bool hits = dot(r, t.approach.now) < 0.0f;
    float3 apart = sub(xyz(__ldg(instance.contact.rest + b)), xyz(__ldg(instance.contact.rest + a)));
    bool pushes = dot(apart, apart) >= limit * limit;
    if (!(hits || pushes)) return false;
    t.distance = sqrtf(square);
    t.normal = scale(r, 1.0f / t.distance);
    t.inside = t.distance - limit;
    t.mass = 1.0f / inverse;
    Law law = instance.parameters.object_law;
    return contact_of(law, t.approach, t.normal, hits, pushes, t.inside, t.contact);
}

// Velocity of a node after contact; `contact_count` counts its pairs. The LANES lanes of a node
// share the work; lanes without a node come along, not active, for the sums' sake.
template <class Nodes>
DEVICE float3 collide(
    const InstanceArgs& instance, const Nodes& nodes, u32 node, bool active, u32 lane,
    float& contact_count
) {
    const float4 own_x = nodes.position(node);
    const Approach own = nodes.velocity(node);
    const u32* partners = instance.contact.partners + (u64)node * instance.contact.max_partners;
    u32 count = active ? instance.contact.partner_counts[node] : 0;
    float3 sum = zero3();
    float n = 0.0f;
    for (u32 k = lane; k < count; k += LANES) {
        ContactPair t;
        if (!contact_pair(instance, nodes, node, partners[k], own_x, own, t)) continue;
        sum = add_scaled(sum, t.mass, t.contact.change);
        n += 1.0f;
    }
    sum = sum_lanes(sum);
    contact_count = sum_lanes(n);
    return contact_count > 0.0f ? add_scaled(own.now, -(own_x.w / contact_count), sum) : own.now;
}

// Adjoint of `collide`, gathered: adds what a node's position and velocities, before contact and at
// the substep's start, get from its own impulses and from its partners'. `share` holds, per node,
// d loss / d velocity after contact times -(1/m) / contact_count (zero where nothing
// contact_count); `law_bar` gets this node's impulses only.
template <class Nodes>
DEVICE void collide_adjoint(
    const InstanceArgs& instance, const Nodes& nodes, u32 node, bool active, u32 lane,
    const float4* share, float3& x_bar, float3& v_bar, float3& start_bar, Law& law_bar
) {
    const float4 own_x = nodes.position(node);
    const Approach own = nodes.velocity(node);
    const Law law = instance.parameters.object_law;
    float3 own_share = xyz(__ldcg(share + node));
    const u32* partners = instance.contact.partners + (u64)node * instance.contact.max_partners;
    u32 count = active ? instance.contact.partner_counts[node] : 0;
    float3 x_sum = zero3(), v_sum = zero3(), start_sum = zero3();
    for (u32 k = lane; k < count; k += LANES) {
        u32 other = partners[k];
        ContactPair t;
        if (!contact_pair(instance, nodes, node, other, own_x, own, t)) continue;
        ContactAdjoint mine = contact_adjoint_of(
            law, t.approach, t.normal, t.inside, t.contact, scale(own_share, t.mass)
        );
        add_law(law_bar, mine);
        // Seen from the other end, this node is the second of the pair and all vectors are reversed.
        Approach back = {scale(t.approach.start, -1.0f), scale(t.approach.now, -1.0f)};
        float3 normal = scale(t.normal, -1.0f);
        Contact contact = t.contact;
        contact.impact = scale(contact.impact, -1.0f);
        contact.change = scale(contact.change, -1.0f);
        ContactAdjoint theirs = contact_adjoint_of(
            law, back, normal, t.inside, contact, scale(xyz(__ldcg(share + other)), t.mass)
        );
        float3 normal_bar = sub(theirs.normal, mine.normal);
        float3 flat = add_scaled(normal_bar, -dot(normal_bar, t.normal), t.normal);
        x_sum = add_scaled(x_sum, 1.0f / t.distance, flat);
        x_sum = add_scaled(x_sum, -(mine.distance + theirs.distance), t.normal);
        v_sum = add(v_sum, sub(theirs.v, mine.v));
        start_sum = add(start_sum, sub(theirs.start, mine.start));
    }
    x_bar = add(x_bar, sum_lanes(x_sum));
    v_bar = add(v_bar, sum_lanes(v_sum));
    start_bar = add(start_bar, sum_lanes(start_sum));
}
