// Bending triplets (i, j, k) about the centre j, and the adjoint of their forces.
//
// With u = xi - xj, w = xk - xj, n = u x w, m = |n|: theta = atan2(m, u.w), g_i = u x n / (|u|^2
// m), g_k = n x w / (|w|^2 m), g_j = -(g_i + g_k). Rounded where a bent triplet passes through
// straight: with beta = pi - theta, epsilon = ROUNDING beta0, q = -sqrt(beta^2 + epsilon^2), G =
// beta / sqrt(beta^2 + epsilon^2) g, the force on a is -[k (q - q0) + c qdot] G_a. Nearly collinear
// triplets keep a force only where the rest angle is pi, where it is smooth.

#define PI_F 3.14159265358979f

// atan2(y, x) for y >= 0, in [0, pi]; within 3e-7 of the exact angle.
DEVICE float angle(float y, float x) {
    const float TAN_PI_8 = 0.41421357f;
    float magnitude = fabsf(x);
    float low = fminf(y, magnitude), high = fmaxf(y, magnitude);
    bool upper = low > TAN_PI_8 * high;
    float numerator = upper ? low - high : low;
    float denominator = upper ? low + high : high;
    float t = numerator / (denominator > 0.0f ? denominator : 1.0f);
    float z = t * t;
    float series =
        fmaf(fmaf(fmaf(8.0537445e-2f, z, -1.3877686e-1f), z, 1.9977711e-1f), z, -3.333295e-1f);
    float a = fmaf(series * z, t, t) + (upper ? 0.25f * PI_F : 0.0f);
    a = y > magnitude ? 0.5f * PI_F - a : a;
    return x < 0.0f ? PI_F - a : a;
}

struct BendParams {
    float stiffness, damping;
    float rest_bend;  // pi - theta0; exactly zero where straight
};

struct BendState {
    float3 a_u, a_w;  // m g_i and m g_k: smooth everywhere
    float3 n;
    float inverse_u2, inverse_w2;
    float inverse_m;  // 1 where collinear
    float cosine;     // u . w; -1 where it could divide by zero
    float deviation;  // q - q0
    float rounded;    // sqrt(beta^2 + epsilon^2); 1 where collinear
    float ease;       // beta / rounded, the share of theta's gradient that q has; 1 where collinear
    bool regular, straight;
};

DEVICE BendState bend_state(float3 u, float3 w, float rest_bend) {
    const float least = MIN_ARM_M * MIN_ARM_M;
    BendState t;
    float u2 = dot(u, u), w2 = dot(w, w);
    bool armed = u2 > least && w2 > least;
    t.inverse_u2 = armed ? 1.0f / u2 : 0.0f;
    t.inverse_w2 = armed ? 1.0f / w2 : 0.0f;
    t.n = cross(u, w);
    float m2 = dot(t.n, t.n);
    float cosine = dot(u, w);
    t.regular = armed && m2 * t.inverse_u2 * t.inverse_w2 >= MIN_SINE * MIN_SINE;
    t.straight = armed && !t.regular && rest_bend == 0.0f && cosine < 0.0f;
    float m = sqrtf(m2);
    t.a_u = scale(cross(u, t.n), t.inverse_u2);
    t.a_w = scale(cross(t.n, w), t.inverse_w2);
    t.inverse_m = t.regular ? 1.0f / m : 1.0f;
    t.cosine = t.straight ? cosine : -1.0f;
    float beta = angle(m, -cosine);
    float epsilon = ROUNDING * rest_bend;
    float square = fmaf(beta, beta, epsilon * epsilon);
    float inverse = t.regular ? rsqrtf(square) : 1.0f;
    t.rounded = t.regular ? square * inverse : 1.0f;
    t.ease = t.regular ? beta * inverse : 1.0f;
    t.deviation = ROUNDED_REST * rest_bend - t.rounded;
    return t;
}

// True if an end is a control point that its grasp has released.
DEVICE bool is_far(float3 u, float3 w) {
#if GRASPS
    return dot(u, u) > FAR_SQUARED_M2 || dot(w, w) > FAR_SQUARED_M2;
#else
    return false;
#endif
}

// Forces on i and k; the centre takes the opposite of their sum.
DEVICE void bend_force(
    BendParams p, float3 u, float3 w, float3 u_dot, float3 w_dot, float3& f_i, float3& f_k
) {
    f_i = f_k = zero3();
    if (is_far(u, w)) return;
    BendState t = bend_state(u, w, p.rest_bend);
    float rate = dot(t.a_u, u_dot) + dot(t.a_w, w_dot);
    float inverse = t.ease * t.inverse_m;
    float elastic = t.straight ? 1.0f / t.cosine : t.deviation * inverse;
    float damping = t.regular ? p.damping * rate * inverse * inverse : 0.0f;
    float magnitude = -((t.regular || t.straight ? p.stiffness * elastic : 0.0f) + damping);
    f_i = scale(t.a_u, magnitude);
    f_k = scale(t.a_w, magnitude);
}

// d loss / d (x_i, x_k, v_i, v_k) and the addends of d loss / d (stiffness, damping, rest angle).
struct BendAdjoint {
    float3 x_i, x_k, v_i, v_k;
    float stiffness, damping, rest;
};

// `pull_u` = lambda_i - lambda_j, `pull_w` = lambda_k - lambda_j.
DEVICE BendAdjoint bend_adjoint(
    BendParams p, float3 u, float3 w, float3 u_dot, float3 w_dot, float3 pull_u, float3 pull_w
) {
    BendAdjoint out;
    out.x_i = out.x_k = out.v_i = out.v_k = zero3();
    out.stiffness = out.damping = out.rest = 0.0f;
    if (is_far(u, w)) return out;
    BendState t = bend_state(u, w, p.rest_bend);
    if (t.regular) {
        float3 g_u = scale(t.a_u, t.inverse_m), g_w = scale(t.a_w, t.inverse_m);
        float rate = t.ease * (dot(g_u, u_dot) + dot(g_w, w_dot));
        float rho = t.ease * (dot(g_u, pull_u) + dot(g_w, pull_w));
        float kappa = p.stiffness * t.deviation + p.damping * rate;
        float3 y_u = add_scaled(scale(pull_u, kappa), rho * p.damping, u_dot);
        float3 y_w = add_scaled(scale(pull_w, kappa), rho * p.damping, w_dot);
        // The Hessian of q times y: the derivative of (G_i, G_k) along it.
        float3 n_dot = add(cross(y_u, w), cross(u, y_w));
        float m_rate = dot(t.n, n_dot) * t.inverse_m * t.inverse_m;
        float3 u_part = add(cross(y_u, t.n), cross(u, n_dot));
        float3 w_part = add(cross(n_dot, w), cross(t.n, y_w));
        float u_decay = 2.0f * dot(u, y_u) * t.inverse_u2 + m_rate;
        float w_decay = 2.0f * dot(w, y_w) * t.inverse_w2 + m_rate;
        float3 h_u = add_scaled(scale(u_part, t.inverse_u2 * t.inverse_m), -u_decay, g_u);
        float3 h_w = add_scaled(scale(w_part, t.inverse_w2 * t.inverse_m), -w_decay, g_w);
        float inverse_rounded = 1.0f / t.rounded;
        float turn = (1.0f - t.ease * t.ease) * inverse_rounded * (dot(g_u, y_u) + dot(g_w, y_w));
        float by_g = rho * p.stiffness * t.ease - turn;
        out.x_i = scale(add_scaled(scale(h_u, t.ease), by_g, g_u), -1.0f);
        out.x_k = scale(add_scaled(scale(h_w, t.ease), by_g, g_w), -1.0f);
        float by_rate = -(rho * p.damping * t.ease);
        out.v_i = scale(g_u, by_rate);
        out.v_k = scale(g_w, by_rate);
        out.stiffness = -(rho * t.deviation);
        out.damping = -(rho * rate);
        // The rest angle moves q0, and the rounding with it.
        float per_rounded = ROUNDING * ROUNDING * p.rest_bend * inverse_rounded;
        out.rest = rho * (p.stiffness * (ROUNDED_REST - per_rounded)
                          - (kappa + p.damping * rate) * per_rounded * inverse_rounded);
    } else if (t.straight) {
        // f_i = -k / (u.w) a_u, f_k = -k / (u.w) a_w.
        float r = -1.0f / t.cosine, d = t.cosine;
        float pu = dot(u, pull_u) * t.inverse_u2, pw = dot(w, pull_w) * t.inverse_w2;
        float work = dot(t.a_u, pull_u) + dot(t.a_w, pull_w);
        float along = pu + pw + r * work;
        float3 s_u = scale(w, along), s_w = scale(u, along);
        s_u = add_scaled(s_u, d * t.inverse_u2, add_scaled(pull_u, -2.0f * pu, u));
        s_w = add_scaled(s_w, d * t.inverse_w2, add_scaled(pull_w, -2.0f * pw, w));
        out.x_i = scale(sub(s_u, pull_w), p.stiffness * r);
        out.x_k = scale(sub(s_w, pull_u), p.stiffness * r);
        out.stiffness = r * work;
    }
    return out;
}
