use super::*;

/// Numbers by chance, 0..1.
fn chance(seed: u64) -> impl FnMut() -> f32 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 24) as f32
    }
}

/// Arrangements of points that cells of a grid, or halves of space, cannot tell apart.
fn arrangements(n: usize) -> Vec<(&'static str, Vec<Point>)> {
    let mut next = chance(7);
    let spread: Vec<Point> = (0..n).map(|_| std::array::from_fn(|_| next())).collect();
    let each = |of: &dyn Fn(usize, Point) -> Point| {
        spread.iter().enumerate().map(|(i, p)| of(i, *p)).collect::<Vec<Point>>()
    };
    vec![
        ("spread", spread.clone()),
        ("one place", each(&|_, _| [0.1, 0.2, 0.3])),
        ("a line along an axis", each(&|_, p| [0.5, 0.5, p[2]])),
        ("a plane across an axis", each(&|_, p| [p[0], p[1], 0.5])),
        ("two places far apart", each(&|i, _| [if i % 2 == 0 { -1e30 } else { 1e30 }, 0.0, 0.0])),
        ("two heaps far apart", each(&|i, p| p.map(|x| 1e-3 * x + (i % 2) as f32 * 1e3))),
        ("denormals", each(&|_, p| p.map(|x| x * 1e-40))),
        ("a heap and one far away", each(&|i, p| if i == 0 { [1e30; 3] } else { p })),
        ("half of them not finite", each(&|i, p| if i % 2 == 0 { p } else { [f32::NAN; 3] })),
    ]
}

fn by_comparison(points: &[Point], at: Point, search: &Search<'_>) -> Vec<Near> {
    let square = |p: &Point| p.iter().zip(at).map(|(a, b)| f64::from(b - a).powi(2)).sum::<f64>();
    let mut all: Vec<Near> = points
        .iter()
        .zip(0..)
        .filter(|(p, _)| p.iter().all(|x| x.is_finite()))
        .map(|(p, number)| Near { square: square(p), number })
        .filter(|near| near.square <= search.most && near.square > search.beyond)
        .filter(|near| search.other_than.is_none_or(|(of, own)| of[near.number as usize] != own))
        .collect();
    all.sort();
    all.truncate(search.count);
    all
}

#[test]
fn the_nearest_are_those_of_a_comparison_with_all() {
    let groups: Vec<u32> = (0..300).map(|i| i / 40).collect();
    for (what, points) in arrangements(300) {
        let metric = PointTree::new([]).metric;
        let tree = PointTree::grouped(&points, &groups, metric);
        let mut next = chance(11);
        let elsewhere: Point = std::array::from_fn(|_| 2.0 * next() - 0.5);
        for (i, at) in points.iter().step_by(7).chain([&elsewhere]).enumerate() {
            for search in [
                Search::nearest(1),
                Search::nearest(9),
                Search { most: 0.04, ..Search::nearest(40) },
                Search { beyond: 1e-4, ..Search::nearest(3) },
                Search { other_than: Some((&groups, i as u32 % 8)), ..Search::nearest(5) },
                Search::nearest(0),
            ] {
                let expected = match at.iter().all(|x| x.is_finite()) {
                    true => by_comparison(&points, *at, &search),
                    false => Vec::new(),
                };
                assert_eq!(tree.search(*at, &search), expected, "{what}, {search:?}");
            }
        }
    }
}

#[test]
fn a_search_takes_few_steps_in_any_arrangement() {
    let n = 40_000;
    let groups: Vec<u32> = (0..n as u32).map(|i| i % 2).collect();
    for (what, points) in arrangements(n) {
        let tree = PointTree::grouped(&points, &groups, PointTree::new([]).metric);
        let by_group = Search { other_than: Some((&groups, 0)), ..Search::nearest(1) };
        for search in [Search::nearest(1), Search::nearest(20), by_group] {
            let each = points.iter().step_by(97).map(|p| tree.counted(*p, &search).1);
            let (sum, count) = each.fold((0, 0), |(sum, count), steps| (sum + steps, count + 1));
            let mean = sum as f64 / f64::from(count);
            assert!(mean < 400.0, "{what}: {mean} distances for {search:?}");
        }
    }
    // All points of another group are far away, and those of the own one pass as a whole.
    let points: Vec<Point> =
        (0..n).map(|i| [(i % 2) as f32 * 1e3 + i as f32 * 1e-5, 0.0, 0.0]).collect();
    let tree = PointTree::grouped(&points, &groups, PointTree::new([]).metric);
    let other = Search { other_than: Some((&groups, 0)), ..Search::nearest(1) };
    assert!(tree.counted(points[0], &other).1 < 100);
    // And what is too near passes as a whole, too.
    let beyond = Search { beyond: 1.0, ..Search::nearest(1) };
    assert!(tree.counted(points[0], &beyond).1 < 100);
}

#[test]
fn without_points_nothing_is_near() {
    let tree = PointTree::new([[f32::NAN; 3]]);
    assert_eq!((tree.closest([0.0; 3]), tree.any_within([0.0; 3], 1e9)), (None, false));
    let one = PointTree::new([[1.0, 0.0, 0.0]]);
    assert!(one.any_within([0.0; 3], 1.0) && !one.any_within([0.0; 3], 0.999));
    assert_eq!(one.closest([f32::INFINITY; 3]), None);
}
