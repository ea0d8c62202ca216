// Contact with ground and colliders as a smooth force, for gradients that say where finite steps
// lead.
//
// A node at the distance h of a surface, with velocity u relative to it, normal n and u_n = u.n, is
// in a layer of width s, in which it counts as `delta` deep:
//
//   t = clamp(1/2 - h/s, 0, 1)     share = t^2 (3 - 2t)     delta = s (t^3 - t^4/2), below: -h
//   k = SMOOTH_STIFFNESS_M_S2 / s  c = 2 (1 - e) sqrt(k)
//   b = k delta                    gamma = (c + dt k) share      P = 1 + dt gamma
//   y = b - gamma u_n              j = dt/2 (y + sqrt(y^2 + P b^2)) / P
//   A = mu j                       S = sqrt(|u_t|^2 + A^2 + (SMOOTH_RATE_1_S s)^2)
//   v' = v + j n - (A / S) u_t

// The layer of a rollout.
struct Layer {
    float width;
    float stiffness;  // k [1/s^2]
    float slow2;      // tangential speed squared below which friction is viscous [m^2/s^2]
    float dt;
};

DEVICE Layer layer_of(float width, float dt) {
    float slow = width * SMOOTH_RATE_1_S;
    Layer l = {width, SMOOTH_STIFFNESS_M_S2 / width, slow * slow, dt};
    return l;
}

// True if a node at this distance feels the surface.
DEVICE bool reaches(const Layer& l, float distance) { return distance + distance < l.width; }

// What the layer makes of a distance and a normal velocity.
struct LayerNormal {
    float share, share_slope;  // and d share / d h
    float damping, gamma, p, b, y, root, j;
};

DEVICE LayerNormal layer_normal(const Layer& l, Law law, float h, float u_n) {
    LayerNormal a;
    float t = fminf(fmaxf(0.5f - h / l.width, 0.0f), 1.0f);
    a.share = t * t * (3.0f - 2.0f * t);
    float depth = t >= 1.0f ? -h : l.width * t * t * t * (1.0f - 0.5f * t);
    a.share_slope = -(6.0f * t * (1.0f - t)) / l.width;
    a.damping = 2.0f * (1.0f - law.restitution) * sqrtf(l.stiffness);
    a.gamma = (a.damping + l.dt * l.stiffness) * a.share;
    a.p = 1.0f + l.dt * a.gamma;
    a.b = l.stiffness * depth;
    a.y = a.b - a.gamma * u_n;
    a.root = sqrtf(fmaf(a.y, a.y, a.p * a.b * a.b));
    // Where y is negative the sum cancels: the same by the other root.
    float sum = a.y >= 0.0f || a.root == 0.0f ? a.y + a.root : a.p * a.b * a.b / (a.root - a.y);
    a.j = 0.5f * l.dt * sum / a.p;
    return a;
}

// Change of velocity.
DEVICE float3 layer_change(const Layer& l, Law law, float h, float3 u, float3 n) {
    float u_n = dot(u, n);
    float3 u_t = add_scaled(u, -u_n, n);
    float j = layer_normal(l, law, h, u_n).j;
    float most = law.friction * j;
    float speed = sqrtf(fmaf(most, most, dot(u_t, u_t)) + l.slow2);
    return add_scaled(scale(n, j), -(most / speed), u_t);
}

// Adjoint of `layer_change` for d loss / d change = `bar`.
DEVICE ContactAdjoint layer_change_adjoint(
    const Layer& l, Law law, float h, float3 u, float3 n, float3 bar
) {
    float u_n = dot(u, n);
    float3 u_t = add_scaled(u, -u_n, n);
    LayerNormal a = layer_normal(l, law, h, u_n);
    float most = law.friction * a.j;
    float speed = sqrtf(fmaf(most, most, dot(u_t, u_t)) + l.slow2);
    float inverse = 1.0f / speed, brake = most * inverse;
    float brake_bar = -dot(u_t, bar);
    float most_bar = brake_bar * inverse * (1.0f - brake * brake);
    float3 u_t_bar = add_scaled(scale(bar, -brake), -(brake_bar * brake * inverse * inverse), u_t);
    float j_bar = dot(n, bar) + law.friction * most_bar;
    // j = dt/2 (y + root) / p.
    float q = 0.5f * l.dt / a.p;
    float root_inverse = a.root > 0.0f ? 1.0f / a.root : 0.0f;
    // y + root cancels where y is negative, as j does: it is 2 p j / dt.
    float y_bar = j_bar * q * (a.j / q) * root_inverse;
    if (!(a.root > 0.0f)) y_bar = j_bar * q;
    float b_bar = fmaf(j_bar * q * a.p * a.b, root_inverse, y_bar);
    float p_bar = j_bar * (q * 0.5f * a.b * a.b * root_inverse - a.j / a.p);
    float gamma_bar = l.dt * p_bar - u_n * y_bar;
    float share_bar = gamma_bar * (a.damping + l.dt * l.stiffness);
    float u_n_bar = -(a.gamma * y_bar) - dot(n, u_t_bar);
    ContactAdjoint out;
    out.start = zero3();
    out.distance = share_bar * a.share_slope - b_bar * l.stiffness * a.share;
    out.v = add_scaled(u_t_bar, u_n_bar, n);
    out.normal = add_scaled(add_scaled(scale(bar, a.j), u_n_bar, u), -u_n, u_t_bar);
    out.restitution = -(2.0f * gamma_bar * a.share * sqrtf(l.stiffness));
    out.friction = most_bar * a.j;
    return out;
}
