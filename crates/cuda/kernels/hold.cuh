// Holds: what makes a node follow a control point or a body in a frame. A node that a body holds by
// a pin stands at its place with the place's velocity, as one that is pinned to a control point; a
// spring acts between a node and its place: f = -stiffness (x - place) - damping (v - v_place).

#define REGION_SPHERE 0
#define REGION_BOX 1
#define REGION_NODES 2
#define REGION_CONTROLS 3
#define HOLD_PIN 0
#define HOLD_SPRING 1
#define PHASE_OPEN 0u
#define PHASE_CLOSED 1u
#define PHASE_SLIPPED 2u

#define BY_NOTHING 0
#define BY_CONTROL 1  // pinned to it
#define BY_PIN 2      // to a body
#define BY_SPRING 3

// What holds a node in a frame. `frame` is the frame of the rollout wherever it is asked for.
struct Held {
    u32 by;
    float inverse_mass;
    u32 grasp;
    float3 from, to;  // of the place, at both ends of the frame
    float3 velocity;  // of the place
    float stiffness, damping;
};

// Holds and phases of frames that have not begun when a launch begins are written in it, by one block
// for all.
DEVICE const Hold* holds_of(const InstanceArgs& instance, u32 frame) {
    const WorldArgs& w = instance.world;
    return w.holds + (u64)((frame + 1) % w.slot_count) * instance.topology.node_count;
}

DEVICE Hold load_hold(const Hold* from) {
    float4 packed = __ldcg(reinterpret_cast<const float4*>(from));
    Hold h = {{packed.x, packed.y, packed.z}, __float_as_int(packed.w)};
    return h;
}

// True for a control point that its grasp has released.
DEVICE bool is_released(const InstanceArgs& instance, u32 frame, u32 control) {
    const WorldArgs& w = instance.world;
    if (!w.grasp_of) return false;
    int grasp = w.grasp_of[control];
    return grasp >= 0 &&
           __ldcg(w.phases + (u64)((frame + 1) % w.slot_count) * w.grasp_count + grasp) !=
               PHASE_CLOSED;
}

// True if a control point holds the node in a frame by this pin (-1: none).
DEVICE bool is_pinned_in(const InstanceArgs& instance, u32 frame, int pin) {
    return pin >= 0 && !is_released(instance, frame, instance.topology.pins[pin].control);
}

// What holds a node that has this pin (-1: none); nothing holds a lane without a node.
DEVICE Held
held_of(const InstanceArgs& instance, u32 frame, u32 node, bool valid, int pin) {
    Held h;
    h.by = BY_NOTHING;
    h.inverse_mass = valid ? instance.topology.inverse_mass[node] : 0.0f;
    h.grasp = 0;
    h.from = h.to = h.velocity = zero3();
    h.stiffness = h.damping = 0.0f;
    if (!valid) return h;
    if (pin >= 0) {
        if (!is_released(instance, frame, instance.topology.pins[pin].control)) {
            h.by = BY_CONTROL;
            return h;
        }
        h.inverse_mass = 1.0f / instance.topology.masses[node];
    }
    const Hold hold = load_hold(holds_of(instance, frame) + node);
    if (hold.grasp < 0) return h;
    const Grasp& grasp = instance.world.grasps[hold.grasp];
    BodyFrame body = body_of(instance, frame, grasp.body);
    float3 place = load_v3(hold.place);
    h.grasp = hold.grasp;
    h.from = apply(body.from, place);
    h.to = apply(body.to, place);
    if (instance.step.controls_move) h.velocity = scale(sub(h.to, h.from), body.rate);
    if (grasp.attachment == HOLD_PIN) {
        h.by = BY_PIN;
        h.inverse_mass = 0.0f;
    } else {
        h.by = BY_SPRING;
        h.stiffness = grasp.stiffness;
        h.damping = grasp.damping;
    }
    return h;
}

// Position of the place at a share of the frame; exact at both ends.
DEVICE float3 place_at(const Held& h, float t) {
    return add_scaled(scale(h.from, 1.0f - t), t, h.to);
}

// Inverse mass of a node in a frame; zero where it is held.
DEVICE float inverse_mass_in(const InstanceArgs& instance, u32 frame, u32 node) {
    int pin = instance.topology.pin_of[node];
    if (is_pinned_in(instance, frame, pin)) return 0.0f;
    if (instance.world.grasp_count == 0) return 1.0f / instance.topology.masses[node];
    int grasp = holds_of(instance, frame)[node].grasp;
    if (grasp >= 0 && instance.world.grasps[grasp].attachment == HOLD_PIN) return 0.0f;
    return 1.0f / instance.topology.masses[node];
}

// Velocity of a held node in a frame.
DEVICE float3 held_velocity(const InstanceArgs& instance, u32 frame, u32 node) {
    int pin = instance.topology.pin_of[node];
    if (is_pinned_in(instance, frame, pin))
        return control_velocity(path_of(instance, frame), instance.topology.pins[pin].control);
    return held_of(instance, frame, node, true, pin).velocity;
}

// Adds to the nine components of d loss / d (from, to, velocity); nothing where `sums` is null.
DEVICE void add_path(float* sums, u32 stride, u32 i, float t, float3 x_bar, float3 v_bar) {
    if (!sums) return;
    float from = 1.0f - t;
    sums[0 * stride + i] += from * x_bar.x;
    sums[1 * stride + i] += from * x_bar.y;
    sums[2 * stride + i] += from * x_bar.z;
    sums[3 * stride + i] += t * x_bar.x;
    sums[4 * stride + i] += t * x_bar.y;
    sums[5 * stride + i] += t * x_bar.z;
    sums[6 * stride + i] += v_bar.x;
    sums[7 * stride + i] += v_bar.y;
    sums[8 * stride + i] += v_bar.z;
}
