use super::*;
use crate::scene;

#[test]
fn of_a_large_skin_a_part_is_matched() {
    let mut model = scene::coarse();
    let whole = MatchedSkin::new(&model.graph, &model.skin);
    assert_eq!(whole.skin, *model.skin);
    assert!((0.009..0.015).contains(&whole.spacing_m), "{}", whole.spacing_m);
    let many: Vec<usize> = (0..3 * MOST).map(|p| p % model.skin.len()).collect();
    model.skin = model.skin.select(&many).into();
    let part = MatchedSkin::new(&model.graph, &model.skin);
    assert!((MOST / 2..=MOST).contains(&part.skin.len()), "{}", part.skin.len());
}

#[test]
fn dense_points_share_what_they_know() {
    let model = scene::coarse();
    let skin = MatchedSkin::new(&model.graph, &model.skin);
    let x: Vec<Vector3<f64>> = model.graph.rest_positions.iter().map(|p| vector3(*p)).collect();
    let pull = |count: usize| {
        let points: Vec<Point> =
            model.skin.positions(&model.graph.rest_positions)[..1].repeat(count);
        let observation = Observation { points, ..Observation::default() };
        let seen = Matcher { graph: &model.graph, skin: Some(&skin), observation: &observation };
        let matches = seen.matches(&x, 0.001).unwrap();
        matches.list.iter().map(|m| m.precision).sum::<f64>()
    };
    let [one, ten, thousand] = [1, 10, 1000].map(pull);
    assert!((one - 1e6).abs() < 1.0, "{one}");
    assert!(ten > 5.0 * one && thousand < 1.01 * pull(500), "{one} {ten} {thousand}");
}
