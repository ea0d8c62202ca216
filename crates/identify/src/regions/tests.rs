use crate::strip::strip;

use super::*;

#[test]
fn regions_are_named_by_where_they_are_and_divide_the_nodes() {
    let twin = strip(false);
    let regions = Regions::of(&twin);
    let names: Vec<&str> = regions.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names.len(), 8);
    assert_eq!((names[0], names[7]), ("near the hand", "free end"));
    assert!(names[1].contains("cm from the hand"), "{names:?}");
    let mut unique = names.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), names.len(), "{names:?}");
    let count = |r: usize| regions.of_nodes.iter().filter(|of| usize::from(**of) == r).count();
    for (r, part) in regions.parts.iter().enumerate() {
        assert!(count(r) > 0 && count(r) == part.nodes as usize, "{part:?}");
    }
    assert!(regions.parts.is_sorted_by(|a, b| a.center[0] < b.center[0]));
    assert_eq!(regions, Regions::of(&twin));
}

#[test]
fn a_handful_is_where_a_region_is_farthest_from_the_hands() {
    let twin = strip(false);
    let regions = Regions::of(&twin);
    let nodes = regions.handful(&twin, regions.far);
    assert!(nodes.len() >= 3 && nodes.iter().all(|i| *i >= 72), "{nodes:?}");
}

#[test]
fn objects_without_hands_or_with_few_nodes_have_regions() {
    let mut twin = strip(false);
    twin.graph.control_rest.clear();
    twin.control_hands.clear();
    twin.graph.springs.retain(|s| s[1] < 80);
    let regions = Regions::of(&twin);
    assert!(regions.parts.iter().all(|p| p.name.starts_with("towards") || p.name.contains("side")));
    twin.graph.rest_positions.truncate(1);
    assert_eq!(Regions::of(&twin).of_nodes, [0]);
    twin.graph.rest_positions.clear();
    assert!(Regions::of(&twin).parts.is_empty());
}
