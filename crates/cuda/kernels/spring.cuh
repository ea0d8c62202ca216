// Axial springs with dashpots, and the adjoint of their forces, as seen from one end: every spring
// is evaluated from both ends, so that a node's force is gathered in a fixed order.
//
// With r = x_other - x_self, l = |r|, d = r / l and q = (v_other - v_self) . d:
// f_self = [k (l/l0 - 1) + gamma q] d.

// One end of a spring; `other` is a local index.
struct HalfSpring {
    float rate;  // k / l0 [N/m]
    float rest;  // l0 [m]
    float dashpot;
    u32 other;
};

// A pair of half-springs in memory: 20 bytes where all dashpots are equal, 28 where they differ.
struct Pair {
    float4 rates;
    u32 others;
#if !UNIFORM_DASHPOT
    float2 dashpots;
#endif
};

// Arrays of pairs.
struct Pairs {
    const float4* rates;
    const u32* others;
    const float2* dashpots;
};

DEVICE Pair load_pair(const Pairs& from, u32 at) {
    Pair p;
    p.rates = from.rates[at];
    p.others = from.others[at];
#if !UNIFORM_DASHPOT
    p.dashpots = from.dashpots[at];
#endif
    return p;
}

// Those of a lane from `at` on: every 32nd.
DEVICE Pairs pairs_from(const Pairs& from, u32 at) {
    Pairs p = {from.rates + at, from.others + at, from.dashpots + at};
    return p;
}
DEVICE void next_pair(Pairs& of) {
    of.rates += 32;
    of.others += 32;
    of.dashpots += 32;
}

// Joins a node with itself, without stiffness.
DEVICE Pair no_pair(u32 self) {
    Pair p;
    p.rates = zero4();
    p.others = self | self << 16;
#if !UNIFORM_DASHPOT
    p.dashpots = make_float2(0.0f, 0.0f);
#endif
    return p;
}

DEVICE HalfSpring first_of(const Pair& p, float dashpot) {
    HalfSpring s;
    s.rate = p.rates.x;
    s.rest = p.rates.y;
    s.other = p.others & 0xffff;
    s.dashpot = dashpot;
#if !UNIFORM_DASHPOT
    s.dashpot = p.dashpots.x;
#endif
    return s;
}

DEVICE HalfSpring second_of(const Pair& p, float dashpot) {
    HalfSpring s;
    s.rate = p.rates.z;
    s.rest = p.rates.w;
    s.other = p.others >> 16;
    s.dashpot = dashpot;
#if !UNIFORM_DASHPOT
    s.dashpot = p.dashpots.y;
#endif
    return s;
}

// Adds the spring's force on this end. Below the shortest length that has a direction r itself is
// nothing.
DEVICE void spring_force(const HalfSpring& s, float3 r, float3 w, float3& force) {
    float square = dot(r, r);
#if GRASPS
    if (square > FAR_SQUARED_M2) return;
#endif
    float inverse = rsqrtf(fmaxf(square, MIN_LENGTH_SQUARED_M2));
    float stretch = fmaf(square, inverse, -s.rest);
    float magnitude = fmaf(s.dashpot * inverse, dot(w, r), s.rate * stretch) * inverse;
    force = add_scaled(force, magnitude, r);
}

// Parts of d loss / d (stiffness, rest length, dashpot): sums over substeps of (l - l0) p, p and q
// p.
struct SpringSums {
    float stretch, pull, rate;
};

// Adds d loss / d (x, v) of this end, for `pull` = lambda_self - lambda_other.
DEVICE void spring_adjoint(
    const HalfSpring& s, float3 r, float3 w, float3 pull, float3& x_bar, float3& v_bar,
    SpringSums& sums
) {
    float square = dot(r, r);
#if GRASPS
    if (square > FAR_SQUARED_M2) return;
#endif
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
