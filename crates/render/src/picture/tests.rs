use bendtwin_core::{Skin, Surface};
use bendtwin_splat::{Cpu, Gaussians, Rasteriser as _};
use proptest::prelude::*;

use super::*;
use crate::{
    mesh::Mesh,
    solid::{Face, Pose, Solid},
};

const LIGHT: Light = Light { direction: [0.0, 0.0, -1.0], ambient: 0.4, brightness: 1.0 };
const ALL: Wanted = Wanted { depths: true, labels: true };
const GREY: Background<'_> = Background::Color([90, 91, 92]);

/// A camera at the origin that looks along z.
fn camera(width: u32, height: u32, focal: f32) -> Camera {
    let [cx, cy] = [width, height].map(|n| (n - 1) as f32 / 2.0);
    let world_to_camera = Pose::default().world_to_camera();
    Camera { width, height, fx: focal, fy: focal, cx, cy, world_to_camera }
}

fn ball(center: Point, radius_m: f32) -> Solid {
    Solid::Round { from: center, to: center, radius_m }
}

fn cuboid(low: Point, high: Point) -> Solid {
    let face = |axis: usize, sign: f32, offset_m: f32| {
        let mut normal = [0.0; 3];
        normal[axis] = sign;
        Face { normal, offset_m }
    };
    let faces = (0..3).flat_map(|i| [face(i, -1.0, -low[i]), face(i, 1.0, high[i])]).collect();
    Solid::Convex { faces, bounds: [low, high] }
}

fn prop(solid: &Solid, color: [u8; 3]) -> Prop<'_> {
    Prop { solid, pose: Pose::default(), color }
}

/// A picture of props alone.
fn of_props(camera: &Camera, props: &[Prop<'_>], background: Background<'_>) -> Picture {
    let nothing = Mesh::new(Surface::default(), &[]);
    let posed = nothing.at(&[], &LIGHT);
    let object = Object::Surface(&posed);
    let scene = Scene { camera, object, props, light: &LIGHT, background };
    draw(&scene, ALL, &|| false).unwrap()
}

/// A picture of a mesh and props.
fn of_mesh(camera: &Camera, mesh: &Mesh, nodes: &[Point], props: &[Prop<'_>]) -> Picture {
    let posed = mesh.at(nodes, &LIGHT);
    let object = Object::Surface(&posed);
    let scene = Scene { camera, object, props, light: &LIGHT, background: GREY };
    draw(&scene, ALL, &|| false).unwrap()
}

fn count(picture: &Picture, label: u8) -> usize {
    picture.labels.iter().filter(|l| **l == label).count()
}

/// A mesh whose vertices are nodes.
fn mesh_of(count: usize, triangles: Vec<[u32; 3]>) -> Mesh {
    let nodes: Vec<u32> = (0..count as u32).collect();
    let surface = Surface { carriers: Skin::at_nodes(&nodes), triangles, ..Surface::default() };
    Mesh::new(surface, &vec![[200, 40, 40]; count])
}

/// The corners of a box and its triangles, counter-clockwise seen from outside.
fn box_mesh(low: Point, high: Point) -> (Mesh, Vec<Point>) {
    let corner = |k: usize| [0, 1, 2].map(|a| if k >> a & 1 == 0 { low[a] } else { high[a] });
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    (mesh_of(8, triangles), (0..8).map(corner).collect())
}

#[test]
fn a_ball_has_the_area_the_middle_and_the_depth_of_its_projection() {
    let (distance, radius, focal) = (2.0, 0.5, 200.0);
    let camera = camera(240, 200, focal);
    let shape = ball([0.0, 0.0, distance], radius);
    let picture = of_props(&camera, &[prop(&shape, [250, 250, 250])], GREY);
    // The cone that touches it: tan² = r² / (d² - r²).
    let outline = focal * radius / (distance * distance - radius * radius).sqrt();
    let area = f64::from(std::f32::consts::PI * outline * outline);
    let seen = count(&picture, 2) as f64;
    // A pixel that is half covered counts.
    assert!((seen / area - 1.0).abs() < 0.01, "{seen} of {area}");
    let places = (0..picture.labels.len()).filter(|i| picture.labels[*i] == 2);
    let sum = places.fold([0.0; 2], |[x, y], i| [x + (i % 240) as f64, y + (i / 240) as f64]);
    let middle = sum.map(|s| s / seen);
    assert!((middle[0] - 119.5).abs() < 0.05 && (middle[1] - 99.5).abs() < 0.05, "{middle:?}");
    let depth = picture.depths[100 * 240 + 120];
    assert!((depth - 1.5).abs() < 1e-4, "{depth}");
}

#[test]
fn a_ball_beside_the_axis_fills_the_ellipse_of_its_cone() {
    let focal = 150.0;
    let camera = camera(400, 200, focal);
    let (center, radius) = ([1.2, 0.0, 1.5], 0.3);
    let picture = of_props(&camera, &[prop(&ball(center, radius), [9; 3])], GREY);
    // Along x it reaches from one tangent to the other.
    let [x, z] = [center[0], center[2]];
    let (middle, half) = (x.atan2(z), (radius / x.hypot(z)).asin());
    let ends = [middle - half, middle + half].map(|angle: f32| focal * angle.tan() + camera.cx);
    let row = &picture.labels[100 * 400..101 * 400];
    let first = row.iter().position(|l| *l == 2).unwrap() as f32;
    let last = row.iter().rposition(|l| *l == 2).unwrap() as f32;
    assert!(
        (first - ends[0]).abs() < 1.0 && (last - ends[1]).abs() < 1.0,
        "{first} {last} {ends:?}"
    );
}

#[test]
fn a_capsule_is_a_ball_at_its_ends_and_a_band_between_them() {
    let camera = camera(200, 100, 100.0);
    let shape = Solid::Round { from: [-0.4, 0.0, 1.0], to: [0.4, 0.0, 1.0], radius_m: 0.1 };
    let picture = of_props(&camera, &[prop(&shape, [9; 3])], GREY);
    let outline = 100.0 * 0.1 / (1.0_f32 - 0.01).sqrt();
    let column = |x: usize| (0..100).filter(|y| picture.labels[y * 200 + x] == 2).count() as f32;
    assert!((column(100) - 2.0 * outline).abs() <= 1.0, "{}", column(100));
    let row = picture.labels[50 * 200..51 * 200].iter().filter(|l| **l == 2).count() as f32;
    // The ends are seen from the side: tangents of balls at 0.4 m from the axis.
    let angle = 0.4_f32.atan2(1.0) + (0.1 / 1.16_f32.sqrt()).asin();
    assert!((row - 200.0 * angle.tan()).abs() <= 2.0, "{row} {}", 200.0 * angle.tan());
    assert!((picture.depths[50 * 200 + 100] - 0.9).abs() < 1e-3);
    // Seen along its axis it is the nearer ball.
    let along = Solid::Round { from: [0.0, 0.0, 1.0], to: [0.0, 0.0, 3.0], radius_m: 0.1 };
    let picture = of_props(&camera, &[prop(&along, [9; 3])], GREY);
    assert!((picture.depths[50 * 200 + 100] - 0.9).abs() < 1e-3);
}

#[test]
fn faces_of_a_box_have_the_depths_of_their_planes() {
    let camera = camera(120, 80, 60.0);
    let shape = cuboid([-1.0, -0.5, 2.0], [1.0, 0.5, 3.0]);
    let picture = of_props(&camera, &[prop(&shape, [9; 3])], GREY);
    assert!((picture.depths[40 * 120 + 60] - 2.0).abs() < 1e-5);
    assert_eq!(count(&picture, 2), 60 * 30);
    // A ground 0.5 below the camera: its depth follows from the row.
    let ground = cuboid([-50.0, 0.5, -50.0], [50.0, 0.6, 50.0]);
    let picture = of_props(&camera, &[prop(&ground, [9; 3])], GREY);
    for row in [45, 60, 79] {
        let expected = 0.5 * 60.0 / (row as f32 - camera.cy);
        let depth = picture.depths[row * 120 + 33];
        assert!((depth / expected - 1.0).abs() < 1e-4, "row {row}: {depth}, not {expected}");
    }
    assert!(picture.labels[..39 * 120].iter().all(|l| *l == 0), "nothing above the horizon");
}

#[test]
fn points_are_seen_where_perspective_puts_them() {
    // From (1, 2, 3), turned a quarter about the vertical axis of the world.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let pose = Pose::new([1.0, 2.0, 3.0, 0.0, half, 0.0, half]);
    let camera = Camera {
        fx: 80.0,
        fy: 90.0,
        cx: 40.0,
        cy: 21.0,
        world_to_camera: pose.world_to_camera(),
        ..camera(100, 60, 1.0)
    };
    // The camera looks along x of the world, with z of the world to its left.
    for [x, y, z] in [[3.0, 2.0, 3.0], [3.0, 2.3, 3.4], [2.0, 1.9, 2.8]] {
        let picture = of_props(&camera, &[prop(&ball([x, y, z], 0.03), [9; 3])], GREY);
        let depth = x - 1.0;
        let column = (40.0 - 80.0 * (z - 3.0) / depth).round() as usize;
        let row = (21.0 + 90.0 * (y - 2.0) / depth).round() as usize;
        let index = row * 100 + column;
        assert_eq!(picture.labels[index], 2, "({column}, {row}) of {x} {y} {z}");
        assert!((picture.depths[index] - (depth - 0.03)).abs() < 5e-3);
    }
}

#[test]
fn what_is_nearer_hides_what_is_behind_in_any_order() {
    let camera = camera(60, 60, 60.0);
    let (near, far) = (ball([0.0, 0.0, 1.0], 0.2), cuboid([-0.5, -0.5, 1.5], [0.5, 0.5, 1.6]));
    let one = of_props(&camera, &[prop(&near, [250, 0, 0]), prop(&far, [0, 0, 250])], GREY);
    let other = of_props(&camera, &[prop(&far, [0, 0, 250]), prop(&near, [250, 0, 0])], GREY);
    assert_eq!((&one.colors, &one.depths), (&other.colors, &other.depths));
    assert_eq!(one.labels[30 * 60 + 30], 2);
    assert_eq!(other.labels[30 * 60 + 30], 3);
    assert!(count(&one, 3) > count(&one, 2));
    // An object between them is in front of one and behind the other.
    let (mesh, nodes) = box_mesh([-0.3, -0.3, 1.3], [0.3, 0.3, 1.4]);
    let picture =
        of_mesh(&camera, &mesh, &nodes, &[prop(&far, [0, 0, 250]), prop(&near, [250, 0, 0])]);
    let along = |x: usize| picture.labels[30 * 60 + x];
    assert_eq!([along(30), along(17), along(12), along(2)], [3, 1, 2, 0]);
}

#[test]
fn labels_and_depths_agree_and_the_background_is_untouched() {
    let camera = camera(64, 48, 50.0);
    let pixels = camera.pixel_count();
    let image: Vec<u8> = (0..3 * pixels).map(|i| (i * 7 % 251) as u8).collect();
    let shape = ball([0.1, 0.1, 1.0], 0.2);
    let picture = of_props(&camera, &[prop(&shape, [0, 250, 0])], Background::Image(&image));
    let mut untouched = 0;
    for i in 0..pixels {
        assert_eq!(picture.labels[i] == 0, picture.depths[i] == 0.0);
        untouched += usize::from(picture.colors[3 * i..3 * i + 3] == image[3 * i..3 * i + 3]);
    }
    let seen = count(&picture, 2);
    assert!(untouched + seen <= pixels && untouched + seen > pixels - 60, "{untouched} {seen}");
    let empty = of_props(&camera, &[], Background::Image(&image));
    assert!(empty.colors == image && empty.labels.iter().all(|l| *l == 0));
}

#[test]
fn a_mesh_is_where_the_same_shape_is_found_by_rays() {
    let (low, high) = ([-0.3, -0.2, 0.8], [0.25, 0.3, 1.7]);
    let (mesh, nodes) = box_mesh(low, high);
    let pose = Pose::new([0.2, -0.2, 0.1, 0.05, -0.1, 0.1, 1.0]);
    let camera = Camera { world_to_camera: pose.world_to_camera(), ..camera(160, 120, 100.0) };
    let drawn = of_mesh(&camera, &mesh, &nodes, &[]);
    let found = of_props(&camera, &[prop(&cuboid(low, high), [200, 40, 40])], GREY);
    assert!(count(&drawn, 1) > 2000);
    let mut different = 0;
    for i in 0..camera.pixel_count() {
        if (drawn.labels[i] == 0) != (found.labels[i] == 0) {
            different += 1;
        } else if drawn.labels[i] != 0 {
            // Edges between faces may be a sample apart.
            let off = (drawn.depths[i] - found.depths[i]).abs();
            assert!(off < 2e-3, "{i}: {} and {}", drawn.depths[i], found.depths[i]);
        }
    }
    assert!(different <= 2, "{different} pixels differ");
}

#[test]
fn a_closed_mesh_hides_its_inside_and_an_open_one_shows_both_sides() {
    let camera = camera(40, 40, 20.0);
    let (mesh, nodes) = box_mesh([-1.0; 3], [1.0; 3]);
    assert_eq!(count(&of_mesh(&camera, &mesh, &nodes, &[]), 1), 0, "the camera is inside");
    let corners = [[-0.5, -0.5, 1.0], [0.5, -0.5, 1.0], [0.5, 0.5, 1.0], [-0.5, 0.5, 1.0]];
    let sides = [[[0, 1, 2], [0, 2, 3]], [[0, 2, 1], [0, 3, 2]]].map(|triangles| {
        let sheet = mesh_of(4, triangles.to_vec());
        of_mesh(&camera, &sheet, &corners, &[])
    });
    // Rounded, it has the normal of the side that is seen.
    assert_eq!(sides[0], sides[1]);
    assert_eq!(count(&sides[0], 1), 400);
}

#[test]
fn triangles_that_pass_the_camera_are_cut() {
    let camera = camera(120, 80, 60.0);
    let corners = [[-50.0, 0.5, -50.0], [50.0, 0.5, -50.0], [50.0, 0.5, 50.0], [-50.0, 0.5, 50.0]];
    let ground = mesh_of(4, vec![[0, 1, 2], [0, 2, 3]]);
    let picture = of_mesh(&camera, &ground, &corners, &[]);
    for row in [45, 60, 79] {
        let expected = 0.5 * 60.0 / (row as f32 - camera.cy);
        for column in [0, 33, 119] {
            let depth = picture.depths[row * 120 + column];
            assert!((depth / expected - 1.0).abs() < 1e-3, "row {row}: {depth}, not {expected}");
        }
    }
    assert!(picture.labels[..39 * 120].iter().all(|l| *l == 0), "nothing above the horizon");
}

#[test]
fn light_shades_by_direction_even_share_and_brightness() {
    let camera = camera(16, 16, 16.0);
    let shape = cuboid([-1.0, -1.0, 1.0], [1.0, 1.0, 2.0]);
    let color = |light: &Light| {
        let mesh = Mesh::new(Surface::default(), &[]);
        let posed = mesh.at(&[], light);
        let (props, background) = ([prop(&shape, [100, 150, 200])], GREY);
        let object = Object::Surface(&posed);
        let scene = Scene { camera: &camera, object, props: &props, light, background };
        let colors = draw(&scene, Wanted::default(), &|| false).unwrap().colors;
        [colors[0], colors[1], colors[2]]
    };
    assert_eq!(color(&LIGHT), [100, 150, 200], "it faces the light");
    let behind = Light { direction: [0.0, 0.0, 1.0], ..LIGHT };
    let even = Light { ambient: 1.0, ..behind };
    assert_eq!(color(&even), [100, 150, 200]);
    let [red, ..] = color(&behind);
    assert!((60..80).contains(&red), "four tenths of the light: {red}");
    assert_eq!(color(&Light { brightness: 0.0, ..LIGHT }), [0; 3]);
}

#[test]
fn a_picture_in_bands_is_that_of_its_crops() {
    let camera = camera(400, 300, 300.0);
    let (mesh, nodes) = box_mesh([-0.3, -0.2, 0.8], [0.25, 0.3, 1.7]);
    let shape = ball([0.2, 0.1, 0.9], 0.2);
    let props = [prop(&shape, [9, 200, 9])];
    let whole = of_mesh(&camera, &mesh, &nodes, &props);
    let crop = camera.crop(150, 120, 100, 90);
    let part = of_mesh(&crop, &mesh, &nodes, &props);
    let mut different = 0;
    for i in 0..crop.pixel_count() {
        let j = (i / 100 + 120) * 400 + i % 100 + 150;
        different += usize::from(part.labels[i] != whole.labels[j]);
    }
    assert!(count(&part, 1) > 1000 && count(&part, 2) > 1000);
    assert!(different <= 2, "{different}");
    let again = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert!(again.install(|| of_mesh(&camera, &mesh, &nodes, &props)) == whole);
}

#[test]
fn a_cancelled_picture_is_none() {
    let posed = Mesh::of_balls(0.1);
    let posed = posed.at(&[[0.0, 0.0, 1.0]], &LIGHT);
    let camera = camera(16, 16, 16.0);
    let object = Object::Surface(&posed);
    let scene = Scene { camera: &camera, object, props: &[], light: &LIGHT, background: GREY };
    assert_eq!(draw(&scene, ALL, &|| true), None);
    let picture = draw(&scene, ALL, &|| false).unwrap();
    assert!(count(&picture, 1) > 4 && count(&picture, 0) > 4);
}

/// Three Gaussians, opaque in the middle of the picture.
fn gaussians() -> Gaussians {
    Gaussians {
        means_m: vec![[0.0, 0.0, 1.0], [0.1, 0.05, 1.1], [-0.15, 0.0, 0.95]],
        scales_m: vec![[0.08; 3], [0.05, 0.02, 0.03], [0.04; 3]],
        rotations: vec![[0.0, 0.0, 0.0, 1.0]; 3],
        opacities: vec![0.99, 0.8, 0.6],
        colors: vec![[0.9, 0.2, 0.1], [0.1, 0.8, 0.3], [0.2, 0.3, 0.9]],
    }
}

#[test]
fn gaussians_are_the_image_of_the_rasteriser_over_the_background() {
    let camera = camera(64, 48, 60.0);
    let image = Cpu::default().render(&gaussians(), &camera).unwrap();
    let hidden = ball([0.0, 0.0, 3.0], 0.1);
    let shown = ball([-0.3, -0.3, 0.9], 0.05);
    let props = [prop(&hidden, [255; 3]), prop(&shown, [255; 3])];
    let object = Object::Gaussians(&image);
    let scene = Scene { camera: &camera, object, props: &[], light: &LIGHT, background: GREY };
    let picture = draw(&scene, ALL, &|| false).unwrap();
    let expected = |i: usize, k: usize| {
        let behind = [90.0, 91.0, 92.0][k];
        255.0 * image.color[i][k] + (1.0 - image.alpha[i]) * behind
    };
    for i in 0..camera.pixel_count() {
        for k in 0..3 {
            let off = f32::from(picture.colors[3 * i + k]) - expected(i, k);
            assert!(off.abs() <= 0.51, "pixel {i}: off by {off}");
        }
        assert_eq!(picture.labels[i] == 1, image.alpha[i] >= 0.5);
    }
    let middle = 24 * 64 + 32;
    let depth = image.depth_m[middle] / image.alpha[middle];
    assert!((picture.depths[middle] - depth).abs() < 1e-5);
    // A prop behind what is opaque changes nothing there, one in front hides it.
    let beside = draw(&Scene { props: &props, ..scene }, ALL, &|| false).unwrap();
    assert_eq!(beside.labels[middle], 1);
    let front = ball([0.0, 0.0, 0.5], 0.05);
    let props = [prop(&front, [255; 3])];
    let before = draw(&Scene { props: &props, ..scene }, ALL, &|| false).unwrap();
    assert_eq!(before.labels[middle], 2);
    assert!(before.colors[3 * middle + 2] > 200, "{:?}", &before.colors[3 * middle..][..3]);
    // Where Gaussians are half transparent, a prop behind them shines through.
    let wall = cuboid([-5.0, -5.0, 3.0], [5.0, 5.0, 3.1]);
    let props = [prop(&wall, [255; 3])];
    let light = Light { ambient: 1.0, ..LIGHT };
    let through = draw(&Scene { props: &props, light: &light, ..scene }, ALL, &|| false).unwrap();
    for i in (0..camera.pixel_count()).filter(|i| image.alpha[*i] > 0.1) {
        let off =
            f32::from(through.colors[3 * i]) - 255.0 * (image.color[i][0] + 1.0 - image.alpha[i]);
        assert!(off.abs() <= 1.6, "pixel {i}: off by {off}");
    }
    // Brightness applies to them, direction does not.
    let dark = Light { brightness: 0.25, direction: [0.0, 0.0, 1.0], ambient: 0.0 };
    let dark = draw(&Scene { light: &dark, ..scene }, ALL, &|| false).unwrap();
    let (now, then) = (dark.colors[3 * middle], picture.colors[3 * middle]);
    assert!((i32::from(now) - i32::from(then) * 137 / 255).abs() < 12, "{now} {then}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// No camera makes a picture panic, whether inside of things, far away, or turned away.
    #[test]
    fn any_camera_draws(
        pose in prop::array::uniform7(-2.0_f32..2.0),
        scale in prop::sample::select(vec![1e-3_f32, 0.1, 1.0, 1000.0]),
        focal in prop::sample::select(vec![1e-3_f32, 1.0, 30.0, 1e6]),
        at in prop::array::uniform3(-1.0_f32..1.0),
        radius in prop::sample::select(vec![1e-30_f32, 1e-3, 0.5, 900.0]),
        center in prop::sample::select(vec![-1e6_f32, 0.0, 15.5, 1e6]),
    ) {
        let [x, y, z, i, j, k, r] = pose;
        let pose = Pose::new([scale * x, scale * y, scale * z, i, j, k, r + 3.0]);
        let camera = Camera {
            cx: center,
            world_to_camera: pose.world_to_camera(),
            ..camera(32, 24, focal)
        };
        let (mesh, nodes) = box_mesh([-0.5; 3], at.map(|x| x + 0.6));
        let shapes = [
            ball(at, radius),
            Solid::Round { from: at, to: [0.0; 3], radius_m: radius },
            cuboid(at.map(|x| x - radius), at.map(|x| x + radius)),
        ];
        let props: Vec<Prop<'_>> = shapes.iter().map(|s| prop(s, [1, 2, 3])).collect();
        let picture = of_mesh(&camera, &mesh, &nodes, &props);
        for (label, depth) in picture.labels.iter().zip(&picture.depths) {
            prop_assert!(*label <= 4);
            prop_assert_eq!(*label == 0, *depth == 0.0);
            prop_assert!(depth.is_finite() && *depth >= 0.0);
        }
        prop_assert!(picture == of_mesh(&camera, &mesh, &nodes, &props));
    }
}
