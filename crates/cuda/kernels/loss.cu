// An objective's terms: their values, and d loss / d positions at frame ends, gathered by node.

struct ScoreArgs {
    const ObjectiveArgs* objectives;
};

struct SeedSkinArgs {
    const ObjectiveArgs* objectives;
};

struct SeedArgs {
    const ObjectiveArgs* objectives;
};

struct SeedRestLengthsArgs {
    const ObjectiveArgs* objectives;
    float* const* outs;       // by instance: d loss / d parameters, in their order
};

struct SeedForcesArgs {
    const ObjectiveArgs* objectives;
};

struct SeedPosesArgs {
    const ObjectiveArgs* objectives;
    float* const* outs;       // by instance: d loss / d poses, [frames + 1][B][3][4]
};

// Value of a piece of a term of one instance: block (piece, instance).
extern "C" __global__ void __launch_bounds__(THREADS)
score(const __grid_constant__ ScoreArgs args) {
    const ObjectiveArgs& m = args.objectives[blockIdx.y];
    for (u32 piece = blockIdx.x; piece < m.piece_count; piece += gridDim.x) {
        const Piece own = m.pieces[piece];
        const Term t = m.terms[own.term];
        double sum = 0.0;
        u32 over = t.count;
        if (seeks_nearest(t)) {
            sum = nearest(m, t, own.first);
        } else if (t.kind == TRACK) {
            sum = track(m, t);
        } else if (t.kind == STRAIN) {
            over = m.strained_count;
            for (u32 i = threadIdx.x; i < m.spring_count; i += THREADS) {
                Stretch s;
                if (!stretch(m, t.frame, i, s)) continue;
                double e = excess(t, s);
                sum += e * e;
            }
        } else if (t.kind == CLEARANCE) {
            over = m.node_count;
            Pose pose = collider_pose(m, m.world.colliders[t.part], t.frame);
            for (u32 i = threadIdx.x; i < m.node_count; i += THREADS) {
                float3 normal;
                double lack = lack_of(m, t, into_body(pose, position(m, t.frame, i)), normal);
                sum += lack * lack;
            }
        } else if (t.kind == FORCE) {
            over = 1;
            float3 f = force_of(m, t);
            double excess = fmax(sqrt((double)dot(f, f)) - (double)t.beta, 0.0);
            if (threadIdx.x == 0) sum = excess * excess;
        } else if (t.kind == ORDER) {
            over = links_of(t);
            sum = order(m, t);
        } else if (t.kind == WINDING) {
            over = 1;
            double apart = turns_beyond(m, t);
            if (threadIdx.x == 0) sum = apart * apart;
        } else if (t.kind == ABOVE || t.kind == WITHIN) {
            over = t.loss == ALL_NODES ? m.node_count : t.count;
            for (u32 i = threadIdx.x; i < over; i += THREADS) {
                u32 node = t.loss == ALL_NODES ? i : m.target_points[t.first + i];
                float3 d = beyond(t, position(m, t.frame, node));
                sum += dot(d, d);
            }
        } else {
            over = m.node_count;
            if (t.frame >= 2) {
                for (u32 i = threadIdx.x; i < m.node_count; i += THREADS) {
                    float3 d = second_difference(m, t.frame, i);
                    sum += dot(d, d);
                }
            }
        }
        sum = block_sum(sum);
        if (threadIdx.x == 0) m.values[piece] = (double)t.weight * (sum / max(over, 1u));
    }
}

// d loss / d position of a node by the accelerations of a frame, which look back `back` frames at
// this one.
DEVICE float3 acceleration_seed(const ObjectiveArgs& m, u32 frame, u32 back, u32 node) {
    float3 sum = zero3();
    u32 at = frame + back;
    if (at > m.frame_count || at < 2) return sum;
    const float share = back == 1 ? -2.0f : 1.0f;
    for (u32 term = m.frame_terms[at]; term < m.frame_terms[at + 1]; term++) {
        const Term t = m.terms[term];
        if (t.kind != ACCELERATION) continue;
        float w = 2.0f * t.weight * share / max(m.node_count, 1u);
        sum = add_scaled(sum, w, second_difference(m, at, node));
    }
    return sum;
}

// d loss / d position of points of the skin. Block (points, frame with terms at the skin, instance).
// `score` has found the nearest points.
extern "C" __global__ void __launch_bounds__(THREADS)
seed_skin(const __grid_constant__ SeedSkinArgs args) {
    const ObjectiveArgs& m = args.objectives[blockIdx.z];
    const u32 row = blockIdx.y, first = blockIdx.x * THREADS, count = m.skin.point_count;
    if (row >= m.skin_frame_count || first >= count) return;
    const u32 frame = m.skin_frames[row], point = first + threadIdx.x;
    const bool has = point < count;
    const float3 here = skin_at(m.skin, positions(m, frame), has ? point : 0);
    float3 sum = zero3();
    for (u32 term = m.frame_terms[frame]; term < m.frame_terms[frame + 1]; term++) {
        const Term t = m.terms[term];
        if (t.of == SKIN) sum = add(sum, target_seed(m, t, first, here));
    }
    if (has) {
        float* bars = m.point_bars + (u64)row * 3 * count;
        bars[point] = sum.x;
        bars[count + point] = sum.y;
        bars[2 * (u64)count + point] = sum.z;
    }
}

// Block (nodes, frame, instance). `score` has found the nearest nodes, `seed_skin` what comes from the
// skin.
extern "C" __global__ void __launch_bounds__(THREADS) seed(const __grid_constant__ SeedArgs args) {
    const ObjectiveArgs& m = args.objectives[blockIdx.z];
    u32 frame = blockIdx.y;
    if (frame > m.frame_count || blockIdx.x * THREADS >= m.node_count) return;
    u32 node = blockIdx.x * THREADS + threadIdx.x;
    bool has = node < m.node_count;
    u32 i = has ? node : 0;
    float3 here = position(m, frame, i);
    float3 sum = zero3();
    const float* point_bars = nullptr;
    bool cut = m.cut_every > 0 && frame > 0 && frame % m.cut_every == 0;
    if (!cut) {
        sum = add(acceleration_seed(m, frame, 1, i), acceleration_seed(m, frame, 2, i));
    }
    for (u32 term = m.frame_terms[frame]; term < m.frame_terms[frame + 1]; term++) {
        const Term t = m.terms[term];
        if (t.kind == ACCELERATION) {
            if (frame >= 2) {
                float w = 2.0f * t.weight / max(m.node_count, 1u);
                sum = add_scaled(sum, w, second_difference(m, frame, i));
            }
            continue;
        }
        if (t.kind == STRAIN) {
            sum = add(sum, strain_seed(m, t, frame, i));
            continue;
        }
        if (t.kind == FORCE) continue;
        if (t.kind == CLEARANCE) {
            Pose pose = collider_pose(m, m.world.colliders[t.part], frame);
            float3 normal;
            float lack = lack_of(m, t, into_body(pose, here), normal);
            float w = -2.0f * t.weight / max(m.node_count, 1u);
            sum = add(sum, turn(pose, scale(normal, w * lack)));
            continue;
        }
        const bool region = t.kind == ABOVE || t.kind == WITHIN;
        if (region && t.loss == ALL_NODES) {
            sum = add_scaled(sum, 2.0f * t.weight / max(m.node_count, 1u), beyond(t, here));
            continue;
        }
        if (t.of == SKIN) {
            // All terms of a frame at the skin have the same.
            point_bars = m.point_bars + (u64)t.part * 3 * m.skin.point_count;
            continue;
        }
        // Without a surface there is no nearest node.
        if (seeks_nearest(t) && m.surface_count == 0) continue;
        sum = add(sum, target_seed(m, t, blockIdx.x * THREADS, here));
    }
    if (point_bars && has) sum = add(sum, carried_bar(m.skin, positions(m, frame), point_bars, i));
    if (has) {
        float* s = m.seeds + (u64)frame * 3 * m.node_count;
        s[node] = sum.x;
        s[m.node_count + node] = sum.y;
        s[2 * m.node_count + node] = sum.z;
    }
}

// Adds d loss / d rest lengths by strains, which depend on them directly. Block (springs, instance).
extern "C" __global__ void seed_rest_lengths(const __grid_constant__ SeedRestLengthsArgs args) {
    const ObjectiveArgs& m = args.objectives[blockIdx.y];
    u32 spring = blockIdx.x * THREADS + threadIdx.x;
    if (!m.spring_starts || spring >= m.spring_count) return;
    float sum = 0.0f;
    for (u32 term = 0; term < m.term_count; term++) {
        const Term t = m.terms[term];
        Stretch s;
        if (t.kind != STRAIN || !stretch(m, t.frame, spring, s)) continue;
        float slope = 2.0f * t.weight / max(m.strained_count, 1u) * excess(t, s);
        sum -= slope * s.length / (s.rest * s.rest);
    }
    args.outs[blockIdx.y][2 * (u64)m.spring_count + spring] += sum;
}

// Adds to one of a frame's d loss / d forces.
DEVICE void add_force_bar(float* to, float s, float3 f) {
    to[0] += s * f.x;
    to[1] += s * f.y;
    to[2] += s * f.z;
}

// d loss / d forces of all frames, which are zero before. Those of control points have what comes
// through their grasps too. Block (instance).
extern "C" __global__ void __launch_bounds__(THREADS)
seed_forces(const __grid_constant__ SeedForcesArgs args) {
    const ObjectiveArgs& m = args.objectives[blockIdx.x];
    if (!m.force_bars) return;
    const u32 grasps = 6 * m.control_count;
    for (u32 term = 0; term < m.term_count; term++) {
        const Term t = m.terms[term];
        if (t.kind != FORCE || t.frame == 0) continue;
        float3 f = force_of(m, t);
        float size = sqrtf(dot(f, f)), excess = size - t.beta;
        if (excess <= 0.0f || size <= 0.0f) continue;
        float s = 2.0f * t.weight * excess / size;
        float* bars = m.force_bars + (u64)(t.frame - 1) * force_stride(m);
        // A thread has the same control points in all terms; the first has all else.
        for (u32 c = threadIdx.x; c < m.control_count; c += THREADS) {
            bool through = t.loss == BY_GRASP && m.world.grasp_of &&
                           m.world.grasp_of[c] == (int)t.part;
            if (t.loss == BY_CONTROLS || through || (t.loss == BY_ONE_CONTROL && c == t.part))
                add_force_bar(bars + 6 * c, s, f);
        }
        if (threadIdx.x == 0 && t.loss != BY_CONTROLS && t.loss != BY_ONE_CONTROL)
            add_force_bar(bars + (t.loss == BY_GRASP ? grasps + 6 * t.part : force_place(m, t)), s, f);
    }
}

// Adds d loss / d poses by clearances, which depend on them directly. Block (instance).
extern "C" __global__ void __launch_bounds__(THREADS)
seed_poses(const __grid_constant__ SeedPosesArgs args) {
    const ObjectiveArgs& m = args.objectives[blockIdx.x];
    for (u32 term = 0; term < m.term_count; term++) {
        const Term t = m.terms[term];
        if (t.kind != CLEARANCE) continue;
        const Collider& c = m.world.colliders[t.part];
        if (c.body == NO_BODY) continue;
        Pose pose = collider_pose(m, c, t.frame);
        float w = -2.0f * t.weight / max(m.node_count, 1u);
        float sums[12];
        for (u32 k = 0; k < 12; k++) sums[k] = 0.0f;
        for (u32 i = threadIdx.x; i < m.node_count; i += THREADS) {
            float3 normal, x = position(m, t.frame, i);
            float lack = lack_of(m, t, into_body(pose, x), normal);
            float3 q_bar = scale(normal, w * lack);
            float3 arm = sub(x, origin(pose)), x_bar = turn(pose, q_bar);
            const float arms[3] = {arm.x, arm.y, arm.z}, bars[3] = {x_bar.x, x_bar.y, x_bar.z};
            for (u32 r = 0; r < 3; r++) {
                sums[4 * r] += arms[r] * q_bar.x;
                sums[4 * r + 1] += arms[r] * q_bar.y;
                sums[4 * r + 2] += arms[r] * q_bar.z;
                sums[4 * r + 3] -= bars[r];
            }
        }
        float* out = args.outs[blockIdx.x] + ((u64)t.frame * m.world.body_count + c.body) * 12;
        for (u32 k = 0; k < 12; k++) {
            double sum = block_sum((double)sums[k]);
            if (threadIdx.x == 0) out[k] += (float)sum;
        }
    }
}
