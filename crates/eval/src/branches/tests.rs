use super::*;

/// A trunk of points `0..trunk`, and branches, each given by the trunk point where it begins and
/// its number of points.
fn cable(trunk: u32, branches: &[(u32, u32)]) -> (Vec<[u32; 2]>, usize) {
    let mut edges: Vec<[u32; 2]> = (1..trunk).map(|p| [p - 1, p]).collect();
    let mut next = trunk;
    for &(from, points) in branches {
        for i in 0..points {
            edges.push([if i == 0 { from } else { next - 1 }, next]);
            next += 1;
        }
    }
    (edges, next as usize)
}

#[test]
fn defts_first_cable_has_22_of_39_places() {
    let (edges, points) = cable(13, &[(4, 4), (8, 3)]);
    let branches = Branches::new(&edges, points).unwrap();
    assert_eq!(branches.memberships.iter().sum::<f64>(), 22.0);
    assert_eq!((branches.memberships[4], branches.memberships[8]), (2.0, 2.0));
    assert!((branches.padding - 39.0 / 22.0).abs() < 1e-12);
}

#[test]
fn three_branches_may_begin_in_one_point_or_on_a_branch() {
    let (edges, points) = cable(7, &[(3, 2), (3, 1), (3, 3)]);
    let star = Branches::new(&edges, points).unwrap();
    assert_eq!(star.memberships[3], 4.0);
    assert!((star.padding - 4.0 * 7.0 / 16.0).abs() < 1e-12);
    // Two of them on the branch that begins in 3: its points are 7 and 8, with the tip's own branch
    // at 7.
    let (edges, points) = cable(7, &[(3, 2), (7, 1)]);
    let nested = Branches::new(&edges, points).unwrap();
    assert_eq!((nested.memberships[3], nested.memberships[7]), (2.0, 2.0));
}

#[test]
fn what_is_no_tree_with_a_junction_has_no_branches() {
    let (chain, points) = cable(5, &[]);
    assert_eq!(Branches::new(&chain, points), None);
    let (mut ring, points) = cable(4, &[(1, 1)]);
    ring.push([0, 3]);
    assert_eq!(Branches::new(&ring, points), None);
    // As many edges as a tree has, but a ring and a loose point.
    assert_eq!(Branches::new(&[[0, 1], [1, 2], [2, 0]], 4), None);
    assert_eq!(Branches::new(&[[0, 9]], 2), None);
    assert_eq!(Branches::new(&[], 1), None);
    assert_eq!(Branches::new(&[], 0), None);
}
