use super::*;

#[test]
fn every_file_can_be_decompressed_and_the_page_is_there() {
    for (path, media_type, _) in FILES {
        let asset = &ASSETS[path];
        assert!(crate::access::is_open(&axum::http::Method::GET, path), "{path}");
        assert!(!asset.plain().unwrap().is_empty(), "{path}");
        assert_eq!(asset.media_type, *media_type);
    }
    let page = String::from_utf8(ASSETS["/"].plain().unwrap().to_vec()).unwrap();
    // What the page loads is there.
    let loaded: Vec<_> = page.split("\"./").skip(1).filter_map(|p| p.split('"').next()).collect();
    assert!(loaded.len() >= 2, "{page}");
    for name in loaded {
        assert!(ASSETS.contains_key(format!("/{name}").as_str()), "{name}");
    }
}

#[test]
fn gzip_is_sent_to_those_who_take_it() {
    for (value, takes) in [
        ("gzip, deflate, br", true),
        ("br;q=1.0, GZIP;q=0.5", true),
        ("gzip;q=0", false),
        ("gzip; q=0.000", false),
        ("gzip;q=much", false),
        ("br", false),
        ("*", false),
        ("", false),
    ] {
        let headers = HeaderMap::from_iter([(header::ACCEPT_ENCODING, value.parse().unwrap())]);
        assert_eq!(takes_gzip(&headers), takes, "{value}");
    }
    assert!(!takes_gzip(&HeaderMap::new()));
}

#[test]
fn what_a_client_has_is_not_sent_again() {
    for (value, has) in
        [("\"a\"", true), ("W/\"a\"", true), ("\"b\", \"a\"", true), ("*", true), ("\"b\"", false)]
    {
        let headers = HeaderMap::from_iter([(header::IF_NONE_MATCH, value.parse().unwrap())]);
        assert_eq!(is_known(&headers, "\"a\""), has, "{value}");
    }
}
