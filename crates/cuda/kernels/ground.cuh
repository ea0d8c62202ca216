// Motion of a node for one substep with ground contact, and its adjoint: the node moves
// with the old velocity until the time of impact and with the reflected one after it.

struct Ground {
    float3 normal;
    float offset;
};

DEVICE float height(const Ground& g, float3 x) { return dot(g.normal, x) - g.offset; }

DEVICE bool hits(const Ground& g, float3 v, float3 next) {
    return height(g, next) < 0.0f && dot(g.normal, v) < -MIN_APPROACH_M_S;
}

DEVICE float impact_time(const Ground& g, float dt, float3 x, float3 v) {
    float tau = height(g, x) / -dot(g.normal, v);
    return fminf(fmaxf(tau, 0.0f), dt);
}

DEVICE void advance(const Ground& g, Law law, float dt, float3& x, float3& v) {
    float3 next = add_scaled(x, dt, v);
    if (!hits(g, v, next)) {
        x = next;
        return;
    }
    float3 after = add(v, impact(law, v, g.normal));
    float tau = impact_time(g, dt, x, v);
    x = add_scaled(add_scaled(x, tau, v), dt - tau, after);
    v = after;
}

// Adjoint of `advance` from (x, v): turns d loss / d result in (x_bar, v_bar) into that of its
// arguments.
DEVICE void advance_adjoint(
    const Ground& g, Law law, float dt, float3 x, float3 v, float3& x_bar, float3& v_bar,
    Law& law_bar
) {
    if (!hits(g, v, add_scaled(x, dt, v))) {
        v_bar = add_scaled(v_bar, dt, x_bar);
        return;
    }
    float3 n = g.normal;
    float3 change = impact(law, v, n);
    float tau = impact_time(g, dt, x, v);
    float3 after_bar = add_scaled(v_bar, dt - tau, x_bar);
    ImpactAdjoint a = impact_adjoint(law, v, n, after_bar);
    law_bar.restitution += a.restitution;
    law_bar.friction += a.friction;
    float3 v_out = add(add(a.v, after_bar), scale(x_bar, tau));
    float3 x_out = x_bar;
    if (height(g, x) > 0.0f) {
        // x' = x + tau v + (dt - tau) v', so d x'/d tau = v - v' = -change; tau = -h / v_n.
        float tau_bar = -dot(x_bar, change);
        float inverse = 1.0f / dot(n, v);
        x_out = add_scaled(x_out, -(tau_bar * inverse), n);
        v_out = add_scaled(v_out, -(tau_bar * tau * inverse), n);
    }
    x_bar = x_out;
    v_bar = v_out;
}
