use super::*;
use crate::{
    Format,
    testing::{encoded, mesh, motion, twin, with_surface},
};

fn text(scene: &Scene<'_>) -> String {
    String::from_utf8(encoded(scene, Format::Usda)).unwrap()
}

/// Numbers of a line's list.
fn numbers(line: &str) -> Vec<f32> {
    let (_, list) = line.rsplit_once('[').unwrap();
    let numbers = list.split(|c| ",()] ".contains(c)).filter(|word| !word.is_empty());
    numbers.map(|word| word.parse().unwrap()).collect()
}

#[test]
fn motion_is_sampled_at_frames() {
    let twin = twin();
    let motion = motion(&twin);
    let scene = Scene::new("a \"b\"\n", &twin, PointSet::Nodes, Some(&motion)).unwrap();
    let text = text(&scene);
    for line in ["#usda 1.0", "upAxis = \"Z\"", "metersPerUnit = 1", "endTimeCode = 3", "\"a b\""] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let (_, samples) = text.split_once("points.timeSamples").unwrap();
    for (frame, line) in samples.lines().skip(1).take(3).enumerate() {
        assert!(line.trim().starts_with(&format!("{}: ", frame + 1)), "{line}");
        // As many digits as bring the same number back.
        assert_eq!(numbers(line), scene.points_at(frame).concat());
    }
    assert!(!text.contains("Springs"));
    assert_eq!(text.matches('{').count(), text.matches('}').count());
}

#[test]
fn a_twin_at_rest_has_its_springs() {
    let twin = twin();
    let text = text(&Scene::new("a", &twin, PointSet::Nodes, None).unwrap());
    assert!(!text.contains("timeSamples") && !text.contains("TimeCode ="));
    let stiffness = text.lines().find(|l| l.contains("primvars:stiffness")).unwrap();
    assert_eq!(numbers(stiffness.split_once(" (").unwrap().0), [1000.0, 900.0, 800.0, 700.0]);
    assert!(text.contains("curveVertexCounts = [2, 2, 2, 2]"));
}

#[test]
fn a_mesh_has_its_faces() {
    let (twin, mesh) = (twin(), mesh());
    let text = text(&Scene::new("a", &twin, PointSet::Mesh(&mesh), None).unwrap());
    assert!(text.contains("def Mesh \"Surface\"") && text.contains("[3, 3, 3, 3]"));
    assert!(text.contains("faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]"));
}

#[test]
fn a_surface_has_its_colours_and_a_package_has_it_uncompressed() {
    let twin = with_surface();
    let scene = Scene::new("a", &twin, PointSet::Surface, None).unwrap();
    let text = text(&scene);
    let line = text.lines().find(|l| l.contains("primvars:displayColor")).unwrap();
    let colors = numbers(line.split_once(" (interpolation").unwrap().0);
    assert_eq!((colors[0], colors[9..].to_vec()), (1.0, vec![1.0; 3]));
    let package = encoded(&scene, Format::Usdz);
    let at = package.windows(text.len()).position(|w| w == text.as_bytes()).unwrap();
    assert_eq!(at % 64, 0);
    assert_eq!(package[..4], *b"PK\x03\x04");
}
