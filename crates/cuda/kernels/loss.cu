// An objective's terms: their values, and d loss / d positions at frame ends, gathered by node. The
// nearest node of a Chamfer target counts as fixed in the gradient. Springs that a strain is measured
// of join two nodes and have a rest length.

#define TILE 512
#define CHAMFER 0
#define TRACK 1
#define ACCELERATION 2
#define STRAIN 3
#define ABOVE 4
#define WITHIN 5
#define CLEARANCE 6
#define FORCE 7
#define BY_CONTROLS 0
#define BY_ONE_CONTROL 1
#define BY_GRASP 2
#define BY_GROUND 3
#define BY_COLLIDER 4
#define ALL_NODES 1
#define SMOOTH_L1 0
#define DISTANCE 1
#define SQUARED_DISTANCE 2

struct Term {
    u32 kind, frame;
    u32 count;   // targets, or nodes of a region
    u32 first;   // first of them
    u32 loss;    // of a region: ALL_NODES, or 0 for those counted; of a force: what exerts it
    float beta;  // limit of a strain or force, offset of a half space, margin of a collider
    float weight;
    u32 part;    // number of the collider, or of what exerts the force
    // Normal of a half space, or corners of a box.
    float low[3], high[3];
};

struct ObjectiveArgs {
    const float* states;      // [frames + 1][6][N]
    const Term* terms;        // ordered by frame
    const u32* frame_terms;   // [frames + 2]: first term of each frame
    const float* targets;     // [targets][3]
    const u32* target_nodes;  // of tracks and regions
    u32* nearest;             // [targets] of this instance
    double* values;           // [terms] of this instance
    float* seeds;             // [frames + 1][3][N], or null
    const u32* springs;       // [E][2]
    const float* params;      // as in `params.cu`
    const u32* spring_starts; // [N + 1]: first of each node's in `node_springs`; null without strains
    const u32* node_springs;  // springs between two nodes, ascending for each node
    u32 node_count, surface_count, frame_count, term_count;
    u32 cut_every;
    u32 spring_count;         // E
    u32 strained_count;       // springs that a strain is measured of
    u32 control_count;        // C
    WorldArgs world;
    float* force_bars;        // as `WorldArgs::force_bars`, of all frames; may be null
};

struct SeedForcesArgs {
    const ObjectiveArgs* objectives;
};

struct SeedPosesArgs {
    const ObjectiveArgs* objectives;
    float* const* outs;       // by instance: d loss / d poses, [frames + 1][B][3][4]
};

struct ScoreArgs {
    const ObjectiveArgs* objectives;
};

struct SeedArgs {
    const ObjectiveArgs* objectives;
};

struct SeedRestLengthsArgs {
    const ObjectiveArgs* objectives;
    float* const* outs;       // by instance: d loss / d parameters, in their order
};

DEVICE float3 position(const ObjectiveArgs& m, u32 frame, u32 node) {
    const float* s = m.states + (u64)frame * 6 * m.node_count;
    return v3(s[node], s[m.node_count + node], s[2 * m.node_count + node]);
}

DEVICE float3 second_difference(const ObjectiveArgs& m, u32 frame, u32 node) {
    float3 two = position(m, frame - 2, node), one = position(m, frame - 1, node);
    return add(add_scaled(position(m, frame, node), -2.0f, one), two);
}

DEVICE double point_loss(const Term& t, float3 d) {
    if (t.loss == SQUARED_DISTANCE) return dot(d, d);
    if (t.loss == DISTANCE) return sqrt((double)dot(d, d));
    double sum = 0.0, beta = t.beta;
    const float c[3] = {d.x, d.y, d.z};
    for (u32 i = 0; i < 3; i++) {
        double x = fabs((double)c[i]);
        sum += x < beta ? x * x / (2.0 * beta) : x - 0.5 * beta;
    }
    return sum / 3.0;
}

DEVICE float smooth_l1_gradient(float x, float beta) {
    if (fabsf(x) < beta) return x / beta / 3.0f;
    return x == 0.0f ? 0.0f : copysignf(1.0f / 3.0f, x);
}

DEVICE float3 point_gradient(const Term& t, float3 d) {
    if (t.loss == SQUARED_DISTANCE) return scale(d, 2.0f);
    if (t.loss == DISTANCE) {
        float length = sqrtf(dot(d, d));
        return length > 0.0f ? scale(d, 1.0f / length) : zero3();
    }
    return v3(
        smooth_l1_gradient(d.x, t.beta), smooth_l1_gradient(d.y, t.beta),
        smooth_l1_gradient(d.z, t.beta)
    );
}

// A spring at the end of a frame.
struct Stretch {
    u32 from, to;
    float3 along;
    float length, rest;
};

// False for a spring that no strain is measured of.
DEVICE bool stretch(const ObjectiveArgs& m, u32 frame, u32 spring, Stretch& s) {
    s.from = m.springs[2 * (u64)spring];
    s.to = m.springs[2 * (u64)spring + 1];
    s.rest = m.params[2 * (u64)m.spring_count + spring];
    if (!(s.rest > 0.0f) || max(s.from, s.to) >= m.node_count) return false;
    s.along = sub(position(m, frame, s.to), position(m, frame, s.from));
    s.length = sqrtf(dot(s.along, s.along));
    return true;
}

// max(0, |strain| - limit), with the strain's sign.
DEVICE float excess(const Term& t, const Stretch& s) {
    float strain = s.length / s.rest - 1.0f;
    return copysignf(fmaxf(fabsf(strain) - t.beta, 0.0f), strain);
}

// d loss / d position of a node by a strain.
DEVICE float3 strain_seed(const ObjectiveArgs& m, const Term& t, u32 frame, u32 node) {
    float3 sum = zero3();
    const float w = 2.0f * t.weight / max(m.strained_count, 1u);
    for (u32 k = m.spring_starts[node]; k < m.spring_starts[node + 1]; k++) {
        Stretch s;
        if (!stretch(m, frame, m.node_springs[k], s)) continue;
        float slope = w * excess(t, s);
        // Ends in one point have no direction in which to part.
        if (slope == 0.0f || !(s.length > 0.0f)) continue;
        float pull = slope / (s.rest * s.length);
        sum = add_scaled(sum, node == s.to ? pull : -pull, s.along);
    }
    return sum;
}

// From the nearest point of a half space or a box to a node; zero within.
DEVICE float3 beyond(const Term& t, float3 x) {
    float3 low = load_v3(t.low), high = load_v3(t.high);
    if (t.kind == ABOVE) return scale(low, -fmaxf(t.beta - dot(low, x), 0.0f));
    return v3(
        x.x - fminf(fmaxf(x.x, low.x), high.x), x.y - fminf(fmaxf(x.y, low.y), high.y),
        x.z - fminf(fmaxf(x.z, low.z), high.z)
    );
}

// Sum of squared distances of the thread's targets to their nearest surface nodes; ties go to the
// lower index.
DEVICE double chamfer(const ObjectiveArgs& m, const Term& t) {
    __shared__ float3 tile[TILE];
    double sum = 0.0;
    for (u32 base = 0; base < t.count; base += THREADS) {
        u32 i = base + threadIdx.x;
        bool has = i < t.count;
        float3 target = has ? load_v3(m.targets + 3 * (u64)(t.first + i)) : zero3();
        float best = 1e30f;
        u32 winner = 0;
        for (u32 start = 0; start < m.surface_count; start += TILE) {
            __syncthreads();
            u32 size = min((u32)TILE, m.surface_count - start);
            for (u32 k = threadIdx.x; k < size; k += THREADS)
                tile[k] = position(m, t.frame, start + k);
            __syncthreads();
            for (u32 k = 0; k < size; k++) {
                float3 d = sub(tile[k], target);
                float square = dot(d, d);
                if (square < best) {
                    best = square;
                    winner = start + k;
                }
            }
        }
        if (has && m.surface_count > 0) {
            m.nearest[t.first + i] = winner;
            float3 d = sub(position(m, t.frame, winner), target);
            sum += dot(d, d);
        }
    }
    return sum;
}

// Floats of a frame's forces.
DEVICE u32 force_stride(const ObjectiveArgs& m) {
    return 6 * (m.control_count + m.world.grasp_count + m.world.collider_count) + 3;
}

// Where a force stands among those of a frame.
DEVICE u32 force_place(const ObjectiveArgs& m, const Term& t) {
    u32 grasps = 6 * m.control_count, ground = grasps + 6 * m.world.grasp_count;
    if (t.loss == BY_ONE_CONTROL) return 6 * t.part;
    if (t.loss == BY_GRASP) return grasps + 6 * t.part;
    return t.loss == BY_GROUND ? ground : ground + 3 + 6 * t.part;
}

// The mean force over the frame that ends with a term's; zero before the first.
DEVICE float3 force_of(const ObjectiveArgs& m, const Term& t) {
    float3 sum = zero3();
    if (t.frame == 0) return sum;
    const float* forces = m.world.forces + (u64)(t.frame - 1) * force_stride(m);
    if (t.loss != BY_CONTROLS) return load_v3(forces + force_place(m, t));
    for (u32 c = 0; c < m.control_count; c++) sum = add(sum, load_v3(forces + 6 * c));
    return sum;
}

// Pose of a collider at the end of a frame.
DEVICE Pose collider_pose(const ObjectiveArgs& m, const Collider& c, u32 frame) {
    if (c.body == NO_BODY) return identity();
    return load_pose(m.world.poses + ((u64)frame * m.world.body_count + c.body) * 3);
}

// Distance that a node lacks to a term's collider; `q` is where it is in the body's coordinates.
DEVICE float lack_of(const ObjectiveArgs& m, const Term& t, float3 q, float3& normal) {
    const Collider& c = m.world.colliders[t.part];
    return fmaxf(t.beta - shape_distance(m.world, c, q, 3.4e38f, normal), 0.0f);
}

// Value of one term of one instance: block (term, instance).
extern "C" __global__ void __launch_bounds__(THREADS)
score(const __grid_constant__ ScoreArgs args) {
    const ObjectiveArgs& m = args.objectives[blockIdx.y];
    for (u32 term = blockIdx.x; term < m.term_count; term += gridDim.x) {
        const Term t = m.terms[term];
        double sum = 0.0;
        u32 over = t.count;
        if (t.kind == CHAMFER) {
            sum = chamfer(m, t);
        } else if (t.kind == TRACK) {
            for (u32 i = threadIdx.x; i < t.count; i += THREADS) {
                float3 x = position(m, t.frame, m.target_nodes[t.first + i]);
                sum += point_loss(t, sub(x, load_v3(m.targets + 3 * (u64)(t.first + i))));
            }
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
        } else if (t.kind == ABOVE || t.kind == WITHIN) {
            over = t.loss == ALL_NODES ? m.node_count : t.count;
            for (u32 i = threadIdx.x; i < over; i += THREADS) {
                u32 node = t.loss == ALL_NODES ? i : m.target_nodes[t.first + i];
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
        if (threadIdx.x == 0) m.values[term] = (double)t.weight * (sum / max(over, 1u));
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

// Block (nodes, frame, instance). `score` has found the nearest nodes.
extern "C" __global__ void __launch_bounds__(THREADS) seed(const __grid_constant__ SeedArgs args) {
    __shared__ u32 tile[TILE];
    const ObjectiveArgs& m = args.objectives[blockIdx.z];
    u32 frame = blockIdx.y;
    if (frame > m.frame_count || blockIdx.x * THREADS >= m.node_count) return;
    u32 node = blockIdx.x * THREADS + threadIdx.x;
    bool has = node < m.node_count;
    u32 i = has ? node : 0;
    float3 here = position(m, frame, i);
    float3 sum = zero3();
    bool cut = m.cut_every > 0 && frame > 0 && frame % m.cut_every == 0;
    if (!cut) {
        sum = add(acceleration_seed(m, frame, 1, i), acceleration_seed(m, frame, 2, i));
    }
    for (u32 term = m.frame_terms[frame]; term < m.frame_terms[frame + 1]; term++) {
        const Term t = m.terms[term];
        // Without a surface there is no nearest node.
        if (t.kind == CHAMFER && m.surface_count == 0) continue;
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
        const u32* nodes = t.kind == CHAMFER ? m.nearest : m.target_nodes;
        float w = (t.kind == TRACK ? 1.0f : 2.0f) * t.weight / max(t.count, 1u);
        for (u32 start = 0; start < t.count; start += TILE) {
            u32 size = min((u32)TILE, t.count - start);
            __syncthreads();
            for (u32 k = threadIdx.x; k < size; k += THREADS) tile[k] = nodes[t.first + start + k];
            __syncthreads();
            for (u32 k = 0; k < size; k++) {
                if (tile[k] != node) continue;
                if (region) {
                    sum = add_scaled(sum, w, beyond(t, here));
                    continue;
                }
                float3 d = sub(here, load_v3(m.targets + 3 * (u64)(t.first + start + k)));
                sum = add_scaled(sum, w, t.kind == CHAMFER ? d : point_gradient(t, d));
            }
        }
    }
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
