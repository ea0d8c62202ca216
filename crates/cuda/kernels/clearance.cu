// Clearances of a frame, and their adjoint: one block an instance, in front of the frame and, going
// backward, behind its first substep. Every sum is in a fixed order.

// Farther than any distance that matters [m].
#define ANY_REACH_M 1e30f

// The start of a frame of an instance.
struct FrameStart {
    const InstanceArgs* instance;
    Positions nodes;
    u32 frame;  // of the rollout
    u32 rows;
};

DEVICE FrameStart frame_start_of(const InstanceArgs& instance, u32 frame) {
    FrameStart s;
    s.instance = &instance;
    s.frame = instance.state.first_frame + frame;
    s.nodes.count = instance.topology.node_count;
    s.nodes.x = instance.state.states +
                (u64)(s.frame % instance.state.slot_count) * 6 * instance.topology.node_count;
    s.rows = 1 + instance.world.collider_count;
    return s;
}

// Surface of a collider for a place that does not move.
DEVICE Surface surface_at(const FrameStart& s, const Collider& c, float3 x) {
    BodyFrame body = body_of(*s.instance, s.frame, c.body);
    return surface_of(*s.instance, c, body, body.from, x, zero3(), ANY_REACH_M);
}

// Distance from the surface of a row; zero from a ground that is not there.
DEVICE float distance_at(const FrameStart& s, u32 row, float3 x) {
    if (row == 0) return height(s.instance->step.ground, x);
    return surface_at(s, s.instance->world.colliders[row - 1], x).distance;
}

// d loss / d a place by its distance; sums of poses are those of a node.
DEVICE float3 distance_bar(const FrameStart& s, u32 row, u32 node, float3 x, float bar) {
    if (row == 0) return scale(s.instance->step.ground.normal, bar);
    const Collider& c = s.instance->world.colliders[row - 1];
    BodyFrame body = body_of(*s.instance, s.frame, c.body);
    SurfaceAdjoint by = {bar, zero3(), zero3()};
    return surface_adjoint(
        c, body, 0.0f, surface_at(s, c, x), x, by, body_sums_of(*s.instance, c.body, node)
    );
}

// Adds to d loss / d the place of a node where the frame begins. A node that is held stands where the
// path begins of what holds it, as in `begin_frame_adjoint`: its gradient goes to that path, not to the
// state before the frame.
DEVICE void add_place_bar(const FrameStart& s, u32 node, float3 bar) {
    const InstanceArgs& instance = *s.instance;
    const int pin = instance.topology.pin_of[node];
    if (is_pinned_in(instance, s.frame, pin)) {
        float* sums = instance.adjoint.pin_sums;
        add_path(sums, instance.topology.pin_count, pin, 0.0f, bar, zero3());
    } else if (inverse_mass_in(instance, s.frame, node) == 0.0f) {
        add_path(instance.world.hold_sums, s.nodes.count, node, 0.0f, bar, zero3());
    } else {
        float4* to = instance.adjoint.bar_x + node;
        *to = with_w(add(xyz(*to), bar), 0.0f);
    }
}

struct FindClearancesArgs {
    const InstanceArgs* instances;
    u32 frame;
    u32 pad;
};

extern "C" __global__ void __launch_bounds__(THREADS)
find_clearances(const __grid_constant__ FindClearancesArgs args) {
    const InstanceArgs& instance = args.instances[blockIdx.x];
    if (args.frame >= instance.state.frame_count) return;
    const FrameStart s = frame_start_of(instance, args.frame);
    const ClearanceArgs& c = instance.clearance;
    const SkinArgs& skin = c.skin;
    const u32 n = s.nodes.count, m = skin.point_count;
    for (u32 p = threadIdx.x; p < m; p += THREADS) {
        float3 x = skin_at(skin, s.nodes, p);
        c.places[p] = x.x;
        c.places[m + p] = x.y;
        c.places[2 * m + p] = x.z;
    }
    __syncthreads();
    const Positions points = {c.places, m};
    for (u32 i = threadIdx.x; i < n; i += THREADS) {
        const float3 x = node_at(s.nodes, i);
        for (u32 row = 0; row < s.rows; row++) {
            const float own = distance_at(s, row, x);
            float most = 0.0f;
            u32 decides = NO_POINT;
            for (u32 k = skin.borne_starts[i]; k < skin.borne_starts[i + 1]; k++) {
                const u32 p = skin.borne[k];
                const float clearance = own - distance_at(s, row, node_at(points, p));
                if (clearance > most) {
                    most = clearance;
                    decides = p;
                }
            }
            c.distances[(u64)row * n + i] = most;
            c.points[(u64)row * n + i] = decides;
        }
    }
}

// True if a point names the node at place `k` of the weights more than once, and here not first.
DEVICE bool is_repeated(const SkinArgs& skin, u32 point, u32 k) {
    for (u32 j = skin.starts[point]; j < k; j++)
        if (skin.nodes[j] == skin.nodes[k]) return true;
    return false;
}

struct ClearanceAdjointArgs {
    const InstanceArgs* instances;
};

// Adds to d loss / d positions where frame `StateArgs::first_frame` begins, to that of what holds
// nodes there, and to that of the poses of bodies, what comes from its clearances; d loss / d these
// are zero then.
extern "C" __global__ void __launch_bounds__(THREADS)
clearance_adjoint(const __grid_constant__ ClearanceAdjointArgs args) {
    const InstanceArgs& instance = args.instances[blockIdx.x];
    const FrameStart s = frame_start_of(instance, 0);
    const ClearanceArgs& c = instance.clearance;
    const SkinArgs& skin = c.skin;
    const u32 n = s.nodes.count, m = skin.point_count;
    for (u32 i = threadIdx.x; i < n; i += THREADS) {
        float3 sum = zero3();
        for (u32 row = 0; row < s.rows; row++) {
            const u64 at = (u64)row * n + i;
            const float bar = c.bars[at];
            const u32 p = c.points[at];
            float3 by_point = zero3();
            if (bar != 0.0f && p != NO_POINT) {
                sum = add(sum, distance_bar(s, row, i, node_at(s.nodes, i), bar));
                by_point = distance_bar(s, row, i, skin_at(skin, s.nodes, p), -bar);
            }
            c.by_points[at] = with_w(by_point, 0.0f);
            c.bars[at] = 0.0f;
        }
        add_place_bar(s, i, sum);
    }
    __syncthreads();
    for (u32 p = threadIdx.x; p < m; p += THREADS) {
        float3 sum = zero3();
        for (u32 k = skin.starts[p]; k < skin.starts[p + 1]; k++) {
            if (is_repeated(skin, p, k)) continue;
            for (u32 row = 0; row < s.rows; row++) {
                const u64 at = (u64)row * n + skin.nodes[k];
                if (c.points[at] == p) sum = add(sum, xyz(c.by_points[at]));
            }
        }
        c.places[p] = sum.x;
        c.places[m + p] = sum.y;
        c.places[2 * m + p] = sum.z;
    }
    __syncthreads();
    for (u32 i = threadIdx.x; i < n; i += THREADS) {
        add_place_bar(s, i, carried_bar(skin, s.nodes, c.places, i));
    }
}
