// The velocity change of a frictional impact, and its adjoint; ground contact and contact between
// nodes are this one formula with different partners.
//
// For the relative velocity v, unit normal n, v_n = v . n < 0, v_t = v - v_n n:
// change = -(1 + e) v_n n + (a - 1) v_t, a = max(0, 1 - mu (1 + e) |v_n| / |v_t|).

struct Law {
    float restitution, friction;
};

DEVICE float3 impact(Law law, float3 v, float3 n) {
    float v_n = dot(v, n);
    float3 v_t = add_scaled(v, -v_n, n);
    float speed = sqrtf(dot(v_t, v_t));
    float bounce = -(1.0f + law.restitution) * v_n;
    bool slips = law.friction * (1.0f + law.restitution) * fabsf(v_n) < speed;
    float brake = slips ? -(law.friction * bounce) / speed : -1.0f;
    return add_scaled(scale(n, bounce), brake, v_t);
}

struct ImpactAdjoint {
    float3 v, normal;
    float restitution, friction;
};

// Adjoint of `impact` for d loss / d change = b.
DEVICE ImpactAdjoint impact_adjoint(Law law, float3 v, float3 n, float3 b) {
    float v_n = dot(v, n);
    float3 v_t = add_scaled(v, -v_n, n);
    float speed = sqrtf(dot(v_t, v_t));
    float e1 = 1.0f + law.restitution;
    bool slips = law.friction * e1 * fabsf(v_n) < speed;
    float along = dot(n, b);
    ImpactAdjoint out;
    if (!slips) {
        // change = -e v_n n - v.
        float e = law.restitution;
        out.v = sub(scale(n, -(e * along)), b);
        out.normal = add_scaled(scale(v, -(e * along)), -(e * v_n), b);
        out.restitution = -(v_n * along);
        out.friction = 0.0f;
        return out;
    }
    // change = (1 + e) v_n (mu t - n), t = v_t / |v_t|.
    float3 t = scale(v_t, 1.0f / speed);
    float work = law.friction * dot(t, b) - along;
    float3 t_bar = scale(b, law.friction * e1 * v_n);
    float3 v_t_bar = scale(add_scaled(t_bar, -dot(t, t_bar), t), 1.0f / speed);
    float v_n_bar = e1 * work - dot(n, v_t_bar);
    float3 normal = add_scaled(scale(b, -(e1 * v_n)), -v_n, v_t_bar);
    out.v = add_scaled(v_t_bar, v_n_bar, n);
    out.normal = add_scaled(normal, v_n_bar, v);
    out.restitution = v_n * work;
    out.friction = e1 * v_n * dot(t, b);
    return out;
}
