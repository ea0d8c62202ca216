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
#define ALL_NODES 1
#define SMOOTH_L1 0
#define DISTANCE 1
#define SQUARED_DISTANCE 2

struct Term {
    u32 kind, frame;
    u32 count;   // targets, or nodes of a region
    u32 first;   // first of them
    u32 loss;    // of a region: ALL_NODES, or 0 for those counted
    float beta;  // limit of a strain, offset of a half space
    float weight;
    u32 unused;
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
    u32 unused;
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
