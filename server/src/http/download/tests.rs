use super::*;

fn of(range: &str, condition: Option<&str>) -> Part {
    let mut headers = HeaderMap::new();
    headers.insert(header::RANGE, HeaderValue::from_str(range).unwrap());
    if let Some(condition) = condition {
        headers.insert(header::IF_RANGE, HeaderValue::from_str(condition).unwrap());
    }
    part(&headers, 100, "\"tag\"")
}

#[test]
fn one_range_is_served_and_anything_else_is_the_whole() {
    for (range, expected) in [
        ("bytes=0-0", Part::Range(0..1)),
        ("bytes=0-99", Part::Range(0..100)),
        ("bytes=10-", Part::Range(10..100)),
        ("bytes=10-5000", Part::Range(10..100)),
        ("bytes=10-99999999999999999999999", Part::Range(10..100)),
        ("bytes=-7", Part::Range(93..100)),
        ("bytes=-700", Part::Range(0..100)),
        ("Bytes= 1-2", Part::Range(1..3)),
        ("bytes=100-", Part::Nothing),
        ("bytes=99999999999999999999999-", Part::Nothing),
        ("bytes=-0", Part::Nothing),
        ("bytes=2-1", Part::Whole),
        ("bytes=0-1,3-4", Part::Whole),
        ("bytes=-", Part::Whole),
        ("bytes=a-b", Part::Whole),
        ("bytes=+1-2", Part::Whole),
        ("lines=0-1", Part::Whole),
        ("0-1", Part::Whole),
    ] {
        assert_eq!(of(range, None), expected, "{range}");
    }
    assert_eq!(part(&HeaderMap::new(), 100, "\"tag\""), Part::Whole);
}

#[test]
fn a_range_of_other_content_is_not_served() {
    assert_eq!(of("bytes=1-", Some("\"tag\"")), Part::Range(1..100));
    for other in ["\"other\"", "W/\"tag\"", "Mon, 01 Jan 2024 00:00:00 GMT"] {
        assert_eq!(of("bytes=1-", Some(other)), Part::Whole, "{other}");
    }
}
