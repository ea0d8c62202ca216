// Impulses by what surrounds an object, added up by node over a frame (`measure.cuh` adds up the
// nodes). Moments are about the origin of the body where it is at the frame's end.

#define IMPULSE_GROUND 0
#define IMPULSE_HOLD 3
#define IMPULSE_CONTROL 9
#define IMPULSES 15  // then six for each collider

DEVICE float3 origin_of(const InstanceArgs& instance, u32 frame, u32 body) {
    if (body == NO_BODY) return zero3();
    u64 at = ((u64)end_of(instance, frame) * instance.world.body_count + body) * 3;
    const float4* p = instance.world.poses + at;
    return v3(p[0].w, p[1].w, p[2].w);
}

// Body of the grasp that a control point belongs to.
DEVICE u32 body_of_control(const InstanceArgs& instance, u32 control) {
    const WorldArgs& w = instance.world;
    int grasp = w.grasp_of ? w.grasp_of[control] : -1;
    return grasp >= 0 ? w.grasps[grasp].body : NO_BODY;
}

DEVICE void add_impulse(float* to, u64 stride, float3 by) {
    to[0] += by.x;
    to[stride] += by.y;
    to[2 * stride] += by.z;
}

DEVICE void add_wrench(float* to, u64 stride, float3 arm, float3 by) {
    add_impulse(to, stride, by);
    add_impulse(to + 3 * stride, stride, cross(arm, by));
}

// Adds an impulse on a node that acts at `at` to those of a kind.
DEVICE void add_node_impulse(
    const InstanceArgs& instance, u32 frame, u32 node, u32 kind, u32 body, float3 at, float3 by
) {
    u64 n = instance.topology.node_count;
    float* to = instance.world.impulses + kind * n + node;
    if (kind == IMPULSE_GROUND) {
        add_impulse(to, n, by);
    } else {
        add_wrench(to, n, sub(at, origin_of(instance, frame, body)), by);
    }
}
