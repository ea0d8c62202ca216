//! Requests for pictures.

use bendtwin_proto::v1::{
    Capsule, ConvexMesh, Cuboid, Light, PictureCamera, Prop, RenderSessionRequest, Sphere, Tensor,
    prop::Shape, tensor::Dtype,
};
use bytes::Bytes;

/// A malformed request.
#[derive(Clone, Debug)]
pub struct Case {
    /// The fault in a few words.
    pub what: &'static str,
    /// Text of the message: the field, or the limit.
    pub names: &'static str,
    /// The request; its session and slots are left to the caller.
    pub request: RenderSessionRequest,
}

/// No rotation, at the origin.
const POSE: [f32; 7] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// A camera at the origin, 16 x 12.
pub fn camera() -> PictureCamera {
    PictureCamera {
        width: 16,
        height: 12,
        intrinsics: Some(Tensor::pack(&[4], &[12.0_f32, 12.0, 7.5, 5.5])),
        pose: Some(Tensor::pack(&[7], &POSE)),
        ..PictureCamera::default()
    }
}

/// A prop of each shape.
pub fn props() -> Vec<Prop> {
    let points: Vec<[f32; 3]> = vec![[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
    let shapes = [
        Shape::Sphere(Sphere { center: Vec::new(), radius_m: 0.1 }),
        Shape::Capsule(Capsule { from: vec![0.0; 3], to: vec![0.1; 3], radius_m: 0.02 }),
        Shape::Cuboid(Cuboid { low: vec![-0.1; 3], high: vec![0.1; 3] }),
        Shape::ConvexMesh(ConvexMesh { points: Some(Tensor::pack_points(&[4], &points)) }),
    ];
    shapes.map(|shape| Prop { shape: Some(shape), ..Prop::default() }).to_vec()
}

/// A request with a camera, all props, and a light.
pub fn sound() -> RenderSessionRequest {
    let one = |x: f32| Some(Tensor::pack(&[1], &[x]));
    let light = Light {
        direction: Some(Tensor::pack(&[3], &[0.0_f32, 0.5, 1.0])),
        ambient: one(0.3),
        brightness: one(1.5),
    };
    RenderSessionRequest {
        cameras: vec![camera()],
        props: props(),
        light: Some(light),
        depths: true,
        labels: true,
        ..RenderSessionRequest::default()
    }
}

/// Requests with one fault each, for any number of slots but 5.
pub fn malformed() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |what, names, request| cases.push(Case { what, names, request });
    let good = sound();
    add("no camera", "`cameras`", RenderSessionRequest { cameras: Vec::new(), ..good.clone() });
    let nine = vec![camera(); 9];
    add("nine cameras", "`cameras`", RenderSessionRequest { cameras: nine, ..good.clone() });
    add("an unknown look", "`look`", RenderSessionRequest { look: 77, ..good.clone() });
    for (what, names, camera) in cameras() {
        add(what, names, RenderSessionRequest { cameras: vec![camera], ..good.clone() });
    }
    let many = vec![props()[0].clone(); 65];
    add("65 props", "`props`", RenderSessionRequest { props: many, ..good.clone() });
    for (what, names, prop) in wrong_props() {
        add(what, names, RenderSessionRequest { props: vec![prop], ..good.clone() });
    }
    let lit = |light: Light| RenderSessionRequest { light: Some(light), ..good.clone() };
    let floats = |shape: &[usize], x: f32| {
        Some(Tensor::pack(shape, &vec![x; shape.iter().product::<usize>()]))
    };
    let direction = "`light.direction`";
    for (what, tensor) in [
        ("a light from nowhere", floats(&[3], 0.0)),
        ("a light of two numbers", floats(&[2], 1.0)),
        ("a light that is no number", floats(&[3], f32::NAN)),
        ("lights of five slots", floats(&[5, 3], 1.0)),
    ] {
        add(what, direction, lit(Light { direction: tensor, ..Light::default() }));
    }
    for (what, x) in
        [("a negative share", -0.1), ("a share above one", 1.1), ("no share", f32::NAN)]
    {
        add(what, "`light.ambient`", lit(Light { ambient: floats(&[1], x), ..Light::default() }));
    }
    let bright = lit(Light { brightness: floats(&[1], 4.5), ..Light::default() });
    add("a blinding light", "`light.brightness`", bright);
    let shares = lit(Light { brightness: floats(&[5], 1.0), ..Light::default() });
    add("brightness of five slots", "`light.brightness`", shares);
    cases
}

fn cameras() -> Vec<(&'static str, &'static str, PictureCamera)> {
    const INTRINSICS: &str = "`cameras[0].intrinsics`";
    const POSE_FIELD: &str = "`cameras[0].pose`";
    const BACKGROUND: &str = "`cameras[0].background`";
    let good = camera();
    let intrinsics = |values: [f32; 4]| PictureCamera {
        intrinsics: Some(Tensor::pack(&[4], &values)),
        ..good.clone()
    };
    let posed = |pose: Tensor| PictureCamera { pose: Some(pose), ..good.clone() };
    let at = |k: usize, x: f32| {
        let mut pose = POSE;
        pose[k] = x;
        posed(Tensor::pack(&[7], &pose))
    };
    let behind =
        |background: Tensor| PictureCamera { background: Some(background), ..good.clone() };
    let bytes = |shape: &[usize]| Tensor::pack(shape, &vec![0_u8; shape.iter().product::<usize>()]);
    let claimed = Tensor {
        dtype: Dtype::Uint8.into(),
        shape: vec![1_000_000_000, 12, 16, 3],
        data: Bytes::from_static(&[0; 24]),
        ..Tensor::default()
    };
    vec![
        ("a narrow picture", "`cameras[0].width`", PictureCamera { width: 7, ..good.clone() }),
        ("a high picture", "`cameras[0].height`", PictureCamera { height: 2049, ..good.clone() }),
        (
            "a long name",
            "`cameras[0].name`",
            PictureCamera { name: "n".repeat(200), ..good.clone() },
        ),
        ("no intrinsics", INTRINSICS, PictureCamera { intrinsics: None, ..good.clone() }),
        ("a focal length of zero", INTRINSICS, intrinsics([0.0, 12.0, 7.5, 5.5])),
        ("a negative focal length", INTRINSICS, intrinsics([12.0, -12.0, 7.5, 5.5])),
        (
            "a principal point that is no number",
            INTRINSICS,
            intrinsics([12.0, 12.0, f32::NAN, 5.5]),
        ),
        ("an infinite focal length", INTRINSICS, intrinsics([f32::INFINITY, 12.0, 7.5, 5.5])),
        ("no pose", POSE_FIELD, PictureCamera { pose: None, ..good.clone() }),
        ("a place that is no number", POSE_FIELD, at(0, f32::NAN)),
        ("a place in millimetres", POSE_FIELD, at(1, 2_500.0)),
        ("a rotation of length zero", POSE_FIELD, at(6, 0.0)),
        ("poses of five slots", POSE_FIELD, posed(Tensor::pack(&[5, 7], &POSE.repeat(5)))),
        ("a pose of double precision", POSE_FIELD, posed(Tensor::pack(&[7], &POSE.map(f64::from)))),
        ("a background of another size", BACKGROUND, behind(bytes(&[16, 12, 3]))),
        ("backgrounds of five slots", BACKGROUND, behind(bytes(&[5, 12, 16, 3]))),
        ("a background of floats", BACKGROUND, behind(Tensor::pack(&[3], &[0.0_f32; 3]))),
        ("10^9 backgrounds that are not there", BACKGROUND, behind(claimed)),
    ]
}

fn wrong_props() -> Vec<(&'static str, &'static str, Prop)> {
    let good = props()[0].clone();
    let shaped = |shape: Shape| Prop { shape: Some(shape), ..Prop::default() };
    let flat = Tensor::pack(&[2, 3], &[0.0_f32; 6]);
    let unturned = Some(Tensor::pack(&[7], &[0.0_f32; 7]));
    let color = Some(Tensor::pack(&[4], &[0_u8; 4]));
    vec![
        ("a prop without shape", "`props[0].shape`", Prop::default()),
        (
            "a sphere without radius",
            "`props[0].sphere.radius_m`",
            shaped(Shape::Sphere(Sphere::default())),
        ),
        (
            "a capsule without ends",
            "`props[0].capsule.from`",
            shaped(Shape::Capsule(Capsule::default())),
        ),
        (
            "a cuboid that is inside out",
            "`props[0].cuboid.low`",
            shaped(Shape::Cuboid(Cuboid { low: vec![0.1; 3], high: vec![0.0; 3] })),
        ),
        (
            "a mesh of two points",
            "`props[0].convex_mesh.points`",
            shaped(Shape::ConvexMesh(ConvexMesh { points: Some(flat) })),
        ),
        ("a prop without a rotation", "`props[0].pose`", Prop { pose: unturned, ..good.clone() }),
        ("a prop of four colours", "`props[0].color`", Prop { color, ..good }),
    ]
}
