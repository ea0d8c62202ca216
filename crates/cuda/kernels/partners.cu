// Contact candidates: for each node, the nodes that it may touch during a frame, through a hash
// grid; once a frame, one block an instance. Everything is placed in a fixed order, so that
// impulses are summed in one.

#define CELLS 4096
#define SCAN (CELLS / THREADS)

struct Search {
    const InstanceArgs* instance;
    const float* state;
    Path path;
    float radius;
    u32 frame;  // of the rollout
};

// What holds a node: nothing, unless a control point pins it or a grasp holds it by a pin.
DEVICE Held held_of(const Search& s, u32 node) {
    const InstanceArgs& instance = *s.instance;
    int pin = instance.topology.pin_of[node];
    Held h;
    h.by = pin >= 0 ? BY_CONTROL : BY_NOTHING;
    if (instance.world.grasp_count > 0) h = held_of(instance, s.frame, node, true, pin);
    return h;
}

DEVICE float3 position(const Search& s, u32 node) {
    const TopologyArgs& t = s.instance->topology;
    Held h = held_of(s, node);
    if (h.by == BY_CONTROL) {
        Pin p = t.pins[t.pin_of[node]];
        return add(load_v3(s.path.from + 3 * p.control), load_v3(p.offset));
    }
    if (h.by == BY_PIN) return h.from;
    u32 n = t.node_count;
    return v3(s.state[node], s.state[n + node], s.state[2 * n + node]);
}

DEVICE float square_speed(const Search& s, u32 node) {
    const TopologyArgs& t = s.instance->topology;
    Held h = held_of(s, node);
    if (h.by == BY_CONTROL) {
        float3 v = control_velocity(s.path, t.pins[t.pin_of[node]].control);
        return dot(v, v);
    }
    if (h.by == BY_PIN) return dot(h.velocity, h.velocity);
    u32 n = t.node_count;
    float3 v = v3(s.state[3 * n + node], s.state[4 * n + node], s.state[5 * n + node]);
    return dot(v, v);
}

// Far or non-finite nodes share the outermost cells.
DEVICE int cell_index(float x, float radius) {
    return (int)fminf(fmaxf(floorf(x / radius), -1e6f), 1e6f);
}
DEVICE u32 bucket(int x, int y, int z) {
    return ((u32)x * 73856093u ^ (u32)y * 19349663u ^ (u32)z * 83492791u) % CELLS;
}
DEVICE u32 bucket_of(const Search& s, u32 node) {
    float3 x = position(s, node);
    return bucket(cell_index(x.x, s.radius), cell_index(x.y, s.radius), cell_index(x.z, s.radius));
}

DEVICE bool can_collide(const InstanceArgs& instance, u32 a, u32 b) {
    if (a == b) return false;
    if (instance.contact.object_ids[a] != instance.contact.object_ids[b])
        return instance.contact.between_objects != 0;
    if (!instance.contact.within_object) return false;
    u32 low = instance.contact.neighbour_starts[a], high = instance.contact.neighbour_starts[a + 1];
    while (low < high) {
        u32 middle = (low + high) / 2;
        if (instance.contact.neighbours[middle] < b) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low == instance.contact.neighbour_starts[a + 1] || instance.contact.neighbours[low] != b;
}

// A warp goes through the nodes around `node`; writes those within `limit` to `to` unless it is
// null, and returns how many there are.
DEVICE u32 collect_near(const Search& s, const u32* starts, u32 node, float limit, u32* to) {
    u32 lane = threadIdx.x % 32;
    float3 here = position(s, node);
    u32 mine = CELLS + lane;
    if (lane < 27) {
        int x = cell_index(here.x, s.radius) + (int)(lane % 3) - 1;
        int y = cell_index(here.y, s.radius) + (int)(lane / 3 % 3) - 1;
        int z = cell_index(here.z, s.radius) + (int)(lane / 9) - 1;
        mine = bucket(x, y, z);
    }
    // Two cells may share a bucket: it is gone through once.
    bool first = (__match_any_sync(0xffffffffu, mine) & ((1u << lane) - 1)) == 0;
    u32 found = 0;
    for (u32 cell = 0; cell < 27; cell++) {
        if (!__shfl_sync(0xffffffffu, (int)first, cell)) continue;
        u32 b = __shfl_sync(0xffffffffu, mine, cell);
        for (u32 i = starts[b]; i < starts[b + 1]; i += 32) {
            u32 other =
                i + lane < starts[b + 1] ? s.instance->contact.partner_scratch[i + lane] : node;
            float3 r = sub(position(s, other), here);
            bool near =
                other != node && dot(r, r) <= limit && can_collide(*s.instance, node, other);
            u32 hits = __ballot_sync(0xffffffffu, near);
            u32 slot = found + __popc(hits & ((1u << lane) - 1));
            // Nodes beyond the capacity of a place are left out, however near.
            if (near && to && slot < s.instance->contact.max_partners) to[slot] = other;
            found += __popc(hits);
        }
    }
    return found;
}

struct FindPartnersArgs {
    const InstanceArgs* instances;
    u32 frame;
    u32 pad;
};

extern "C" __global__ void __launch_bounds__(THREADS)
find_partners(const __grid_constant__ FindPartnersArgs args) {
    __shared__ u32 starts[CELLS + 1];
    __shared__ u32 cursors[CELLS];
    __shared__ float fastest[THREADS / 32];
    const InstanceArgs& instance = args.instances[blockIdx.x];
    const u32 frame = args.frame;
    if (frame >= instance.state.frame_count) return;
    const u32 n = instance.topology.node_count;
    Search s;
    s.instance = &instance;
    s.state = instance.state.states +
              (u64)((instance.state.first_frame + frame) % instance.state.slot_count) * 6 * n;
    s.frame = instance.state.first_frame + frame;
    s.path = path_of(instance, s.frame);

    float fast = 0.0f;
    for (u32 i = threadIdx.x; i < n; i += THREADS) fast = fmaxf(fast, square_speed(s, i));
    for (int mask = 16; mask > 0; mask /= 2)
        fast = fmaxf(fast, __shfl_xor_sync(0xffffffffu, fast, mask));
    if (threadIdx.x % 32 == 0) fastest[threadIdx.x / 32] = fast;
    for (u32 i = threadIdx.x; i < CELLS; i += THREADS) cursors[i] = 0;
    __syncthreads();
    for (u32 w = 0; w < THREADS / 32; w++) fast = fmaxf(fast, fastest[w]);
    // Distance that the fastest two can close within the frame, at least once and at most four
    // times the distance.
    float d = instance.contact.collision_distance;
    float closing = 2.0f * sqrtf(fast) * instance.step.frame_s;
    s.radius = d + fminf(fmaxf(closing, d), 4.0f * d);

    for (u32 i = threadIdx.x; i < n; i += THREADS) atomicAdd(cursors + bucket_of(s, i), 1u);
    __syncthreads();
    if (threadIdx.x < 32) {
        u32 before = 0;
        for (u32 base = 0; base < CELLS; base += 32) {
            u32 count = cursors[base + threadIdx.x], sum = count;
            for (u32 up = 1; up < 32; up *= 2) {
                u32 left = __shfl_up_sync(0xffffffffu, sum, up);
                if (threadIdx.x >= up) sum += left;
            }
            starts[base + threadIdx.x] = cursors[base + threadIdx.x] = before + sum - count;
            before += __shfl_sync(0xffffffffu, sum, 31);
        }
        if (threadIdx.x == 0) starts[CELLS] = before;
        __syncwarp();
        // Ascending within a cell.
        for (u32 base = 0; base < n; base += 32) {
            u32 node = base + threadIdx.x;
            u32 b = node < n ? bucket_of(s, node) : CELLS;
            u32 same = __match_any_sync(0xffffffffu, b);
            u32 rank = __popc(same & ((1u << threadIdx.x) - 1));
            u32 at = node < n ? cursors[b] + rank : 0;
            if (node < n) instance.contact.partner_scratch[at] = node;
            __syncwarp();
            if (node < n && rank == 0) cursors[b] += __popc(same);
            __syncwarp();
        }
    }
    __syncthreads();

    for (u32 node = threadIdx.x / 32; node < n; node += THREADS / 32) {
        u32* to = instance.contact.partners + (u64)node * instance.contact.max_partners;
        float high = s.radius * s.radius;
        u32 found = collect_near(s, starts, node, high, 0);
        if (found > instance.contact.max_partners) {
            // An object has collapsed: keep as many of the nearest as fit.
            float low = 0.0f;
            for (u32 step = 0; step < 24; step++) {
                float middle = 0.5f * (low + high);
                if (collect_near(s, starts, node, middle, 0) > instance.contact.max_partners) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            high = low;
        }
        found = collect_near(s, starts, node, high, to);
        if (threadIdx.x % 32 == 0)
            instance.contact.partner_counts[node] = min(found, instance.contact.max_partners);
    }
}
