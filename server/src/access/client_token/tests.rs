use super::*;

fn shows(authorization: &str) -> HeaderMap {
    let value = HeaderValue::from_str(authorization).unwrap();
    HeaderMap::from_iter([(header::AUTHORIZATION, value)])
}

/// True if a request with these headers shows the token.
fn passes(expected: &ClientToken, headers: &HeaderMap) -> bool {
    shown(headers).is_some_and(|text| expected.matches(&text))
}

#[test]
fn the_token_is_made_once_and_is_for_the_owner_alone() {
    let folder = tempfile::tempdir().unwrap();
    let token = load(folder.path()).unwrap();
    assert!(is_token(&token), "{token}");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let open = std::fs::Permissions::from_mode(0o644);
        std::fs::set_permissions(path(folder.path()), open).unwrap();
        assert_eq!(load(folder.path()).unwrap(), token);
        let mode = std::fs::metadata(path(folder.path())).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }
    assert_eq!(load(folder.path()).unwrap(), token);
    // Half a file is no token.
    std::fs::write(path(folder.path()), "abc\n").unwrap();
    let new = load(folder.path()).unwrap();
    assert!(is_token(&new) && new != token);
}

#[test]
fn it_is_shown_as_bearer_or_as_a_password() {
    let token = "0123456789abcdef0123456789abcdef";
    let expected = ClientToken::new(token);
    let basic = |text: &str| format!("Basic {}", BASE64_STANDARD.encode(text));
    for good in
        [format!("Bearer {token}"), format!("bearer  {token}"), basic(&format!("x:{token}"))]
    {
        assert!(passes(&expected, &shows(&good)), "{good}");
    }
    for bad in [
        token.to_owned(),
        "Bearer".to_owned(),
        "Bearer x".to_owned(),
        format!("Digest {token}"),
        basic(token),
        basic(&format!("{token}:")),
        "Basic %".to_owned(),
    ] {
        assert!(!passes(&expected, &shows(&bad)), "{bad}");
    }
    assert!(!passes(&expected, &HeaderMap::new()));
}

#[test]
fn a_websocket_shows_it_among_its_protocols() {
    let token = "0123456789abcdef0123456789abcdef";
    let expected = ClientToken::new(token);
    let asks = |protocols: &str| {
        let value = HeaderValue::from_str(protocols).unwrap();
        passes(&expected, &HeaderMap::from_iter([(header::SEC_WEBSOCKET_PROTOCOL, value)]))
    };
    assert!(asks(&format!("bendtwin.play.v1, bendtwin.token, {token}")));
    assert!(!asks(&format!("bendtwin.play.v1, {token}")));
    assert!(!asks(&format!("{token}, bendtwin.token")));
    assert!(!asks("bendtwin.token, 0123456789abcdef0123456789abcdee"));
}

/// A fleet has one token, which no server makes.
#[test]
fn a_token_of_others_is_read_and_never_made() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("token");
    assert!(read(&file).is_err() && !file.exists());
    std::fs::write(&file, "short").unwrap();
    assert_eq!(read(&file).unwrap_err(), "its content is no token");
    let token = "0123456789abcdef0123456789abcdef";
    std::fs::write(&file, format!("{token}\n")).unwrap();
    assert_eq!(read(&file).unwrap(), token);
}
