// Grasps in front of a launch, and the adjoint of what they take.

struct ChangeGraspsArgs {
    const InstanceArgs* instances;
    u32 boundary;
    u32 end;  // frames from the boundary to before this one begin with the same holds
};

// Block (instance).
extern "C" __global__ void __launch_bounds__(THREADS)
change_grasps(const __grid_constant__ ChangeGraspsArgs args) {
    change_grasps_of(args.instances[blockIdx.x], args.boundary, args.end);
}

struct CollectMotionArgs {
    const InstanceArgs* instances;
    float* const* poses;  // by instance: d loss / d poses, [frames + 1][B][3][4]; null if not wanted
    float* const* rolls;  // by instance: d loss / d rolls, [frames + 1][R][2]
    u32 starts;           // whether it is the adjoint of how the rollout starts
    u32 pad;
};

// Adds `from` and `to` times [o, 1] transposed to those of a node by the poses of a body.
DEVICE void add_poses(const InstanceArgs& instance, u32 body, u32 node, float3 from, float3 to,
                      float3 o) {
    BodySums sums = body_sums_of(instance, body, node);
    add_outer(sums, from, to, o, 1.0f);
}

// d loss / d the place of a node, from that of its path in the frame, which goes to the poses too.
DEVICE float3 place_bar_of(
    const InstanceArgs& instance, const BodyFrame& body, u32 of, u32 node, float3 place,
    float3 from, float3 to, float3 velocity
) {
    if (instance.step.controls_move) {
        from = add_scaled(from, -body.rate, velocity);
        to = add_scaled(to, body.rate, velocity);
    }
    add_poses(instance, of, node, from, to, place);
    return add(turn_back(body.from, from), turn_back(body.to, to));
}

// A node's part: of the path of its place in the frame, and of taking hold of it.
DEVICE void collect_node(const InstanceArgs& instance, u32 node, bool starts) {
    const WorldArgs& w = instance.world;
    const u32 frame = instance.state.first_frame, n = instance.topology.node_count;
    float4* bar_x = instance.adjoint.bar_x + node;
    float4* bar_v = instance.adjoint.bar_v + node;
    const Hold hold = holds_of(instance, frame)[node];
    if (hold.grasp < 0) return;
    const Grasp& grasp = w.grasps[hold.grasp];
    BodyFrame body = body_of(instance, frame, grasp.body);
    float3 place = load_v3(hold.place), bar = xyz(w.place_bars[node]);
    if (!starts) {
        float sums[9];
        for (u32 k = 0; k < 9; k++) {
            sums[k] = w.hold_sums[(u64)k * n + node];
            w.hold_sums[(u64)k * n + node] = 0.0f;
        }
        float3 from = load_v3(sums), to = load_v3(sums + 3), v = load_v3(sums + 6);
        bar = add(bar, place_bar_of(instance, body, grasp.body, node, place, from, to, v));
    } else if (grasp.attachment == HOLD_PIN) {
        float3 x = xyz(*bar_x), v = xyz(*bar_v);
        bar = add(bar, place_bar_of(instance, body, grasp.body, node, place, x, zero3(), v));
        *bar_x = *bar_v = zero4();
    }
    // A rollout takes what it takes at the start before anything is measured there.
    bool begins = starts || frame > 0;
    if (begins && w.holds[(u64)(frame % w.slot_count) * n + node].grasp != hold.grasp) {
        const float* x = frame == 0 ? w.initial
                                    : instance.state.states +
                                          (u64)(frame % instance.state.slot_count) * 6 * n;
        float3 at = v3(x[node], x[n + node], x[2 * (u64)n + node]);
        float3 arm = sub(at, origin(body.from)), x_bar = turn(body.from, bar);
        BodySums sums = body_sums_of(instance, grasp.body, node);
        add_outer(sums, arm, zero3(), bar, 0.0f);
        add_outer(sums, scale(x_bar, -1.0f), zero3(), zero3(), 1.0f);
        *bar_x = with_w(add(xyz(*bar_x), x_bar), 0.0f);
        bar = zero3();
    }
    w.place_bars[node] = with_w(bar, 0.0f);
}

// Adjoint of a hand's turn about an edge that it holds, d loss / d the turn being `bar`.
DEVICE void roll_adjoint(const InstanceArgs& instance, u32 frame, int grasp, u32 a, u32 b, float bar) {
    const WorldArgs& w = instance.world;
    Roll r = roll_of(instance, frame, grasp, a, b);
    if (!r.known) return;
    float by_axial = 2.0f * bar / ((1.0f + r.tangent * r.tangent) * r.turn);
    float by_turn = -by_axial * r.tangent;
    BodySums sums = body_sums_of(instance, r.body, a);
    const float4* was = &r.of.from.x;
    const float4* is = &r.of.to.x;
    for (u32 k = 0; k < 3 && sums.to; k++) {
        float3 from = xyz(was[k]), to = xyz(is[k]);
        float3 by_from = add_scaled(scale(cross(r.along, to), by_axial), by_turn, to);
        float3 by_to = add_scaled(scale(cross(from, r.along), by_axial), by_turn, from);
        const float both[6] = {by_from.x, by_from.y, by_from.z, by_to.x, by_to.y, by_to.z};
        for (u32 c = 0; c < 3; c++) {
            sums.to[(4 * k + c) * sums.stride] += both[c];
            sums.to[(12 + 4 * k + c) * sums.stride] += both[3 + c];
        }
    }
    float3 by_along = scale(r.axial, by_axial);
    float3 across = add_scaled(by_along, -dot(r.along, by_along), r.along);
    float3 by_edge = scale(across, 1.0f / r.length);
    w.place_bars[b] = with_w(add(xyz(w.place_bars[b]), by_edge), 0.0f);
    w.place_bars[a] = with_w(sub(xyz(w.place_bars[a]), by_edge), 0.0f);
}

// Hands what has come together for the rates of twists in a frame to what imposes them: prescribed
// turns of control points, poses and places of grasps. By one thread.
DEVICE void collect_rolls(const InstanceArgs& instance, u32 frame, float* rolls) {
    const WorldArgs& w = instance.world;
    const u32 rods = instance.topology.rod_count, end = end_of(instance, frame);
    for (u32 r = 0; r < rods; r++) {
        float bar = w.roll_sums[r] / instance.step.frame_s;
        w.roll_sums[r] = 0.0f;
        if (end == frame) continue;
        RodPath path = rod_path_of(instance, r);
        RodSpan span = {0, path.inner, 1.0f, 1.0f, 0.0f, 0};
        if (w.spans) span = w.spans[(u64)((frame + 1) % w.slot_count) * rods + r];
        if (span.end <= span.first) continue;
        for (u32 side = 0; side < 2; side++, bar = -bar) {
            if (w.spans && side == 1 && path.has_arm) continue;
            u32 edge = side == 0 ? span.first : span.end;
            u32 a = node_along(path, edge), b = node_along(path, edge + 1);
            int holder = w.spans ? holder_in(instance, frame, a) : BY_CONTROLS;
            if (holder != BY_CONTROLS) {
                roll_adjoint(instance, frame, holder, a, b, bar);
            } else if (rolls && w.rolls) {
                rolls[2 * ((u64)frame * rods + r) + side] -= bar;
                rolls[2 * ((u64)end * rods + r) + side] += bar;
            }
        }
    }
}

// Block (instance). The adjoint of a frame's beginning, and of what has come together in the frame:
// adds to d loss / d poses and rolls and clears their sums.
extern "C" __global__ void __launch_bounds__(THREADS)
collect_motion(const __grid_constant__ CollectMotionArgs args) {
    const InstanceArgs& instance = args.instances[blockIdx.x];
    const WorldArgs& w = instance.world;
    const u32 n = instance.topology.node_count, frame = instance.state.first_frame;
    const u32 end = end_of(instance, frame), lane = threadIdx.x % 32;
    float* rolls = args.rolls ? args.rolls[blockIdx.x] : 0;
    if (w.roll_sums && threadIdx.x == 0) collect_rolls(instance, frame, rolls);
    __syncthreads();
    for (u32 node = threadIdx.x; node < n; node += THREADS) {
        if (w.grasp_count > 0) collect_node(instance, node, args.starts);
        if (args.starts && w.arrive_bars) {
            float4* bar_v = instance.adjoint.bar_v + node;
            *bar_v = with_w(add(xyz(*bar_v), xyz(w.arrive_bars[node])), 0.0f);
        }
    }
    __syncthreads();
    float* poses = args.poses ? args.poses[blockIdx.x] : 0;
    // A warp for one entry of a body's two poses.
    for (u32 i = threadIdx.x / 32; i < 24 * w.body_count; i += THREADS / 32) {
        float* from = w.body_sums + (u64)i * n;
        float sum = 0.0f;
        for (u32 node = lane; node < n; node += 32) {
            sum += from[node];
            from[node] = 0.0f;
        }
        sum = sum_warp(sum);
        u32 body = i / 24, entry = i % 24, row = entry < 12 ? frame : end;
        // Where nothing moves there is no second boundary.
        bool has_row = entry < 12 || end > frame;
        if (lane == 0 && poses && has_row)
            poses[((u64)row * w.body_count + body) * 12 + entry % 12] += sum;
    }
}
