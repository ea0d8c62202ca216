// Distances of an object's points to their targets, the points being nodes or skin. The nearest point
// of a target counts as fixed in the gradient.

#define TILE 512
// Targets that a block seeks the nearest points of.
#define PIECE (TARGETS_EACH * THREADS)

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

// -d^2 / (2 reach^2) of a coverage.
DEVICE float reach_exponent(const Term& t, float3 d) {
    return -0.5f * dot(d, d) / (t.beta * t.beta);
}

// Number of the points among which a term seeks the nearest.
DEVICE u32 surface_of(const ObjectiveArgs& m, const Term& t) {
    return t.of == SKIN ? m.skin.point_count : m.surface_count;
}

// Sum of squared distances, or uncovered shares, of the thread's targets and their nearest points of the
// surface, EACH of `count` targets from `first` on; ties go to the lower index.
template <u32 EACH>
DEVICE double nearest(const ObjectiveArgs& m, const Term& t, u32 first, u32 count, float4* tile) {
    const Positions p = positions(m, t.frame);
    const u32 surface = surface_of(m, t);
    float3 target[EACH];
    float best[EACH];
    u32 winner[EACH];
#pragma unroll
    for (u32 j = 0; j < EACH; j++) {
        u32 i = j * THREADS + threadIdx.x;
        target[j] = i < count ? load_v3(m.targets + 3 * (u64)(first + i)) : zero3();
        best[j] = 1e30f;
        winner[j] = 0;
    }
    for (u32 start = 0; start < surface; start += TILE) {
        __syncthreads();
        const u32 size = min((u32)TILE, surface - start);
        for (u32 k = threadIdx.x; k < size; k += THREADS)
            tile[k] = with_w(point_at(m, t, p, start + k), 0.0f);
        __syncthreads();
        for (u32 k = 0; k < size; k++) {
            const float3 x = xyz(tile[k]);
#pragma unroll
            for (u32 j = 0; j < EACH; j++) {
                float3 d = sub(x, target[j]);
                float square = dot(d, d);
                if (square < best[j]) {
                    best[j] = square;
                    winner[j] = start + k;
                }
            }
        }
    }
    double sum = 0.0;
#pragma unroll
    for (u32 j = 0; j < EACH; j++) {
        u32 i = j * THREADS + threadIdx.x;
        if (i >= count) continue;
        if (surface == 0) {
            // Nothing is covered.
            if (t.kind == COVERAGE) sum += 1.0;
            continue;
        }
        m.nearest[first + i] = winner[j];
        float3 d = sub(point_at(m, t, p, winner[j]), target[j]);
        sum += t.kind == COVERAGE ? -expm1f(reach_exponent(t, d)) : dot(d, d);
    }
    return sum;
}

// The same for the targets of a piece of a term, with as few for each thread as there are.
DEVICE double nearest(const ObjectiveArgs& m, const Term& t, u32 piece) {
    __shared__ float4 tile[TILE];
    const u32 count = min((u32)PIECE, t.count - piece), first = t.first + piece;
    if (count <= THREADS) return nearest<1>(m, t, first, count, tile);
    if (count <= 2 * THREADS) return nearest<2>(m, t, first, count, tile);
    return nearest<TARGETS_EACH>(m, t, first, count, tile);
}

// Mean loss of a track times their number, of the thread's pairs.
DEVICE double track(const ObjectiveArgs& m, const Term& t) {
    const Positions p = positions(m, t.frame);
    double sum = 0.0;
    for (u32 i = t.first + threadIdx.x; i < t.first + t.count; i += THREADS) {
        float3 x = point_at(m, t, p, m.target_points[i]);
        sum += point_loss(t, sub(x, load_v3(m.targets + 3 * (u64)i)));
    }
    return sum;
}

// Factor of a term's pulls in d loss / d positions.
DEVICE float pull_weight(const ObjectiveArgs& m, const Term& t) {
    if (t.kind == WINDING) return (float)(2.0 * t.weight * turns_beyond(m, t) / TWO_PI);
    if (t.kind == COVERAGE) return t.weight / max(t.count, 1u) / (t.beta * t.beta);
    const u32 over = t.kind == ORDER ? links_of(t) : t.count;
    return (t.kind == TRACK ? 1.0f : 2.0f) * t.weight / max(over, 1u);
}

// What pulls at a point, which is at `here`, because of one of a term's targets or places in a list.
DEVICE float3 pull_of(const ObjectiveArgs& m, const Term& t, u32 place, float3 here) {
    if (t.kind == ABOVE || t.kind == WITHIN) return beyond(t, here);
    if (t.kind == ORDER) return order_pull(m, t, place, here);
    if (t.kind == WINDING) return winding_pull(m, t, place, here);
    const float3 d = sub(here, load_v3(m.targets + 3 * (u64)place));
    if (t.kind == COVERAGE) return scale(d, expf(reach_exponent(t, d)));
    return t.kind == CHAMFER ? d : point_gradient(t, d);
}

// d loss / d position of one of the points that targets, a region or a list have, which is at `here`: of
// point `first` + the thread's index. The block first lists which targets have one of its points, in
// their order.
DEVICE float3 target_seed(const ObjectiveArgs& m, const Term& t, u32 first, float3 here) {
    __shared__ uint2 listed[THREADS];  // thread of the point, target
    __shared__ u32 counts[THREADS / 32];
    const u32 lane = threadIdx.x % 32, warp = threadIdx.x / 32;
    const u32* points = seeks_nearest(t) ? m.nearest : m.target_points;
    const float w = pull_weight(m, t);
    float3 sum = zero3();
    for (u32 base = 0; base < t.count; base += THREADS) {
        const u32 i = base + threadIdx.x;
        // Points before the first wrap around to large numbers.
        const u32 place = i < t.count ? points[t.first + i] - first : THREADS;
        const u32 votes = __ballot_sync(0xffffffffu, place < THREADS);
        if (lane == 0) counts[warp] = __popc(votes);
        __syncthreads();
        u32 before = 0, size = 0;
        for (u32 k = 0; k < THREADS / 32; k++) {
            if (k < warp) before += counts[k];
            size += counts[k];
        }
        if (place < THREADS)
            listed[before + __popc(votes & ((1u << lane) - 1))] = make_uint2(place, t.first + i);
        __syncthreads();
        for (u32 k = 0; k < size; k++) {
            if (listed[k].x != threadIdx.x) continue;
            sum = add_scaled(sum, w, pull_of(m, t, listed[k].y, here));
        }
    }
    return sum;
}
