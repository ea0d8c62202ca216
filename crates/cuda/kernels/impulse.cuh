// The velocity change of a frictional impact and of a push out of a surface, and its adjoint: the
// ground, colliders and contact between nodes are this one formula with different partners.
//
// For the relative velocity v just before contact, s the same at the start of the substep, the unit
// normal n, v_n = v . n < 0, v_t = v - v_n n:
// r = e clamp(-s . n, 0, -v_n), J = -v_n + r, change = J n - min(1, mu J / |v_t|) v_t.
// Restitution acts on the approach that the substep does not explain (`cpu/collision/impulse.rs`).

struct Law {
    float restitution, friction;
};

// Relative velocity at the start of the substep and just before contact.
struct Approach {
    float3 start, now;
};

// d loss / d (approach, normal, distance, restitution, friction).
struct ContactAdjoint {
    float3 start, v, normal;
    float distance, restitution, friction;
};

DEVICE ContactAdjoint no_contact_adjoint() {
    return {zero3(), zero3(), zero3(), 0.0f, 0.0f, 0.0f};
}

DEVICE void add_law(Law& law_bar, const ContactAdjoint& by) {
    law_bar.restitution += by.restitution;
    law_bar.friction += by.friction;
}

// Parts of an impact that value and adjoint share.
struct Impact {
    float v_n;
    float3 v_t;
    float unexplained;  // approach that the substep does not explain
    float impulse;      // J
    float speed;        // |v_t|
    bool slips;         // friction is too weak to stop the sliding
};

DEVICE Impact resolve(Law law, const Approach& u, float3 n) {
    Impact i;
    i.v_n = dot(u.now, n);
    i.v_t = add_scaled(u.now, -i.v_n, n);
    i.unexplained = fmaxf(fminf(-dot(u.start, n), -i.v_n), 0.0f);
    i.impulse = law.restitution * i.unexplained - i.v_n;
    i.speed = sqrtf(dot(i.v_t, i.v_t));
    i.slips = law.friction * i.impulse < i.speed;
    return i;
}

DEVICE float3 impact(Law law, const Approach& u, float3 n) {
    Impact i = resolve(law, u, n);
    float brake = i.slips ? -(law.friction * i.impulse) / i.speed : -1.0f;
    return add_scaled(scale(n, i.impulse), brake, i.v_t);
}

// Adjoint of `impact` for d loss / d change = b.
DEVICE ContactAdjoint impact_adjoint(Law law, const Approach& u, float3 n, float3 b) {
    Impact i = resolve(law, u, n);
    ContactAdjoint out = no_contact_adjoint();
    float impulse_bar;
    if (i.slips) {
        // change = J (n - mu t), t = v_t / |v_t|.
        float3 t = scale(i.v_t, 1.0f / i.speed);
        impulse_bar = dot(n, b) - law.friction * dot(t, b);
        float3 t_bar = scale(b, -(law.friction * i.impulse));
        float3 v_t_bar = scale(add_scaled(t_bar, -dot(t, t_bar), t), 1.0f / i.speed);
        float v_n_bar = -impulse_bar - dot(n, v_t_bar);
        out.normal = add_scaled(scale(b, i.impulse), -i.v_n, v_t_bar);
        out.normal = add_scaled(out.normal, v_n_bar, u.now);
        out.v = add_scaled(v_t_bar, v_n_bar, n);
        out.friction = -(i.impulse * dot(t, b));
    } else {
        // change = r n - v.
        impulse_bar = dot(n, b);
        out.v = scale(b, -1.0f);
        out.normal = scale(b, law.restitution * i.unexplained);
    }
    // r = e clamp(-s . n, 0, -v_n).
    float speed_bar = law.restitution * impulse_bar;
    if (i.unexplained > 0.0f) {
        if (i.unexplained < -i.v_n) {
            out.start = scale(n, -speed_bar);
            out.normal = add_scaled(out.normal, -speed_bar, u.start);
        } else {
            out.v = add_scaled(out.v, -speed_bar, n);
            out.normal = add_scaled(out.normal, -speed_bar, u.now);
        }
    }
    out.restitution = i.unexplained * impulse_bar;
    return out;
}

// Normal velocity with which a body at this signed distance leaves a surface at least, and its
// derivative by the distance: min(-d, MAX_PUSH_M) / PUSH_S.
DEVICE float push_of(float distance, float& slope) {
    const float rate = 1.0f / PUSH_S;
    bool shallow = -distance < MAX_PUSH_M;
    slope = shallow ? -rate : 0.0f;
    return shallow ? -distance * rate : MAX_PUSH_M * rate;
}

// What a surface does to a relative velocity within a substep: an impact if that hits, then a push
// out of it if that is inside and leaves too slowly.
struct Contact {
    bool hits, pushes;
    float3 impact, change;
};

// True if the contact changes a velocity. With `can_push` the surface pushes what is `distance` < 0
// inside.
DEVICE bool contact_of(
    Law law, const Approach& u, float3 n, bool hits, bool can_push, float distance, Contact& c
) {
    c.hits = hits;
    c.pushes = false;
    c.impact = c.change = hits ? impact(law, u, n) : zero3();
    if (can_push) {
        float slope;
        float lack = push_of(distance, slope) - dot(n, add(u.now, c.impact));
        c.pushes = lack > 0.0f;
        if (c.pushes) c.change = add_scaled(c.impact, lack, n);
    }
    return c.hits || c.pushes;
}

// Adjoint of `contact_of` for d loss / d change = b.
DEVICE ContactAdjoint
contact_adjoint_of(Law law, const Approach& u, float3 n, float distance, const Contact& c, float3 b) {
    float along = dot(n, b);
    float3 impact_bar = c.pushes ? add_scaled(b, -along, n) : b;
    ContactAdjoint out = c.hits ? impact_adjoint(law, u, n, impact_bar) : no_contact_adjoint();
    if (c.pushes) {
        // change = impact + (push - n . leaves) n, leaves = v + impact.
        float slope;
        float speed = push_of(distance, slope);
        float3 leaves = add(u.now, c.impact);
        out.v = add_scaled(out.v, -along, n);
        out.normal = add_scaled(out.normal, speed - dot(n, leaves), b);
        out.normal = add_scaled(out.normal, -along, leaves);
        out.distance = slope * along;
    }
    return out;
}
