use super::*;
use crate::{
    Format, PointSet,
    testing::{encoded, motion, twin},
};

fn text(scene: &Scene<'_>) -> String {
    String::from_utf8(encoded(scene, Format::Mujoco)).unwrap()
}

fn attribute<'a>(line: &'a str, name: &str) -> &'a str {
    let (_, rest) = line.split_once(&format!(" {name}=\"")).unwrap();
    rest.split_once('"').unwrap().0
}

#[test]
fn springs_are_tendons_in_newtons() {
    let twin = twin();
    let text = text(&Scene::new("a <&>", &twin, PointSet::Nodes, None).unwrap());
    let tendons: Vec<_> = text.lines().filter(|l| l.contains("<spatial")).collect();
    // The spring between a pinned node and a control point moves nothing.
    assert_eq!(tendons.len(), 5);
    // 0.55 kg on 5.5 units of mass; the first spring has k = 1000 at 0.1 m.
    assert_eq!(attribute(tendons[0], "stiffness").parse::<f64>().unwrap().round(), 1000.0);
    assert!((attribute(tendons[0], "damping").parse::<f64>().unwrap() - 0.1).abs() < 1e-6);
    assert_eq!(attribute(tendons[0], "springlength").parse::<f32>(), Ok(0.1));
    assert!(tendons[4].contains("site=\"n3\"") && tendons[4].contains("site=\"c1\""));
    assert!(text.contains("<mujoco model=\"a \">"));
    assert_eq!(text.matches("<joint").count(), 4 * 3);
    let ends = text.lines().find(|l| l.contains("\"bend_ends\"")).unwrap();
    assert_eq!(attribute(ends, "data"), "0 1 2 6 3 2");
}

#[test]
fn what_is_lost_stands_at_the_top() {
    let twin = twin();
    let text = text(&Scene::new("a", &twin, PointSet::Nodes, None).unwrap());
    let (comment, _) = text.split_once("-->").unwrap();
    for word in ["bending", "twist", "restitution", "skin", "velocity of control points"] {
        assert!(comment.contains(word), "{word}");
    }
    // Two hyphens would end a comment.
    assert!(!comment.trim_start_matches("<!--").contains("--"));
}

#[test]
fn objects_meet_each_other_and_the_ground_alone() {
    let mut twin = twin();
    let collide = |a: (u32, u32), b: (u32, u32)| a.0 & b.1 != 0 || b.0 & a.1 != 0;
    let ground = (1, 0);
    let model = Model::of(&twin);
    let bits: Vec<_> = (0..5).map(|n| model.bits(n)).collect();
    assert!(collide(bits[1], bits[4]) && !collide(bits[1], bits[2]) && !collide(bits[4], bits[4]));
    assert!(bits.iter().all(|b| collide(*b, ground)));
    twin.params.contact.between_objects = false;
    let model = Model::of(&twin);
    let (a, b) = (model.bits(1), model.bits(4));
    assert!(!collide(a, b) && collide(a, ground));
}

#[test]
fn a_motion_is_keyframes() {
    let twin = twin();
    let motion = motion(&twin);
    let text = text(&Scene::new("a", &twin, PointSet::Nodes, Some(&motion)).unwrap());
    let keys: Vec<_> = text.lines().filter(|l| l.contains("<key ")).collect();
    assert_eq!(keys.len(), 3);
    let numbers = |name| -> Vec<f32> {
        attribute(keys[2], name).split(' ').map(|n| n.parse().unwrap()).collect()
    };
    assert_eq!((numbers("qpos").len(), numbers("mpos")), (4 * 3, motion.controls[4..].concat()));
    let fell = numbers("qpos")[2];
    assert!((fell + 0.06).abs() < 1e-6, "{fell}");
}
