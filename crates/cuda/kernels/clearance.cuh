// Contact of the skin: in a frame a node meets a surface at the distance at which the skin that it
// bears does where the frame begins (`cpu/collision/clearance.rs`). Row 0 is the ground, row 1 + k collider k.

#define NO_POINT 0xffffffffu

DEVICE float clearance_of(const InstanceArgs& instance, u32 row, u32 node) {
#if SKIN_CONTACT
    return __ldg(instance.clearance.distances + (u64)row * instance.topology.node_count + node);
#else
    return 0.0f;
#endif
}

// Adds to d loss / d a clearance, by one thread for a node.
DEVICE void add_clearance_bar(const InstanceArgs& instance, u32 row, u32 node, float bar) {
#if SKIN_CONTACT
    instance.clearance.bars[(u64)row * instance.topology.node_count + node] += bar;
#endif
}

// The ground for a node.
DEVICE Ground ground_for(const InstanceArgs& instance, Ground g, u32 node) {
    g.offset += clearance_of(instance, 0, node);
    return g;
}
