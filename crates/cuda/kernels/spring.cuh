// Axial springs with dashpots, and the adjoint of their forces, as seen from one end: every spring is
// evaluated from both ends, so that a node's force is gathered in a fixed order.
//
// With r = x_other - x_self, l = |r|, d = r / l and q = (v_other - v_self) . d:
// f_self = [k (l/l0 - 1) + gamma q] d.

// One end of a spring. `other` is a local index, stored as an integer's bits.
struct HalfSpring {
    float rate;  // k / l0 [N/m]
    float rest;  // l0 [m]
    float dashpot;
    int other;
};

DEVICE HalfSpring half_spring(float4 e) {
    HalfSpring s;
    s.rate = e.x;
    s.rest = e.y;
    s.dashpot = e.z;
    s.other = __float_as_int(e.w);
    return s;
}

// Adds the spring's force on this end.
DEVICE void spring_force(const HalfSpring& s, float3 r, float3 w, float3& force) {
    float square = dot(r, r);
    float inverse = inverse_length(square);
    float stretch = fmaf(square, inverse, -s.rest);
    float magnitude = fmaf(s.dashpot * inverse, dot(w, r), s.rate * stretch) * inverse;
    force = add_scaled(force, magnitude, r);
}

// What d loss / d (stiffness, rest length, dashpot) is made of: sums over substeps of (l - l0) p, p and q p.
struct SpringSums {
    float stretch, pull, rate;
};

// Adds d loss / d (x, v) of this end, for `pull` = lambda_self - lambda_other.
DEVICE void spring_adjoint(
    const HalfSpring& s, float3 r, float3 w, float3 pull, float3& x_bar, float3& v_bar,
    SpringSums& sums
) {
    float square = dot(r, r);
    float inverse = inverse_length(square);
    float stretch = inverse > 0.0f ? fmaf(square, inverse, -s.rest) : 0.0f;
    float3 d = scale(r, inverse);
    float p = dot(d, pull);
    float q = dot(d, w);
    float force = fmaf(s.dashpot, q, s.rate * stretch);
    float damped = s.dashpot * p;
    float along = s.rate * p - fmaf(damped, q, force * p) * inverse;
    x_bar = add_scaled(x_bar, -along, d);
    x_bar = add_scaled(x_bar, -(damped * inverse), w);
    x_bar = add_scaled(x_bar, -(force * inverse), pull);
    v_bar = add_scaled(v_bar, -damped, d);
    sums.stretch = fmaf(stretch, p, sums.stretch);
    sums.pull += p;
    sums.rate = fmaf(q, p, sums.rate);
}
