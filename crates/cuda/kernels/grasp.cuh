// Grasps at frame boundaries: what they release and what they take. All that are commanded to open,
// or that were pulled too hard in the frame before, release first; then those that are commanded to
// close take, one after another, the nodes of their region that nothing holds.

#define MAX_GRASPS 32

DEVICE bool is_in(const WorldArgs& w, const Grasp& grasp, u32 node, float3 place) {
    if (grasp.region == REGION_SPHERE) {
        float3 r = sub(place, load_v3(grasp.low));
        return dot(r, r) <= grasp.high[0] * grasp.high[0];
    }
    if (grasp.region == REGION_BOX) {
        return grasp.low[0] <= place.x && place.x <= grasp.high[0] && grasp.low[1] <= place.y &&
               place.y <= grasp.high[1] && grasp.low[2] <= place.z && place.z <= grasp.high[2];
    }
    if (grasp.region != REGION_NODES) return false;
    u32 low = grasp.member, end = grasp.member + grasp.members, high = end;
    while (low < high) {
        u32 middle = (low + high) / 2;
        if (w.members[middle] < node) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < end && w.members[low] == node;
}

// Phase of a grasp at the end of the frame before a boundary: it may have been pulled too hard.
DEVICE u32 phase_before(const InstanceArgs& instance, u32 g, u32 boundary, u32 phase) {
    const WorldArgs& w = instance.world;
    const Grasp& grasp = w.grasps[g];
    if (phase == PHASE_CLOSED && boundary > 0 && isfinite(grasp.max_force)) {
        u32 c = instance.topology.control_count;
        u32 stride = 6 * (c + w.grasp_count + w.collider_count) + 3;
        const float* f = w.forces + (u64)(boundary - 1) * stride + 6 * (c + g);
        float3 force = v3(__ldcg(f), __ldcg(f + 1), __ldcg(f + 2));
        if (sqrtf(dot(force, force)) > grasp.max_force) phase = PHASE_SLIPPED;
    }
    return phase;
}

// Phase of a grasp behind a boundary, from the one at the end of the frame before it.
DEVICE u32 phase_behind(const InstanceArgs& instance, u32 g, u32 boundary, u32 phase) {
    const WorldArgs& w = instance.world;
    const Grasp& grasp = w.grasps[g];
    if (boundary >= instance.state.frame_count) return phase;
    if (!w.closed[(u64)boundary * w.grasp_count + g]) return PHASE_OPEN;
    if (phase == PHASE_OPEN && grasp.region != REGION_CONTROLS) return PHASE_CLOSED;
    return phase;
}

// Changes the grasps of an instance at a boundary, by all threads of a block; frames from there to
// before `end` begin with the same holds.
DEVICE void change_grasps_of(const InstanceArgs& instance, u32 boundary, u32 end) {
    __shared__ u32 phases[MAX_GRASPS];
    __shared__ bool takes[MAX_GRASPS];
    __shared__ bool held[MAX_GRASPS];
    const WorldArgs& w = instance.world;
    const u32 n = instance.topology.node_count;
    const u32 frames = instance.state.frame_count, count = w.grasp_count;
    if (count == 0 || boundary > frames) return;
    // Slots of the frames that follow; behind the last frame one that nothing happens in.
    const u32 first = boundary + 1, last = max(first, min(end, frames));
    const u32 used = min(last - first + 1, w.slot_count);
    const u32 g = threadIdx.x;
    if (g < count) {
        u32 before = w.phases[(u64)(boundary % w.slot_count) * count + g];
        u32 until = phase_before(instance, g, boundary, before);
        held[g] = until == PHASE_CLOSED;
        phases[g] = phase_behind(instance, g, boundary, until);
        takes[g] = before != PHASE_CLOSED && phases[g] == PHASE_CLOSED;
    }
    __syncthreads();
    for (u32 k = 0; g < count && k < used; k++)
        w.phases[(u64)((first + k) % w.slot_count) * count + g] = phases[g];
    float* state =
        instance.state.states + (u64)(boundary % instance.state.slot_count) * 6 * n;
    for (u32 node = threadIdx.x; node < n; node += THREADS) {
        Hold hold = w.holds[(u64)(boundary % w.slot_count) * n + node];
        if (hold.grasp >= 0 && phases[hold.grasp] != PHASE_CLOSED) hold.grasp = -1;
        int pin = instance.topology.pin_of[node];
        if (pin >= 0 && w.grasp_of) {
            int of = w.grasp_of[instance.topology.pins[pin].control];
            if (of >= 0 && phases[of] != PHASE_CLOSED) pin = -1;
        }
        // Other blocks may have written it in the same launch.
        float3 x = v3(__ldcg(state + node), __ldcg(state + n + node), __ldcg(state + 2 * n + node));
        for (u32 k = 0; k < count && hold.grasp < 0 && pin < 0; k++) {
            if (!takes[k]) continue;
            const Grasp& grasp = w.grasps[k];
            Pose pose = load_pose(w.poses + ((u64)boundary * w.body_count + grasp.body) * 3);
            float3 place = into_body(pose, x);
            if (!is_in(w, grasp, node, place)) continue;
            hold.grasp = (int)k;
            hold.place[0] = place.x;
            hold.place[1] = place.y;
            hold.place[2] = place.z;
        }
        for (u32 k = 0; k < used; k++) w.holds[(u64)((first + k) % w.slot_count) * n + node] = hold;
        if (boundary > 0 || hold.grasp < 0 || pin >= 0) continue;
        // Nodes held at the start stand at the places measured there.
        const Grasp& grasp = w.grasps[hold.grasp];
        if (grasp.attachment != HOLD_PIN) continue;
        BodyFrame body = body_of(instance, 0, grasp.body);
        float3 place = load_v3(hold.place), at = apply(body.from, place), v = zero3();
        if (instance.step.controls_move) v = body_velocity(body, place);
        state[node] = at.x;
        state[n + node] = at.y;
        state[2 * n + node] = at.z;
        state[3 * n + node] = v.x;
        state[4 * n + node] = v.y;
        state[5 * n + node] = v.z;
    }
    __syncthreads();
    if (!w.spans) return;
    const Hold* was = w.holds + (u64)(boundary % w.slot_count) * n;
    const Hold* is = w.holds + (u64)(first % w.slot_count) * n;
    const u32 rods = instance.topology.rod_count;
    for (u32 r = threadIdx.x; r < rods; r += THREADS) {
        RodPath path = rod_path_of(instance, r);
        RodSpan before = span_of(path, [&](u32 node) {
            return holder_of(instance, was, node, [&](int g) { return held[g]; });
        });
        RodSpan span = span_of(path, [&](u32 node) {
            return holder_of(instance, is, node, [&](int g) { return phases[g] == PHASE_CLOSED; });
        });
        span.kept = kept_of(path, before, span);
        for (u32 k = 0; k < used; k++) {
            span.roll_rate = roll_rate_of(instance, boundary + k, r, path, span);
            w.spans[(u64)((first + k) % w.slot_count) * rods + r] = span;
            span.kept = span.end > span.first ? 1.0f : 0.0f;
        }
    }
    __syncthreads();
}
