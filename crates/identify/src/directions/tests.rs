use crate::strip::strip;

use super::*;

fn applied(twin: &Twin, regions: &Regions, direction: &Direction, step: f64) -> (Params, f64) {
    let hands = twin.hands();
    direction.apply(&twin.graph, &twin.params, &regions.of_nodes, &hands, step)
}

#[test]
fn directions_of_all_regions_together_change_the_whole() {
    let twin = strip(true);
    let regions = Regions::of(&twin);
    let all = directions(&twin, &regions);
    // Stiffness and rest length by region, one hand, dashpots, drag, friction and restitution.
    assert_eq!(all.len(), 2 * 8 + 1 + 4);
    let mut together = twin.clone();
    for direction in all.iter().filter(|d| d.quantity == Quantity::Stiffness) {
        together.params = applied(&together, &regions, direction, 0.1).0;
    }
    let (nodes, factor) = (twin.graph.node_count(), 0.1_f32.exp());
    for (i, spring) in twin.graph.springs.iter().enumerate() {
        let ratio = together.params.spring_stiffness[i] / twin.params.spring_stiffness[i];
        let expected = if spring[1] as usize >= nodes { 1.0 } else { factor };
        assert!((ratio - expected).abs() < 1e-5, "spring {i}: {ratio}");
    }
    assert_eq!(together.params.rest_lengths_m, twin.params.rest_lengths_m);
}

#[test]
fn a_grip_is_the_springs_of_its_hand() {
    let twin = strip(false);
    let regions = Regions::of(&twin);
    let grip = Direction { quantity: Quantity::Grip, region: None, hand: Some(0) };
    let (params, _) = applied(&twin, &regions, &grip, 1.0);
    let nodes = twin.graph.node_count();
    for (spring, (new, old)) in twin
        .graph
        .springs
        .iter()
        .zip(params.spring_stiffness.iter().zip(&twin.params.spring_stiffness))
    {
        assert_eq!(new != old, spring[1] as usize >= nodes);
    }
}

#[test]
fn steps_end_at_limits() {
    let mut twin = strip(true);
    twin.params.contact.ground_restitution = 0.02;
    let regions = Regions::of(&twin);
    let restitution = Direction { quantity: Quantity::GroundRestitution, region: None, hand: None };
    let (params, made) = applied(&twin, &regions, &restitution, -0.05);
    assert_eq!(params.contact.ground_restitution, 0.0);
    assert!((made + 0.02).abs() < 1e-6, "{made}");
    let (params, made) = applied(&twin, &regions, &restitution, 0.05);
    assert!((params.contact.ground_restitution - 0.07).abs() < 1e-6);
    assert!((made - 0.05).abs() < 1e-6, "{made}");
    params.check(&twin.graph).unwrap();
}
