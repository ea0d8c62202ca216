use bendtwin_core::Severity;
use nalgebra::{Rotation3, Vector3};

use super::*;
use crate::testing::{BALL_M, TestScene, place, point, sphere};

/// A ball of radius 1 as an OBJ.
fn ball() -> Vec<u8> {
    let (rings, sides) = (24, 48);
    let mut text = String::new();
    for r in 0..=rings {
        for s in 0..sides {
            let (a, b) = (
                std::f64::consts::PI * f64::from(r) / f64::from(rings),
                2.0 * std::f64::consts::PI * f64::from(s) / f64::from(sides),
            );
            let (x, y, z) = (a.sin() * b.cos(), a.sin() * b.sin(), a.cos());
            text += &format!("v {x} {y} {z}\n");
        }
    }
    for r in 0..rings {
        for s in 0..sides {
            let at = |r: i32, s: i32| r * sides + s % sides + 1;
            let (a, b, c, d) = (at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s + 1));
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text.into_bytes()
}

fn observed() -> Vec<Point> {
    let all = sphere(3000).into_iter().filter(|p| p.z > -0.3);
    all.map(|p| point(place(0, p * BALL_M))).collect()
}

type Made = Result<Option<(Shape, ShapeEvidence)>, Error>;

fn made(
    to_world: Option<Alignment>,
    settings: &IngestSettings,
    bytes: Vec<u8>,
) -> (Made, Vec<Finding>) {
    let mut recording = TestScene::default().recording();
    recording.mesh = Some(MeshFile { name: "ball.obj".to_owned(), bytes, to_world });
    let mut findings = Vec::new();
    (completed(&recording, settings, &mut findings), findings)
}

fn completed(
    recording: &Recording,
    settings: &IngestSettings,
    findings: &mut Vec<Finding>,
) -> Made {
    shape(recording, &observed(), &[], settings, findings, &CancelToken::default())
}

fn given(scale: f32) -> Option<Alignment> {
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.3);
    let rotation = std::array::from_fn(|i| std::array::from_fn(|j| turn[(i, j)] as f32));
    Some(Alignment { rotation, scale, translation: point(place(0, Vector3::zeros())) })
}

#[test]
fn a_mesh_completes_the_ball() {
    let settings = IngestSettings::default();
    for to_world in [given(BALL_M as f32), None] {
        let aligned = to_world.is_none();
        let (result, findings) = made(to_world, &settings, ball());
        let (shape, evidence) = result.unwrap().unwrap();
        assert!(findings.is_empty(), "{findings:?}");
        assert_eq!((evidence.aligned, evidence.source.as_str()), (aligned, "ball.obj"));
        assert!(evidence.error_m < 1e-3 && (evidence.scale - BALL_M).abs() < 2e-3, "{evidence:?}");
        let middle = point(place(0, Vector3::zeros()));
        let off = |p: &Point| crate::rigid::distance(*p, middle);
        assert!(shape.surface.iter().all(|p| (off(p) - BALL_M).abs() < 3e-3));
        assert!(shape.interior.iter().all(|p| off(p) < BALL_M));
        assert!(shape.surface.len() > 500 && shape.interior.len() > 3000);
    }
    let hollow = IngestSettings { interior: Interior::None, ..settings };
    let (shape, _) = made(given(BALL_M as f32), &hollow, ball()).0.unwrap().unwrap();
    assert!(shape.interior.is_empty());
}

#[test]
fn a_mesh_that_does_not_fit_is_left_out_with_a_finding() {
    let settings = IngestSettings { interior: Interior::Mesh, ..IngestSettings::default() };
    // In centimetres, and on its own without alignment.
    let (result, findings) = made(given(100.0 * BALL_M as f32), &settings, ball());
    assert_eq!(result.unwrap(), None);
    assert_eq!(findings[0].code, "MESH_DOES_NOT_FIT");
    assert_eq!(findings[0].severity, Severity::Warning);
    let mut stubborn = settings.clone();
    stubborn.completion.align = false;
    let (result, findings) = made(None, &stubborn, ball());
    assert_eq!(result.unwrap(), None);
    assert_eq!(findings[0].code, "MESH_NOT_ALIGNED");
    let (result, _) = made(None, &settings, b"f 1 2 3".to_vec());
    assert_eq!(bendtwin_core::Problem::reason(&result.unwrap_err()), "MESH_UNUSABLE");
    let mut without = settings;
    without.completion.mesh = false;
    let (result, findings) = made(None, &without, b"f 1 2 3".to_vec());
    assert_eq!((result.unwrap(), findings.len()), (None, 0));
}

#[test]
fn without_a_mesh_the_settings_say_what_fills_the_object() {
    let recording = TestScene { cameras: 3, ..TestScene::default() }.recording();
    let made = |interior| {
        let settings = IngestSettings { interior, ..IngestSettings::default() };
        completed(&recording, &settings, &mut Vec::new()).unwrap()
    };
    assert_eq!((made(Interior::Mesh), made(Interior::None)), (None, None));
    let (carved, evidence) = made(Interior::Carved).unwrap();
    assert_eq!(evidence.source, "carved");
    assert!(carved.surface.len() > 500 && carved.interior.len() > 3000);
    assert_eq!(made(IngestSettings::default().interior), Some((carved, evidence)));

    let (convex, evidence) = made(Interior::Convex).unwrap();
    assert_eq!(evidence.source, "convex");
    let middle = point(place(0, Vector3::zeros()));
    assert!(convex.surface.is_empty() && convex.interior.len() > 1000);
    assert!(convex.interior.iter().all(|p| crate::rigid::distance(*p, middle) < 1.05 * BALL_M));
}
