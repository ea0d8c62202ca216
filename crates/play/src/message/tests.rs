use super::*;

#[test]
fn the_newest_motion_takes_the_place_of_older_ones() {
    let inbox = Inbox::default();
    let moved = |input: u32, gripper: u32, x: f32| {
        let text = format!(
            r#"{{"type":"move","input":{input},"grippers":[{{"index":{gripper},"position":[{x},0,0]}}]}}"#
        );
        read(&text).unwrap()
    };
    for input in 0..10_000 {
        inbox.push(moved(input, input % 2, (input % 64) as f32 * 0.5)).unwrap();
    }
    let waiting = inbox.take();
    assert_eq!(waiting.len(), 1);
    let Message::Move { input, grippers, .. } = &waiting[0] else { panic!("{waiting:?}") };
    let mut found: Vec<(u32, f32)> = grippers.iter().map(|t| (t.index, t.position[0])).collect();
    found.sort_by_key(|(index, _)| *index);
    assert_eq!((*input, found), (9_999, vec![(0, 7.0), (1, 7.5)]));
}

#[test]
fn the_order_of_other_messages_stays_and_their_number_is_bounded() {
    let inbox = Inbox::default();
    let step = || Message::Step { frames: 1 };
    inbox.push(read(r#"{"type":"grasp","gripper":1,"node":3}"#).unwrap()).unwrap();
    inbox.push(read(r#"{"type":"release","gripper":1}"#).unwrap()).unwrap();
    let first = inbox.take();
    assert!(matches!(first[0], Message::Grasp { node: 3, .. }));
    assert!(matches!(first[1], Message::Release { gripper: 1, .. }));
    let refused = (0..10_000).find_map(|i| inbox.push(step()).err().map(|e| (i, e)));
    let (after, error) = refused.unwrap();
    assert_eq!(after, MOST_WAITING);
    assert!(matches!(error, Error::TooFast));
}

#[test]
fn hostile_messages_are_refused_with_what_is_wrong() {
    let nested = format!(r#"{{"type":"world","world":{}"#, r#"{"a":"#.repeat(100_000));
    let many: Vec<String> =
        (0..33).map(|i| format!(r#"{{"index":{i},"position":[0,0,0]}}"#)).collect();
    let cases = [
        (String::new(), "not understood"),
        ("[]".to_owned(), "not understood"),
        (r#"{"type":"fly"}"#.to_owned(), "fly"),
        (r#"{"type":"reset","force":1}"#.to_owned(), "force"),
        (r#"{"type":"move","grippers":[{"index":-1,"position":[0,0,0]}]}"#.to_owned(), "-1"),
        (r#"{"type":"move","grippers":[{"index":0,"position":[0,0]}]}"#.to_owned(), "length"),
        (r#"{"type":"move","grippers":[{"index":0,"position":[1e39,0,0]}]}"#.to_owned(), "100 m"),
        (
            r#"{"type":"move","grippers":[{"index":0,"position":[0,0,0],"orientation":[0,0,0,0]}]}"#
                .to_owned(),
            "quaternion",
        ),
        (format!(r#"{{"type":"move","grippers":[{}]}}"#, many.join(",")), "more than 32"),
        (r#"{"type":"grasp","gripper":0,"node":1,"radius_m":-1}"#.to_owned(), "radius_m"),
        (r#"{"type":"speed","factor":1e9}"#.to_owned(), "factor"),
        (r#"{"type":"goal","targets":[]}"#.to_owned(), "targets"),
        (r#"{"type":"world","world":{"weather":1}}"#.to_owned(), "weather"),
        (nested, "not understood"),
    ];
    for (text, names) in cases {
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains(names), "{}: {error}", &text[..text.len().min(80)]);
    }
}
