// Rods that twist between a clamp and another one, or a branch: the twist's gradient at an inner
// node, and its adjoint.
//
// With e and g the edges before and after a node, n = e x g and fold = |e||g| + e.g: the derivative
// of the twist by the node before is a = n / (fold |e|), by the node after c = -n / (fold |g|), by
// the node itself minus their sum. With a branch that holds the frame, g is its arm: a = -(e.g) n /
// (|e||n|^2), c = -|e| n / |n|^2. If an edge has no length, the rod folds back on itself or an arm
// hardly leaves its line, everything is zero. Only inner nodes between clamps count (`clamp.cuh`).

struct Turn {
    float3 e, g;
    float e_length, g_length;
    float inverse_e, inverse_g, inverse_fold;
    float3 a, c;
    bool is_arm;
    float3 n;                       // of an arm, as what follows
    float overlap, inverse_square;  // e.g, 1 / |n|^2
};

DEVICE Turn turn_of(float3 e, float3 g) {
    Turn t;
    t.is_arm = false;
    t.e = e;
    t.g = g;
    float e_length = sqrtf(dot(e, e)), g_length = sqrtf(dot(g, g));
    t.e_length = fmaxf(e_length, MIN_EDGE_M);
    t.g_length = fmaxf(g_length, MIN_EDGE_M);
    float both = t.e_length * t.g_length;
    float fold = both + dot(e, g), least = MIN_FOLD * both;
    bool regular = e_length > MIN_EDGE_M && g_length > MIN_EDGE_M && fold > least;
    t.inverse_e = regular ? 1.0f / t.e_length : 0.0f;
    t.inverse_g = regular ? 1.0f / t.g_length : 0.0f;
    t.inverse_fold = regular ? 1.0f / fold : 0.0f;
    float3 n = cross(e, g);
    t.a = scale(n, t.inverse_fold * t.inverse_e);
    t.c = scale(n, -(t.inverse_fold * t.inverse_g));
    return t;
}

DEVICE Turn arm_of(float3 e, float3 g) {
    Turn t;
    t.is_arm = true;
    t.e = e;
    t.g = g;
    t.n = cross(e, g);
    t.overlap = dot(e, g);
    float e_length = sqrtf(dot(e, e)), g_length = sqrtf(dot(g, g));
    t.e_length = fmaxf(e_length, MIN_EDGE_M);
    t.g_length = fmaxf(g_length, MIN_EDGE_M);
    float both = t.e_length * t.g_length, square = dot(t.n, t.n),
          least = MIN_SINE_SQUARED * both * both;
    bool regular = e_length > MIN_EDGE_M && g_length > MIN_EDGE_M && square > least;
    t.inverse_e = regular ? 1.0f / t.e_length : 0.0f;
    t.inverse_square = regular ? 1.0f / square : 0.0f;
    t.a = scale(t.n, -(t.overlap * t.inverse_e * t.inverse_square));
    t.c = scale(t.n, -(t.e_length * t.inverse_square));
    return t;
}

// The twist's gradient applied to relative vectors at the nodes before and after.
DEVICE float along(const Turn& t, float3 before, float3 after) {
    return dot(t.a, before) + dot(t.c, after);
}

// As `turn_adjoint`, of an arm: a = p n, c = q n.
DEVICE void arm_adjoint(const Turn& t, float3 a_bar, float3 c_bar, float3& before, float3& after) {
    float p_bar = dot(t.n, a_bar), q_bar = dot(t.n, c_bar);
    float by_length = t.inverse_e * t.inverse_square;
    float p = -(t.overlap * by_length), q = -(t.e_length * t.inverse_square);
    float overlap_bar = -(p_bar * by_length);
    float stretch = -((p_bar * p * t.inverse_e + q_bar * t.inverse_square) * t.inverse_e);
    float square_bar = -(p_bar * p + q_bar * q) * t.inverse_square;
    float3 n_bar = add_scaled(add_scaled(scale(a_bar, p), q, c_bar), 2.0f * square_bar, t.n);
    float3 e_bar = add_scaled(add_scaled(cross(t.g, n_bar), overlap_bar, t.g), stretch, t.e);
    before = scale(e_bar, -1.0f);
    after = add_scaled(cross(n_bar, t.e), overlap_bar, t.e);
}

// Adjoint of (a, c): what it makes of the positions of the nodes before and after.
DEVICE void turn_adjoint(const Turn& t, float3 a_bar, float3 c_bar, float3& before, float3& after) {
    if (t.is_arm) return arm_adjoint(t, a_bar, c_bar, before, after);
    float by_a = dot(t.a, a_bar), by_c = dot(t.c, c_bar);
    float3 n_bar = scale(a_bar, t.inverse_fold * t.inverse_e);
    n_bar = add_scaled(n_bar, -(t.inverse_fold * t.inverse_g), c_bar);
    float fold_bar = -((by_a + by_c) * t.inverse_fold);
    float e_stretch = (fold_bar * t.g_length - by_a * t.inverse_e) * t.inverse_e;
    float g_stretch = (fold_bar * t.e_length - by_c * t.inverse_g) * t.inverse_g;
    float3 e_bar = add_scaled(add_scaled(cross(t.g, n_bar), fold_bar, t.g), e_stretch, t.e);
    float3 g_bar = add_scaled(add_scaled(cross(n_bar, t.e), fold_bar, t.e), g_stretch, t.g);
    before = scale(e_bar, -1.0f);
    after = g_bar;
}

// A warp's sum, known to all its lanes.
DEVICE float sum_warp(float x) {
    for (int mask = 16; mask > 0; mask /= 2) x += __shfl_xor_sync(0xffffffffu, x, mask);
    return x;
}
