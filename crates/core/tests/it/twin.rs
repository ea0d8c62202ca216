use bendtwin_core::{
    Contact, Graph, Params, Skin, Twin,
    twin::{Mean, Member},
};
use bendtwin_core_kit::twin_of;

fn twin(control_rest: Vec<[f32; 3]>) -> Twin {
    let graph = Graph { masses: vec![0.5, 1.5, 2.0], control_rest, ..Graph::default() };
    let params = Params { contact: Contact::default(), ..Params::default() };
    Twin { skin: Skin::default(), ..twin_of(graph, params) }
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

/// A twin whose fit ended with one loss, and members whose fits ended with others.
fn with_losses(own: Option<f64>, others: &[Option<f64>]) -> Twin {
    let mut twin = twin(Vec::new());
    twin.provenance.loss = own;
    let member = Member::of(&twin, &twin).unwrap();
    twin.members = others.iter().map(|&loss| Member { loss, ..member.clone() }).collect();
    twin
}

#[test]
fn fits_weigh_as_one_over_the_square_of_their_loss() {
    let weights = |own, others: &[Option<f64>]| with_losses(own, others).fit_weights();
    let near = |a: &[f64], b: &[f64]| {
        assert_eq!(a.len(), b.len());
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} is not {b:?}");
    };
    near(&weights(Some(1e-3), &[Some(2e-3), Some(1e-3)]), &[4.0 / 9.0, 1.0 / 9.0, 4.0 / 9.0]);
    near(&weights(Some(0.0), &[Some(2e-3), Some(0.0)]), &[0.5, 0.0, 0.5]);
    // A file of before losses were kept.
    near(&weights(None, &[None, None]), &[1.0 / 3.0; 3]);
    near(&weights(Some(1e-3), &[Some(2e-3), None]), &[1.0 / 3.0; 3]);
    near(&weights(None, &[]), &[1.0]);
}

#[test]
fn a_member_is_a_twin_with_its_own_loss() {
    let twin = with_losses(Some(1e-3), &[Some(2e-3)]);
    let member = twin.members[0].twin(&twin);
    assert_eq!(member.provenance.loss, Some(2e-3));
    assert_eq!(Member::of(&member, &twin), Some(twin.members[0].clone()));
}

#[test]
fn a_mean_has_the_weights_of_what_was_added() {
    let mut mean = Mean::default();
    assert_eq!(mean.points(), Vec::<[f32; 3]>::new());
    mean.add(0.1, &[[0.3, -7.0, 1e-3], [1.0; 3]]);
    assert_eq!(mean.points(), [[0.3, -7.0, 1e-3], [1.0; 3]], "a mean of one is the one");
    mean.add(0.3, &[[0.3, 1.0, 1e-3], [2.0; 3]]);
    assert_eq!(mean.points(), [[0.3, -1.0, 1e-3], [1.75; 3]]);
}
