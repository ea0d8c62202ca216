use super::*;

fn request(uri: &str, headers: &[(&'static str, &str)]) -> Request<Body> {
    let builder = Request::builder().uri(uri);
    let builder = headers.iter().fold(builder, |b, (name, value)| b.header(*name, *value));
    builder.body(Body::empty()).unwrap()
}

/// Status of the refusal; 200 without one.
fn status(hosts: &Hosts, request: &Request<Body>) -> u16 {
    use axum::response::IntoResponse as _;
    hosts.check(request).map_or_else(|r| r.into_response().status().as_u16(), |()| 200)
}

#[test]
fn names_of_other_sites_are_refused_unless_they_are_allowed() {
    let (plain, named) = (Hosts::new(&[]), Hosts::new(&["Twin.example".to_owned()]));
    let any = Hosts::new(&["*".to_owned()]);
    for (host, expected) in [
        ("localhost", [200; 3]),
        ("LOCALHOST:7070", [200; 3]),
        ("127.0.0.1:1", [200; 3]),
        ("10.1.2.3", [200; 3]),
        ("[::1]:7070", [200; 3]),
        ("twin.example:7070", [403, 200, 200]),
        ("evil.example", [403, 403, 200]),
        ("localhost.evil.example", [403, 403, 200]),
        ("twin.example.evil.example", [403, 403, 200]),
        ("user@localhost", [400; 3]),
        ("", [400; 3]),
    ] {
        let by_header = request("/v1/fits", &[("host", host)]);
        assert_eq!([&plain, &named, &any].map(|h| status(h, &by_header)), expected, "{host}");
        if !host.is_empty() {
            // HTTP/2 has no such header, but an address.
            let by_address = request(&format!("http://{host}/v1/fits"), &[]);
            assert_eq!([&plain, &named, &any].map(|h| status(h, &by_address)), expected, "{host}");
        }
    }
}

#[test]
fn the_server_is_named_once() {
    let hosts = Hosts::new(&[]);
    let two = request("/", &[("host", "localhost"), ("host", "localhost")]);
    assert_eq!(status(&hosts, &two), 400);
    let same = request("http://LocalHost:7/", &[("host", "localhost:7")]);
    assert_eq!(status(&hosts, &same), 200);
    for other in ["localhost", "localhost:8", "127.0.0.1:7"] {
        let differs = request("http://localhost:7/", &[("host", other)]);
        assert_eq!(status(&hosts, &differs), 400, "{other}");
    }
    assert_eq!(status(&hosts, &request("/", &[])), 200);
}

#[test]
fn pages_of_other_sites_are_refused() {
    let hosts = Hosts::new(&[]);
    for (origin, expected) in [
        ("http://localhost:7", 200),
        ("http://LOCALHOST:7", 200),
        ("http://localhost", 403),
        ("http://evil.example", 403),
        ("null", 403),
    ] {
        let by_header = request("/", &[("host", "localhost:7"), ("origin", origin)]);
        assert_eq!(status(&hosts, &by_header), expected, "{origin}");
        let by_address = request("http://localhost:7/", &[("origin", origin)]);
        assert_eq!(status(&hosts, &by_address), expected, "{origin}");
    }
}
