// Terms of a list of points, each with the next one: their order along a direction, and how often they
// wind around a line. Formulas and their derivatives as in `cpu/loss/order.rs` and `winding.rs`.

#define TWO_PI 6.28318530717958647692

// Position of one of a list's points, by its place among those of all terms.
DEVICE float3 listed_at(const ObjectiveArgs& m, const Term& t, const Positions& p, u32 place) {
    return point_at(m, t, p, m.target_points[place]);
}

// Number of points of a list that have a next one.
DEVICE u32 links_of(const Term& t) { return max(t.count, 1u) - 1; }

// Distance that a point lacks to the one before it.
DEVICE float order_lack(const Term& t, float3 from, float3 to) {
    return fmaxf(t.beta - dot(load_v3(t.low), sub(to, from)), 0.0f);
}

// Sum of squared lacks of the thread's links.
DEVICE double order(const ObjectiveArgs& m, const Term& t) {
    const Positions p = positions(m, t.frame);
    double sum = 0.0;
    for (u32 i = t.first + threadIdx.x; i < t.first + links_of(t); i += THREADS) {
        const double lack = order_lack(t, listed_at(m, t, p, i), listed_at(m, t, p, i + 1));
        sum += lack * lack;
    }
    return sum;
}

// Half of d squared lacks / d position of a point of a list, which is at `here`.
DEVICE float3 order_pull(const ObjectiveArgs& m, const Term& t, u32 place, float3 here) {
    const Positions p = positions(m, t.frame);
    float pull = 0.0f;
    if (place > t.first) pull -= order_lack(t, listed_at(m, t, p, place - 1), here);
    if (place + 1 < t.first + t.count) pull += order_lack(t, here, listed_at(m, t, p, place + 1));
    return scale(load_v3(t.low), pull);
}

// The way from a term's line to a point.
DEVICE float3 radius_of(const Term& t, float3 x) {
    const float3 way = sub(x, load_v3(t.low)), direction = load_v3(t.high);
    return add_scaled(way, -dot(way, direction), direction);
}

// False for a point so near to the line that it has no angle around it.
DEVICE bool has_angle(float3 radius) {
    return dot(radius, radius) > LEAST_RADIUS_M * LEAST_RADIUS_M;
}

// Turns of a chain beyond those wanted; every thread of the block gets them.
DEVICE double turns_beyond(const ObjectiveArgs& m, const Term& t) {
    const Positions p = positions(m, t.frame);
    double sum = 0.0;
    for (u32 i = t.first + threadIdx.x; i < t.first + links_of(t); i += THREADS) {
        const float3 a = radius_of(t, listed_at(m, t, p, i));
        const float3 b = radius_of(t, listed_at(m, t, p, i + 1));
        if (has_angle(a) && has_angle(b))
            sum += atan2f(dot(load_v3(t.high), cross(a, b)), dot(a, b));
    }
    return block_sum(sum) / TWO_PI - t.beta;
}

// d sum of angles / d position of a point of a chain, which is at `here`.
DEVICE float3 winding_pull(const ObjectiveArgs& m, const Term& t, u32 place, float3 here) {
    const Positions p = positions(m, t.frame);
    const float3 radius = radius_of(t, here);
    if (!has_angle(radius)) return zero3();
    // The angle that ends here counts, and the one that begins is subtracted.
    float share = 0.0f;
    if (place > t.first && has_angle(radius_of(t, listed_at(m, t, p, place - 1)))) share += 1.0f;
    if (place + 1 < t.first + t.count && has_angle(radius_of(t, listed_at(m, t, p, place + 1))))
        share -= 1.0f;
    return scale(cross(load_v3(t.high), radius), share / dot(radius, radius));
}
