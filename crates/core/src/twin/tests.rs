use crate::Contact;

use super::*;

fn twin(control_rest: Vec<[f32; 3]>) -> Twin {
    Twin {
        skin: Skin::default(),
        graph: Graph { masses: vec![0.5, 1.5, 2.0], control_rest, ..Graph::default() },
        params: Params { contact: Contact::default(), ..Params::default() },
        environment: Environment::Z_UP,
        timing: Timing { fps: 30.0, substeps: 1 },
        control_velocity: ControlVelocity::True,
        provenance: Provenance::default(),
        quality: Quality::default(),
        mass_kg: None,
        control_hands: Vec::new(),
        members: Vec::new(),
        appearance: None,
    }
}

#[test]
fn forces_are_in_newtons_once_the_mass_is_known() {
    let mut twin = twin(Vec::new());
    assert_eq!(twin.newtons_per_unit(), 1.0);
    twin.mass_kg = Some(0.2);
    assert_eq!(twin.newtons_per_unit(), 0.05);
}

#[test]
fn hands_are_those_of_the_capture_or_else_what_is_linked() {
    let at = |x: f32| [x, 0.0, 0.5];
    // A hand that bends around another one's place in the order of points.
    let mut twin = twin([0.0, 0.5, 0.07, 0.14, 0.56, 0.21].map(at).to_vec());
    assert_eq!(twin.hands(), [0, 1, 0, 0, 1, 0]);
    twin.control_hands = vec![1, 1, 1, 0, 0, 0];
    assert_eq!(twin.hands(), [1, 1, 1, 0, 0, 0]);
}
