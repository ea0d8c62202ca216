// Rigid bodies in one frame: the entries of a pose are interpolated linearly, so that a point `o` of
// a body is at A(t) o + p(t) with A(t) = (1 - t) A0 + t A1, and has a constant velocity.

#define NO_BODY 0xffffffffu

// Rows of [A | p].
struct Pose {
    float4 x, y, z;
};

DEVICE Pose load_pose(const float4* from) {
    Pose p = {from[0], from[1], from[2]};
    return p;
}
DEVICE Pose identity() {
    Pose p = {
        make_float4(1.0f, 0.0f, 0.0f, 0.0f), make_float4(0.0f, 1.0f, 0.0f, 0.0f),
        make_float4(0.0f, 0.0f, 1.0f, 0.0f)
    };
    return p;
}
// A o.
DEVICE float3 turn(const Pose& p, float3 o) {
    return v3(dot(xyz(p.x), o), dot(xyz(p.y), o), dot(xyz(p.z), o));
}
DEVICE float3 origin(const Pose& p) { return v3(p.x.w, p.y.w, p.z.w); }
// A o + p.
DEVICE float3 apply(const Pose& p, float3 o) { return add(turn(p, o), origin(p)); }
// Transposed A times x.
DEVICE float3 turn_back(const Pose& p, float3 x) {
    return add_scaled(add_scaled(scale(xyz(p.x), x.x), x.y, xyz(p.y)), x.z, xyz(p.z));
}
// The coordinates of a point of the world in the body, as far as A is a rotation.
DEVICE float3 into_body(const Pose& p, float3 x) { return turn_back(p, sub(x, origin(p))); }

// A body during a frame.
struct BodyFrame {
    Pose from, to;
    float rate;  // 1 / the frame's length [1/s]
};

// Boundary at which a frame ends; an instance without frames stands still.
DEVICE u32 end_of(const InstanceArgs& instance, u32 frame) {
    return frame < instance.state.first_frame + instance.state.frame_count ? frame + 1 : frame;
}

DEVICE BodyFrame body_of(const InstanceArgs& instance, u32 frame, u32 body) {
    BodyFrame b;
    if (body == NO_BODY) {
        b.from = b.to = identity();
        b.rate = 0.0f;
        return b;
    }
    u32 count = instance.world.body_count;
    b.from = load_pose(instance.world.poses + ((u64)frame * count + body) * 3);
    b.to = load_pose(instance.world.poses + ((u64)end_of(instance, frame) * count + body) * 3);
    b.rate = 1.0f / instance.step.frame_s;
    return b;
}
DEVICE float4 between(float4 a, float4 b, float t) {
    return with_w(
        add_scaled(scale(xyz(a), 1.0f - t), t, xyz(b)), fmaf(t, b.w, a.w * (1.0f - t))
    );
}
// The pose at a share of the frame; exact at both ends.
DEVICE Pose pose_at(const BodyFrame& b, float t) {
    Pose p = {
        between(b.from.x, b.to.x, t), between(b.from.y, b.to.y, t), between(b.from.z, b.to.z, t)
    };
    return p;
}
// Velocity of a point of the body.
DEVICE float3 body_velocity(const BodyFrame& b, float3 o) {
    return scale(sub(apply(b.to, o), apply(b.from, o)), b.rate);
}
