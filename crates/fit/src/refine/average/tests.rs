use super::*;

/// Positions that circle a minimum at 3.
#[test]
fn the_mean_lies_nearer_to_what_positions_circle() {
    let mut average = Average::default();
    assert_eq!(average.theta(), None);
    for pass in 0..200 {
        average.add(&[3.0 + if pass % 2 == 0 { 1.0 } else { -1.0 }]);
    }
    let mean = average.theta().unwrap()[0];
    assert!((mean - 3.0).abs() < 0.05, "{mean}");
    average.clear();
    assert_eq!(average.theta(), None);
    average.add(&[7.0]);
    assert_eq!(average.theta(), Some(&[7.0][..]), "nothing is left of what was before");
}

#[test]
fn a_mean_is_scored_every_tenth_pass() {
    let due: Vec<u32> = (0..30).filter(|&pass| Average::is_due(pass)).collect();
    assert_eq!(due, [9, 19, 29]);
}
