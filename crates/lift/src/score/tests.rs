use super::*;

#[test]
fn clean_tracks_are_compared_where_their_point_is_seen() {
    let mut sequence = Sequence {
        frame_count: 2,
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 0.1], [5.0, 0.0, 0.0]],
        visible: vec![true, true, true, false],
        truth_tracks: vec![[0.01, 0.0, 0.0], [0.99, 0.0, 0.0], [0.0, 0.0, 0.1], [1.0, 0.0, 0.0]],
        ..Sequence::default()
    };
    let found = score(&sequence).unwrap();
    assert_eq!((found.points, found.truth_tracks, found.compared), (2, 2, 3));
    assert!((found.median_m - 0.01).abs() < 1e-6 && (found.start_m - 0.01).abs() < 1e-6);
    sequence.truth_tracks[2] = [f32::NAN; 3];
    assert_eq!(score(&sequence).unwrap().compared, 2);
    sequence.visible = vec![false; 4];
    assert_eq!(score(&sequence), None);
    assert_eq!(score(&Sequence::default()), None);
}
