// Moving a free node for one substep with the ground and colliders in the way: the ground first,
// then the colliders in their order, the velocity after one being that before the next.
//
// A node at `x` is at q = transposed A (x - p) of a collider's body in the pose where the substep
// starts; d(q) is the signed distance, n = A n(q) / |A n(q)| the normal, w the velocity of the
// body's point q, u = v - w, r its clearance. It hits if d - r + dt u.n < CONTACT_MARGIN_M and
// u.n < 0, by the law of impacts for u, after tau = clamp((d - r) / -(u.n), 0, dt), zero within the
// margin. Inside it is also
// pushed out: the normal velocity that it leaves with is at least min(-d, MAX_PUSH_M) / PUSH_S. The
// substep ends at
// x + tau v + (dt - tau) v' with the velocities before and after the last that changed it. With a
// width of contact (SMOOTH) a layer takes the place of impact and push (`smooth.cuh`).

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
    float gap;            // the distance less that at which the node touches
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
    s.distance = s.gap = shape_distance(instance.world, c, s.place, reach, s.local);
    float3 turned = turn(pose, s.local);
    s.length = sqrtf(dot(turned, turned));
    s.normal = scale(turned, 1.0f / s.length);
    return s;
}

DEVICE Surface surface_of(const Ground& g, float3 x) {
    Surface s;
    s.distance = s.gap = height(g, x);
    s.normal = g.normal;
    s.velocity = s.place = s.local = zero3();
    s.length = 1.0f;
    return s;
}

// A meeting that changed a node's velocity.
struct Meeting {
    u32 with;            // a collider, or GROUND_ITSELF
    Surface surface;
    Law law;
    float3 before;       // velocity of the node
    Approach approach;   // velocity relative to the surface
    Contact contact;     // of smooth contact the change alone
    float tau;
    bool tau_varies;     // it depends on distance and approach
};

// Velocity of a node relative to a surface.
DEVICE Approach approach_of(const Surface& s, float3 start, float3 v) {
    return {sub(start, s.velocity), sub(v, s.velocity)};
}

// The meeting with a surface that is hit or pushes, if there is one.
DEVICE bool meeting_of(
    const Surface& s, Law law, float dt, float3 start, float3 v, bool hits, bool can_push, Meeting& m
) {
    m.surface = s;
    m.law = law;
    m.before = v;
    m.approach = approach_of(s, start, v);
    m.tau = 0.0f;
    m.tau_varies = false;
    if (hits) {
        float along = dot(s.normal, m.approach.now);
        m.tau = impact_time(s.gap, along, dt, m.tau_varies);
    }
    return contact_of(law, m.approach, s.normal, hits, can_push, s.distance, m.contact);
}

// The meeting with a collider, if there is one.
DEVICE bool
meeting_of(const Surface& s, Law law, float dt, float3 start, float3 v, Meeting& m) {
    float along = dot(s.normal, sub(v, s.velocity));
    bool hits = fmaf(dt, along, s.gap) < CONTACT_MARGIN_M && along < 0.0f;
    bool inside = s.distance < 0.0f;
    return (hits || inside) && meeting_of(s, law, dt, start, v, hits, inside, m);
}

// The meeting with the ground, if there is one.
DEVICE bool meeting_of(
    const Ground& g, Law law, float dt, float3 start, float3 x, float3 v, Meeting& m
) {
    m.with = GROUND_ITSELF;
    return hits(g, v, add_scaled(x, dt, v)) &&
           meeting_of(surface_of(g, x), law, dt, start, v, true, false, m);
}

#if SMOOTH
// The meeting with a surface in its layer, if the node is in it.
DEVICE bool layer_meeting_of(const Surface& s, Law law, const Layer& l, float3 v, Meeting& m) {
    if (!reaches(l, s.gap)) return false;
    m.surface = s;
    m.law = law;
    m.before = v;
    m.approach = approach_of(s, v, v);
    m.contact.hits = m.contact.pushes = false;
    m.contact.impact = m.contact.change = layer_change(l, law, s.gap, m.approach.now, s.normal);
    m.tau = 0.0f;
    m.tau_varies = false;
    return true;
}
#endif

// Calls `see` with all that the node with this index meets in a substep that it starts in the state (x, start), one
// after the other, `t` being the share of the frame that is over; `v`, its velocity after forces
// acted, becomes that behind them.
template <class See>
DEVICE void for_meetings(
    const InstanceArgs& instance, u32 frame, float t, u32 node, float3 start, float3 x, float3& v,
    See see
) {
    float dt = instance.step.dt;
    Meeting m;
#if SMOOTH
    Layer layer = layer_of(instance.world.smoothing, dt);
#endif
#if GROUND
    const Ground ground = ground_for(instance, instance.step.ground, node);
    Law ground_law = instance.parameters.ground_law;
#if SMOOTH
    m.with = GROUND_ITSELF;
    bool meets = layer_meeting_of(surface_of(ground, x), ground_law, layer, v, m);
#else
    bool meets = meeting_of(ground, ground_law, dt, start, x, v, m);
#endif
    if (meets) {
        see(m);
        v = add(v, m.contact.change);
    }
#endif
    for (u32 k = 0; k < instance.world.collider_count; k++) {
        const Collider& c = instance.world.colliders[k];
        BodyFrame body = body_of(instance, frame, c.body);
        float clearance = clearance_of(instance, 1 + k, node);
        float margin = clearance + (SMOOTH ? instance.world.smoothing : CONTACT_MARGIN_M);
        Surface s = surface_of(instance, c, body, pose_at(body, t), x, v, margin);
        s.gap = s.distance - clearance;
        Law law = {c.restitution, c.friction};
        m.with = k;
#if SMOOTH
        bool is_met = layer_meeting_of(s, law, layer, v, m);
#else
        bool is_met = meeting_of(s, law, dt, start, v, m);
#endif
        if (is_met) {
            see(m);
            v = add(v, m.contact.change);
        }
    }
}

// The same, to where the node is at the substep's end.
template <class See>
DEVICE void advance_among(
    const InstanceArgs& instance, u32 frame, float t, u32 node, float3 start, float3& x, float3& v,
    See see
) {
    float dt = instance.step.dt, tau = 0.0f;
    float3 before = v;
    for_meetings(instance, frame, t, node, start, x, v, [&](const Meeting& m) {
        see(m);
        tau = m.tau;
        before = m.before;
    });
    // Where nothing was met the velocities are the same.
    x = add_scaled(add_scaled(x, tau, before), dt - tau, v);
}

#if COLLIDERS
// The derivative of a shape's normal by the point, a symmetric matrix, times a vector: a capsule's
// is that across normal and axis by the distance from the axis, across the normal at its ends.
DEVICE float3 curvature(const Collider& c, float3 q, float3 by) {
    if (c.faces > 0) return zero3();
    float3 from = load_v3(c.from), axis = load_v3(c.axis);
    float s = nearest_share(from, axis, q);
    float3 r = add_scaled(sub(q, from), -s, axis);
    float square = dot(r, r), length = sqrtf(square);
    if (!(length > MIN_RADIUS_M)) return zero3();
    float3 across = add_scaled(by, -(dot(r, by) / square), r);
    if (s > 0.0f && s < 1.0f)
        across = add_scaled(across, -(dot(axis, by) / dot(axis, axis)), axis);
    return scale(across, 1.0f / length);
}
#endif

// Sums of d loss / d poses at both ends of a frame, of one body and node: rows of the first, then
// of the second.
struct BodySums {
    float* to;  // null if not requested
    u64 stride;
};

DEVICE BodySums body_sums_of(const InstanceArgs& instance, u32 body, u32 node) {
    u64 n = instance.topology.node_count;
    BodySums s = {0, n};
    if (body != NO_BODY && instance.world.body_sums)
        s.to = instance.world.body_sums + (u64)body * 24 * n + node;
    return s;
}

// Adds `from` and `to` times [o, 1] transposed to those of the poses at the two ends.
DEVICE void add_outer(const BodySums& s, float3 from, float3 to, float3 o, float one) {
    if (!s.to) return;
    const float bars[6] = {from.x, from.y, from.z, to.x, to.y, to.z};
    const float by[4] = {o.x, o.y, o.z, one};
    for (u32 i = 0; i < 6; i++)
        for (u32 k = 0; k < 4; k++) s.to[(4 * i + k) * s.stride] += bars[i] * by[k];
}

// d loss / d a surface.
struct SurfaceAdjoint {
    float distance;
    float3 normal, velocity;
};

// Adjoint of `surface_of`: gives d loss / d x; those of the body's poses go to `sums`.
DEVICE float3 surface_adjoint(
    const Collider& c, const BodyFrame& body, float t, const Surface& s, float3 x,
    const SurfaceAdjoint& bar, const BodySums& sums
) {
#if COLLIDERS
    Pose pose = pose_at(body, t);
    float3 across = add_scaled(bar.normal, -dot(s.normal, bar.normal), s.normal);
    float3 turned_bar = scale(across, 1.0f / s.length);
    float3 q_bar = curvature(c, s.place, turn_back(pose, turned_bar));
    q_bar = add_scaled(q_bar, bar.distance, s.local);
    float3 v_bar = scale(bar.velocity, body.rate);
    q_bar = add(q_bar, turn_back(body.to, v_bar));
    q_bar = sub(q_bar, turn_back(body.from, v_bar));
    float3 x_bar = turn(pose, q_bar);
    // A direction is turned, not moved; q = transposed A (x - p).
    add_outer(sums, scale(turned_bar, 1.0f - t), scale(turned_bar, t), s.local, 0.0f);
    float3 arm = sub(x, origin(pose));
    add_outer(sums, scale(arm, 1.0f - t), scale(arm, t), q_bar, 0.0f);
    add_outer(sums, scale(x_bar, t - 1.0f), scale(x_bar, -t), zero3(), 1.0f);
    add_outer(sums, scale(v_bar, -1.0f), v_bar, s.place, 1.0f);
    return x_bar;
#else
    return zero3();
#endif
}

// d loss / d the mean force in a frame that a collider exerts, or GROUND_ITSELF.
DEVICE float3 force_bar_of(const InstanceArgs& instance, u32 with) {
    const WorldArgs& w = instance.world;
    if (!w.force_bars) return zero3();
    u32 ground = 6 * (instance.topology.control_count + w.grasp_count);
    return load_v3(w.force_bars + (with == GROUND_ITSELF ? ground : ground + 3 + 6 * with));
}

// Adjoint of `advance_among` from (x, start, v) of a node: turns d loss / d result in (x_bar, v_bar)
// into that of x and v, and gives that of `start`. Only where it `writes` are sums of poses added to.
DEVICE float3 advance_among_adjoint(
    const InstanceArgs& instance, u32 frame, float t, u32 node, bool writes, float3 start, float3 x,
    float3 v, float3& x_bar, float3& v_bar, Law& law_bar
) {
    float dt = instance.step.dt;
    float rate = instance.topology.masses[node] / instance.step.frame_s;
    Meeting m;
    u32 count = 0;
    float3 end = v, start_bar = zero3();
    for_meetings(instance, frame, t, node, start, x, end, [&](const Meeting& one) {
        m = one;
        count++;
    });
    if (count == 0) {
        v_bar = add_scaled(v_bar, dt, x_bar);
        return start_bar;
    }
    // x' = x + tau v + (dt - tau) v'
    float tau_bar = -dot(x_bar, m.contact.change);
    float3 before_bar = scale(x_bar, m.tau);
    v_bar = add_scaled(v_bar, dt - m.tau, x_bar);
    for (u32 j = count; j-- > 0;) {
        if (j + 1 < count) {
            // Several meetings are rare: they are found again.
            u32 at = 0;
            end = v;
            for_meetings(instance, frame, t, node, start, x, end, [&](const Meeting& one) {
                if (at++ == j) m = one;
            });
        }
        const Surface& s = m.surface;
        float3 n = s.normal, u = m.approach.now;
        float3 change_bar = add(v_bar, scale(force_bar_of(instance, m.with), rate));
#if SMOOTH
        Layer layer = layer_of(instance.world.smoothing, dt);
        ContactAdjoint g = layer_change_adjoint(layer, m.law, s.gap, u, n, change_bar);
        // A layer begins at the gap, a push at the surface itself.
        float gap_bar = g.distance;
        g.distance = 0.0f;
#else
        ContactAdjoint g =
            contact_adjoint_of(m.law, m.approach, n, s.distance, m.contact, change_bar);
        float gap_bar = 0.0f;
#endif
        if (m.with == GROUND_ITSELF) add_law(law_bar, g);
        start_bar = add(start_bar, g.start);
        float3 in_bar = add(add(before_bar, v_bar), g.v);
        SurfaceAdjoint bar = {g.distance, g.normal, scale(add(g.v, g.start), -1.0f)};
        if (m.tau_varies) {
            // tau = -gap / (u . n)
            float inverse = 1.0f / dot(n, u);
            gap_bar -= tau_bar * inverse;
            float along = -(tau_bar * m.tau * inverse);
            in_bar = add_scaled(in_bar, along, n);
            bar.velocity = add_scaled(bar.velocity, -along, n);
            bar.normal = add_scaled(bar.normal, along, u);
        }
        bar.distance += gap_bar;
        if (writes)
            add_clearance_bar(instance, m.with == GROUND_ITSELF ? 0 : 1 + m.with, node, -gap_bar);
        if (m.with == GROUND_ITSELF) {
            x_bar = add_scaled(x_bar, bar.distance, n);
        } else {
            const Collider& c = instance.world.colliders[m.with];
            BodySums sums = body_sums_of(instance, c.body, node);
            if (!writes) sums.to = 0;
            BodyFrame body = body_of(instance, frame, c.body);
            x_bar = add(x_bar, surface_adjoint(c, body, t, s, x, bar, sums));
        }
        v_bar = in_bar;
        before_bar = zero3();
        tau_bar = 0.0f;
    }
    return start_bar;
}
