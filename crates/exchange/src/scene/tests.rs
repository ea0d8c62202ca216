use std::path::Path;

use bendtwin_core::{Point, Problem as _, Skin};

use super::*;
use crate::{
    Format,
    testing::{mesh, motion, twin},
    write,
};

fn reason(result: Result<impl Sized, Error>) -> &'static str {
    result.err().unwrap().reason()
}

#[test]
fn points_are_carried_by_the_nodes() {
    let (twin, mesh) = (twin(), mesh());
    let motion = motion(&twin);
    let skin = Scene::new("a", &twin, PointSet::Skin, Some(&motion)).unwrap();
    assert_eq!((skin.point_count(), skin.frame_count()), (2, 3));
    assert_eq!(*skin.points_at(2), twin.skin.positions(&motion.nodes[10..]));
    let around = Scene::new("a", &twin, PointSet::Mesh(&mesh), None).unwrap();
    for (carried, vertex) in around.points_at(0).iter().zip(&mesh.vertices) {
        let off = (0..3).map(|a| (carried[a] - vertex[a]).abs()).fold(0.0, f32::max);
        assert!(off < 1e-6, "{carried:?} {vertex:?}");
    }
    // An affine motion carries what the nodes span.
    let moving = Scene::new("a", &twin, PointSet::Mesh(&mesh), Some(&motion)).unwrap();
    let fallen: Vec<Point> = moving.points_at(2).to_vec();
    for (p, q) in fallen.iter().zip(&mesh.vertices) {
        assert!((p[2] - (q[2] - 0.06)).abs() < 2e-3, "{p:?} {q:?}");
    }
}

#[test]
fn a_motion_of_another_twin_is_refused() {
    let twin = twin();
    let whole = motion(&twin);
    let of = |motion: &Motion| reason(Scene::new("a", &twin, PointSet::Nodes, Some(motion)));
    let mut short = whole.clone();
    short.nodes.pop();
    assert_eq!(of(&short), "EXPORT_MOTION_SHAPE");
    let mut short = whole.clone();
    short.controls.pop();
    assert_eq!(of(&short), "EXPORT_MOTION_SHAPE");
    assert_eq!(of(&Motion::default()), "EXPORT_MOTION_SHAPE");
    let mut diverged = whole.clone();
    diverged.nodes[7][1] = f32::NAN;
    let error = Scene::new("a", &twin, PointSet::Nodes, Some(&diverged)).unwrap_err();
    assert!(matches!(error, Error::NotFinite { frame: 1 }), "{error}");
    let mut never = whole;
    never.times_s[2] = f64::INFINITY;
    assert_eq!(of(&never), "EXPORT_NOT_FINITE");
    let bare = Twin { skin: Skin::default(), ..twin.clone() };
    assert_eq!(reason(Scene::new("a", &bare, PointSet::Skin, None)), "EXPORT_NO_POINTS");
}

#[test]
fn a_mesh_in_other_units_or_axes_is_refused() {
    let (twin, mesh) = (twin(), mesh());
    let changed = |change: fn(Point) -> Point| Mesh {
        vertices: mesh.vertices.iter().map(|v| change(*v)).collect(),
        triangles: mesh.triangles.clone(),
    };
    let of = |mesh: &Mesh| Scene::new("a", &twin, PointSet::Mesh(mesh), None).map(|_| ());
    assert!(of(&changed(|v| v)).is_ok());
    let changes: [fn(Point) -> Point; 3] =
        [|v| v.map(|x| 1000.0 * x), |v| v.map(|x| 0.01 * x), |[x, y, z]| [x, z, -y - 1.0]];
    for change in changes {
        assert_eq!(reason(of(&changed(change))), "EXPORT_MESH_ELSEWHERE");
    }
}

#[test]
fn nothing_is_created_where_a_format_cannot_carry_the_scene() {
    let twin = twin();
    let motion = motion(&twin);
    let folder = tempfile::tempdir().unwrap();
    let moving = Scene::new("a", &twin, PointSet::Nodes, Some(&motion)).unwrap();
    let skin = Scene::new("a", &twin, PointSet::Skin, None).unwrap();
    let cases: [(&Scene<'_>, Format, &str); 4] = [
        (&moving, Format::Ply, "EXPORT_HOLDS_NO_MOTION"),
        (&moving, Format::Twin, "EXPORT_HOLDS_NO_MOTION"),
        (&skin, Format::Mujoco, "EXPORT_HOLDS_NODES_ONLY"),
        (&skin, Format::Twin, "EXPORT_HOLDS_NODES_ONLY"),
    ];
    for (scene, format, expected) in cases {
        let path = folder.path().join("out");
        assert_eq!(reason(write(scene, format, &path)), expected, "{format}");
        assert!(!path.exists());
    }
    let missing = folder.path().join("no/such/folder.npz");
    let error = write(&skin, Format::Npz, Path::new(&missing)).unwrap_err();
    assert!(error.reason() == "EXPORT_IO" && error.to_string().contains("folder.npz"), "{error}");
}

#[test]
fn the_twin_file_is_the_twin() {
    let twin = twin();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.twin");
    let scene = Scene::new("a", &twin, PointSet::Nodes, None).unwrap();
    write(&scene, Format::of_path(&path).unwrap(), &path).unwrap();
    assert_eq!(Twin::decode(&std::fs::read(&path).unwrap()).unwrap(), twin);
}

#[test]
fn a_twin_without_a_surface_gets_one_unless_its_points_are_too_few() {
    let few = twin();
    assert_eq!(reason(Scene::new("a", &few, PointSet::Surface, None)), "EXPORT_NO_POINTS");
    // Points all around a ball, on one node each.
    let mut many = few;
    let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    let place = |i: u16| {
        let (z, turn) = (1.0 - (2.0 * f32::from(i) + 1.0) / 300.0, golden * f32::from(i));
        let across = (1.0 - z * z).sqrt();
        [0.1 * across * turn.cos(), 0.1 * across * turn.sin(), 0.1 * z]
    };
    many.skin = Skin::default();
    for i in 0..300 {
        many.skin.push(u32::from(i), &[(0, 1.0)], [Skin::NO_FRAME; 3], place(i));
    }
    let scene = Scene::new("a", &many, PointSet::Surface, None).unwrap();
    assert!(scene.triangles().len() > 100 && scene.colors().is_empty());
}
