// Moving a free node for one substep with the ground and colliders in the way: the ground first,
// then the colliders in their order, the velocity after one being that before the next.
//
// A node at `x` is at q = transposed A (x - p) of a collider's body in the pose where the substep
// starts; d(q) is the signed distance, n = A n(q) / |A n(q)| the normal, w the velocity of the
// body's point q, u = v - w. It hits if d + dt u.n < 0 and u.n < -MIN_APPROACH_M_S, by the law of
// impacts for u, after tau = clamp(d / -(u.n), 0, dt). Inside it is also pushed out: the normal
// velocity that it leaves with is at least min(-d, MAX_PUSH_M) / PUSH_S. The substep ends at
// x + tau v + (dt - tau) v' with the velocities before and after the last that changed it.

#define MIN_RADIUS_M 1e-9f
#define GROUND_ITSELF 0xffffffffu

// Share of a segment's length at which it is nearest to a point.
DEVICE float nearest_share(float3 from, float3 axis, float3 q) {
    float square = dot(axis, axis);
    if (!(square > 0.0f)) return 0.0f;
    return fminf(fmaxf(dot(sub(q, from), axis) / square, 0.0f), 1.0f);
}

// Signed distance and outward unit normal of a point in the body's coordinates. Of a convex shape
// that of the face whose plane is farthest, the first of several; beyond `reach` of any face the
// search may end.
DEVICE float
shape_distance(const WorldArgs& w, const Collider& c, float3 q, float reach, float3& normal) {
    if (c.faces == 0) {
        float3 from = load_v3(c.from), axis = load_v3(c.axis);
        float3 r = add_scaled(sub(q, from), -nearest_share(from, axis, q), axis);
        float length = sqrtf(dot(r, r));
        normal = length > MIN_RADIUS_M ? scale(r, 1.0f / length) : v3(0.0f, 0.0f, 1.0f);
        return length - c.radius;
    }
    float best = -3.4e38f;
    normal = v3(0.0f, 0.0f, 1.0f);
    for (u32 f = 0; f < c.faces; f++) {
        float4 face = __ldg(w.faces + c.face + f);
        float d = dot(xyz(face), q) - face.w;
        if (d > best) {
            best = d;
            normal = xyz(face);
            if (d > reach) break;
        }
    }
    return best;
}

// A surface as a node sees it.
struct Surface {
    float distance;
    float3 normal;
    float3 velocity;      // of the surface
    float3 place, local;  // the node in the body's coordinates, the normal there
    float length;         // of that turned
};

// Of a collider, for a node with velocity `v`; `margin` is what the node may be away to matter,
// beside its way in a substep.
DEVICE Surface surface_of(
    const InstanceArgs& instance, const Collider& c, const BodyFrame& body, const Pose& pose,
    float3 x, float3 v, float margin
) {
    Surface s;
    s.place = into_body(pose, x);
    s.velocity = body_velocity(body, s.place);
    float3 u = sub(v, s.velocity);
    float reach = margin + 1.001f * instance.step.dt * sqrtf(dot(u, u));
    s.distance = shape_distance(instance.world, c, s.place, reach, s.local);
    float3 turned = turn(pose, s.local);
    s.length = sqrtf(dot(turned, turned));
    s.normal = scale(turned, 1.0f / s.length);
    return s;
}

DEVICE Surface surface_of(const Ground& g, float3 x) {
    Surface s;
    s.distance = height(g, x);
    s.normal = g.normal;
    s.velocity = s.place = s.local = zero3();
    s.length = 1.0f;
    return s;
}

// A meeting that changed a node's velocity.
struct Meeting {
    u32 with;                       // a collider, or GROUND_ITSELF
    Surface surface;
    Law law;
    float3 before, between, after;  // velocities: the impact's, then the push's
    bool hits, pushes;
    float tau;
};

// Velocity with which a node so deep inside leaves at least, and its derivative by the distance.
DEVICE float push_of(float distance, float& slope) {
    const float rate = 1.0f / PUSH_S;
    bool shallow = -distance < MAX_PUSH_M;
    slope = shallow ? -rate : 0.0f;
    return shallow ? -distance * rate : MAX_PUSH_M * rate;
}

// The meeting with a collider, if there is one.
DEVICE bool meeting_of(const Surface& s, Law law, float dt, float3 v, Meeting& m) {
    float3 u = sub(v, s.velocity);
    float along = dot(s.normal, u);
    m.hits = fmaf(dt, along, s.distance) < 0.0f && along < -MIN_APPROACH_M_S;
    m.pushes = false;
    if (!m.hits && !(s.distance < 0.0f)) return false;
    m.between = m.hits ? add(v, impact(law, u, s.normal)) : v;
    m.after = m.between;
    if (s.distance < 0.0f) {
        float slope;
        float lack = push_of(s.distance, slope) - dot(s.normal, sub(m.between, s.velocity));
        m.pushes = lack > 0.0f;
        if (m.pushes) m.after = add_scaled(m.after, lack, s.normal);
    }
    m.surface = s;
    m.law = law;
    m.before = v;
    m.tau = m.hits ? fminf(fmaxf(s.distance / -along, 0.0f), dt) : 0.0f;
    return m.hits || m.pushes;
}

// The meeting with the ground, if there is one.
DEVICE bool meeting_of(const Ground& g, Law law, float dt, float3 x, float3 v, Meeting& m) {
    if (!hits(g, v, add_scaled(x, dt, v))) return false;
    m.with = GROUND_ITSELF;
    m.surface = surface_of(g, x);
    m.law = law;
    m.before = v;
    m.between = m.after = add(v, impact(law, v, g.normal));
    m.hits = true;
    m.pushes = false;
    m.tau = impact_time(g, dt, x, v);
    return true;
}

// Calls `see` with all that a node meets in a substep that it starts at `x` with velocity `v`, one
// after the other, `t` being the share of the frame that is over; `v` becomes its velocity behind
// them.
template <class See>
DEVICE void
for_meetings(const InstanceArgs& instance, u32 frame, float t, float3 x, float3& v, See see) {
    float dt = instance.step.dt;
    Meeting m;
#if GROUND
    if (meeting_of(instance.step.ground, instance.parameters.ground_law, dt, x, v, m)) {
        see(m);
        v = m.after;
    }
#endif
    for (u32 k = 0; k < instance.world.collider_count; k++) {
        const Collider& c = instance.world.colliders[k];
        BodyFrame body = body_of(instance, frame, c.body);
        Surface s = surface_of(instance, c, body, pose_at(body, t), x, v, 0.0f);
        Law law = {c.restitution, c.friction};
        m.with = k;
        if (meeting_of(s, law, dt, v, m)) {
            see(m);
            v = m.after;
        }
    }
}

// The same, to where the node is at the substep's end.
template <class See>
DEVICE void
advance_among(const InstanceArgs& instance, u32 frame, float t, float3& x, float3& v, See see) {
    float dt = instance.step.dt, tau = 0.0f;
    float3 before = v;
    for_meetings(instance, frame, t, x, v, [&](const Meeting& m) {
        see(m);
        tau = m.tau;
        before = m.before;
    });
    // Where nothing was met the velocities are the same.
    x = add_scaled(add_scaled(x, tau, before), dt - tau, v);
}
