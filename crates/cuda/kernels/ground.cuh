// Motion of a node for one substep with ground contact, and its adjoint: the node moves
// with the old velocity until the time of impact and with the new one after it.

struct Ground {
    float3 normal;
    float offset;
};

DEVICE float height(const Ground& g, float3 x) { return dot(g.normal, x) - g.offset; }

DEVICE bool hits(const Ground& g, float3 v, float3 next) {
    return height(g, next) < CONTACT_MARGIN_M && dot(g.normal, v) < 0.0f;
}

// Time at which a node meets a surface at this distance that it approaches with `along` < 0, within
// the substep; `varies` says whether it depends on both. Zero within the margin.
DEVICE float impact_time(float distance, float along, float dt, bool& varies) {
    float tau = distance / -along;
    varies = distance > CONTACT_MARGIN_M && tau < dt;
    if (distance <= CONTACT_MARGIN_M) return 0.0f;
    return varies ? tau : dt;
}

// Moves a node from the state (x, start) with its velocity `v` after forces acted; that becomes the
// new one.
DEVICE void advance(const Ground& g, Law law, float dt, float3 start, float3& x, float3& v) {
    float3 next = add_scaled(x, dt, v);
    if (!hits(g, v, next)) {
        x = next;
        return;
    }
    float3 after = add(v, impact(law, {start, v}, g.normal));
    bool varies;
    float tau = impact_time(height(g, x), dot(g.normal, v), dt, varies);
    x = add_scaled(add_scaled(x, tau, v), dt - tau, after);
    v = after;
}

// Adjoint of `advance` from (x, start, v): turns d loss / d result in (x_bar, v_bar) into that of
// its arguments; gives that of `start`, and of the height in `height_bar`.
DEVICE float3 advance_adjoint(
    const Ground& g, Law law, float dt, float3 start, float3 x, float3 v, float3& x_bar,
    float3& v_bar, Law& law_bar, float& height_bar
) {
    height_bar = 0.0f;
    if (!hits(g, v, add_scaled(x, dt, v))) {
        v_bar = add_scaled(v_bar, dt, x_bar);
        return zero3();
    }
    float3 n = g.normal;
    Approach u = {start, v};
    float3 change = impact(law, u, n);
    bool varies;
    float tau = impact_time(height(g, x), dot(n, v), dt, varies);
    float3 after_bar = add_scaled(v_bar, dt - tau, x_bar);
    ContactAdjoint a = impact_adjoint(law, u, n, after_bar);
    add_law(law_bar, a);
    float3 v_out = add(add(a.v, after_bar), scale(x_bar, tau));
    float3 x_out = x_bar;
    if (varies) {
        // x' = x + tau v + (dt - tau) v', so d x'/d tau = v - v' = -change; tau = -h / v_n.
        float tau_bar = -dot(x_bar, change);
        float inverse = 1.0f / dot(n, v);
        height_bar = -(tau_bar * inverse);
        x_out = add_scaled(x_out, -(tau_bar * inverse), n);
        v_out = add_scaled(v_out, -(tau_bar * tau * inverse), n);
    }
    x_bar = x_out;
    v_bar = v_out;
    return a.start;
}
