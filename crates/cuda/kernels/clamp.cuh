// Clamps of rods: which part of each rod is twisted while hands hold what they do, how much stays of
// its twist, and how fast clamps turn about it. The rules are those of `cpu/elements/rod/span.rs` and
// `cpu/surroundings/clamp.rs`.

#define NO_HOLDER (-1)
#define BY_CONTROLS 0x7fffffff
#define MIN_TURN 1e-3f   // least 1 + trace of a hand's rotation in a frame
#define MIN_PLACES_M 1e-9f  // distance of two places that give a direction

// A rod by its inner nodes.
struct RodPath {
    const Triplet* turns;
    const u32* nodes;     // graph index of a local node
    const float* shares;  // share of the rod's length at each inner node
    u32 inner;
    bool has_arm;
};

DEVICE RodPath rod_path_of(const InstanceArgs& instance, u32 r) {
    const TopologyArgs& t = instance.topology;
    u32 first = t.rod_turns[r];
    RodPath p;
    // A graph with rods has one share.
    p.turns = t.triplets + t.shares->triplet + first;
    p.nodes = t.nodes + t.shares->nodes;
    p.shares = t.rod_shares + (first - t.rod_turns[0]);
    p.inner = t.rod_turns[r + 1] - first;
    p.has_arm = p.turns[p.inner - 1].owned != 0;
    return p;
}

// Graph index of a node along the rod.
DEVICE u32 node_along(const RodPath& p, u32 at) {
    u32 local = at == 0 ? p.turns[0].i : at <= p.inner ? p.turns[at - 1].j : p.turns[at - 2].k;
    return p.nodes[local];
}

// Share of the rod's length in some of its inner nodes; exactly 1 for all of them.
DEVICE float share_of(const RodPath& p, u32 first, u32 end) {
    if (first == 0 && end == p.inner) return 1.0f;
    float sum = 0.0f;
    for (u32 k = first; k < end; k++) sum += p.shares[k];
    return sum;
}

// Holder of a node: control points, a grasp, or nothing. `closed` has the grasps that hold.
template <class Closed>
DEVICE int holder_of(const InstanceArgs& instance, const Hold* holds, u32 node, Closed closed) {
    int pin = instance.topology.pin_of[node];
    if (pin >= 0) {
        const int* grasp_of = instance.world.grasp_of;
        int grasp = grasp_of ? grasp_of[instance.topology.pins[pin].control] : -1;
        if (grasp < 0 || closed(grasp)) return BY_CONTROLS;
    }
    int grasp = load_hold(holds + node).grasp;
    return grasp >= 0 && closed(grasp) ? grasp : NO_HOLDER;
}

// What holds a node in a frame whose holds are known.
DEVICE int holder_in(const InstanceArgs& instance, u32 frame, u32 node) {
    int pin = instance.topology.pin_of[node];
    if (is_pinned_in(instance, frame, pin))
        return BY_CONTROLS;
    return load_hold(holds_of(instance, frame) + node).grasp;
}

// The part of a rod between its outermost two clamps, or an arm; empty without them.
template <class Holder>
DEVICE RodSpan span_of(const RodPath& p, Holder holder) {
    RodSpan s = {0, 0, 1.0f, 0.0f, 0.0f, 0};
    u32 edges = p.inner + (p.has_arm ? 0 : 1);
    auto is_held = [&](u32 edge) {
        int by = holder(node_along(p, edge));
        return by != NO_HOLDER && by == holder(node_along(p, edge + 1));
    };
    u32 first = 0, end = p.inner;
    while (first < edges && !is_held(first)) first++;
    if (first == edges) return s;
    while (first + 1 < edges && is_held(first + 1)) first++;
    if (!p.has_arm) {
        end = edges - 1;
        while (!is_held(end)) end--;
        while (end > 0 && is_held(end - 1)) end--;
    }
    if (end <= first) return s;
    s.first = first;
    s.end = end;
    s.inverse_share = 1.0f / share_of(p, first, end);
    return s;
}

// Share of a twist beyond its rest that is left when one span takes another's place.
DEVICE float kept_of(const RodPath& p, const RodSpan& before, const RodSpan& behind) {
    u32 first = max(before.first, behind.first), end = min(before.end, behind.end);
    if (behind.end <= behind.first || end <= first) return 0.0f;
    if (first == behind.first && end == behind.end) return 1.0f;
    return __fdiv_rn(share_of(p, first, end), share_of(p, behind.first, behind.end));
}

// The turn of a hand in a frame about the edge between two nodes that it holds.
struct Roll {
    bool known;
    u32 body;
    BodyFrame of;
    float3 along, axial;
    float length, turn, tangent;  // tan(roll / 2)
};

DEVICE Roll roll_of(const InstanceArgs& instance, u32 frame, int grasp, u32 a, u32 b) {
    Roll r;
    const Hold* holds = holds_of(instance, frame);
    Hold from = load_hold(holds + a), to = load_hold(holds + b);
    float3 edge = sub(load_v3(to.place), load_v3(from.place));
    r.body = instance.world.grasps[grasp].body;
    r.of = body_of(instance, frame, r.body);
    const float4* was = &r.of.from.x;
    const float4* is = &r.of.to.x;
    r.axial = zero3();
    r.turn = 1.0f;
    for (u32 k = 0; k < 3; k++) {
        r.axial = add(r.axial, cross(xyz(is[k]), xyz(was[k])));
        r.turn += dot(xyz(was[k]), xyz(is[k]));
    }
    r.length = sqrtf(dot(edge, edge));
    r.known = r.length > MIN_PLACES_M && r.turn > MIN_TURN;
    r.along = r.known ? scale(edge, 1.0f / r.length) : zero3();
    r.tangent = r.known ? dot(r.along, r.axial) / r.turn : 0.0f;
    return r;
}

// Roll of one end of a rod's span in a frame [rad]: 0 the near one, 1 the far one.
DEVICE float end_roll(const InstanceArgs& instance, u32 frame, u32 r, const RodPath& p,
                      const RodSpan& span, u32 side) {
    if (side == 1 && p.has_arm) return 0.0f;
    u32 edge = side == 0 ? span.first : span.end;
    u32 a = node_along(p, edge), b = node_along(p, edge + 1);
    int holder = holder_in(instance, frame, a);
    if (holder == BY_CONTROLS) {
        const float* rolls = instance.world.rolls;
        if (!rolls) return 0.0f;
        u64 stride = 2 * instance.topology.rod_count;
        return rolls[end_of(instance, frame) * stride + 2 * r + side] -
               rolls[frame * stride + 2 * r + side];
    }
    return 2.0f * atanf(roll_of(instance, frame, holder, a, b).tangent);
}

// Rate of a rod's twist that its clamps impose [rad/s].
DEVICE float roll_rate_of(const InstanceArgs& instance, u32 frame, u32 r, const RodPath& p,
                          const RodSpan& span) {
    if (span.end <= span.first) return 0.0f;
    float roll = end_roll(instance, frame, r, p, span, 0) - end_roll(instance, frame, r, p, span, 1);
    return roll / instance.step.frame_s;
}

// The twisted part in a frame of a rod with `inner` inner nodes.
DEVICE RodSpan rod_span_of(const InstanceArgs& instance, u32 frame, u32 r, u32 inner) {
#if GRASPS
    const WorldArgs& w = instance.world;
    if (w.spans) {
        const RodSpan* from =
            w.spans + (u64)((frame + 1) % w.slot_count) * instance.topology.rod_count + r;
        RodSpan s;
        s.first = __ldcg(&from->first);
        s.end = __ldcg(&from->end);
        s.inverse_share = __ldcg(&from->inverse_share);
        s.kept = __ldcg(&from->kept);
        s.roll_rate = __ldcg(&from->roll_rate);
        s.pad = 0;
        return s;
    }
#endif
    RodSpan whole = {0, inner, 1.0f, 1.0f, 0.0f, 0};
#if ROLLS
    u64 stride = 2 * instance.topology.rod_count;
    const float* from = instance.world.rolls + frame * stride + 2 * r;
    const float* to = instance.world.rolls + end_of(instance, frame) * stride + 2 * r;
    whole.roll_rate = ((to[0] - from[0]) - (to[1] - from[1])) / instance.step.frame_s;
#endif
    return whole;
}
