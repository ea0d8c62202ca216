//! Sign-in of people: with a stand-in for the identity provider, which is also hostile, slow, or away.
//! A real one is in `console/stories/sign_in.story.ts`.

mod limits;
pub(super) mod provider;

use std::{
    os::unix::fs::PermissionsExt as _,
    time::{Duration, Instant},
};

use bendtwin_server::{ClientTokenPolicy, SignIn};
use jiff::Timestamp;
use serde_json::{Value, json};

use self::provider::{Key, Provider, unsigned};
use super::keys::make;
use crate::harness::{Server, read};

/// 256 bits in base64url.
pub(super) const NONCE: &str = "nnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnn";
pub(super) const VERIFIER: &str = "vvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvvv";
const STATE: &str = "sssssssssssssssssssssssssssssssssssssssssss";

/// A server at which people of a group may read twins.
pub(super) async fn server(provider: &Provider, change: impl FnOnce(&mut SignIn)) -> Server {
    let mut sign_in = SignIn::new(&provider.url, "bendtwin", "https://twin.example");
    sign_in.groups_claim = Some("groups".to_owned());
    sign_in.groups.insert("lab".to_owned(), vec!["twins:read".to_owned()]);
    change(&mut sign_in);
    Server::start_with(|options| {
        options.client_token = ClientTokenPolicy::Required;
        options.allowed_hosts = vec!["twin.example".to_owned()];
        options.sign_in = Some(sign_in);
    })
    .await
}

fn start() -> Value {
    json!({"state": STATE, "nonce": NONCE, "code_challenge": VERIFIER})
}

fn proof(nonce: &str) -> Value {
    json!({"code": "code", "code_verifier": VERIFIER, "nonce": nonce})
}

/// Signs in with a token that the provider issues. Returns status and body.
async fn sign_in(server: &Server, provider: &Provider, token: &str) -> (u16, Value) {
    provider.issue(token);
    server.post("/v1/sign-in", proof(NONCE)).await
}

/// The key of a person who has signed in.
async fn signed_in(server: &Server, provider: &Provider) -> (String, String) {
    let token = provider.key.sign(&provider.claims(NONCE));
    let (status, made) = sign_in(server, provider, &token).await;
    assert_eq!(status, 201, "{made}");
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    (text(&made["key"]["name"]), text(&made["secret_key"]))
}

async fn get(server: &Server, path: &str, key: &str) -> (u16, Value) {
    read(server.http.get(server.url(path)).bearer_auth(key).send().await.unwrap()).await
}

#[tokio::test]
async fn a_person_signs_in_works_and_signs_out() {
    let provider = Provider::start().await;
    let server = server(&provider, |o| o.display_name = "the lab".to_owned()).await;
    let (_, offered) = server.get("/v1/sign-in").await;
    let expected = json!({
        "enabled": true, "display_name": "the lab", "public_url": "https://twin.example",
    });
    assert_eq!(offered, expected);
    let (status, started) = server.post("/v1/sign-in/start", start()).await;
    assert_eq!(status, 200, "{started}");
    let address: reqwest::Url = started["authorization_url"].as_str().unwrap().parse().unwrap();
    assert!(address.as_str().starts_with(&format!("{}/authorize?tenant=1&", provider.url)));
    let given: Vec<_> = address.query_pairs().into_owned().collect();
    for (name, value) in [
        ("response_type", "code"),
        ("client_id", "bendtwin"),
        ("redirect_uri", "https://twin.example/sign-in"),
        ("scope", "openid email profile"),
        ("state", STATE),
        ("nonce", NONCE),
        ("code_challenge", VERIFIER),
        ("code_challenge_method", "S256"),
    ] {
        assert!(given.contains(&(name.to_owned(), value.to_owned())), "{name}: {given:?}");
    }

    let (name, key) = signed_in(&server, &provider).await;
    let form = provider.with(|answers| answers.forms.pop().unwrap());
    for field in [
        "grant_type=authorization_code",
        "code=code",
        "client_id=bendtwin",
        "redirect_uri=https%3A%2F%2Ftwin.example%2Fsign-in",
        &format!("code_verifier={VERIFIER}"),
    ] {
        assert!(form.split('&').any(|given| given == field), "{field}: {form}");
    }
    let (_, caller) = get(&server, "/v1/caller", &key).await;
    assert_eq!(caller["owner"], "ada@example.org", "{caller}");
    assert_eq!(caller["scopes"], json!(["twins:read"]));
    assert_eq!((&caller["key"], &caller["is_sign_in"]), (&json!(name), &json!(true)));
    let end: Timestamp = caller["expire_time"].as_str().unwrap().parse().unwrap();
    let hours = end.duration_since(Timestamp::now()).as_secs_f64() / 3600.0;
    assert!((11.9..=12.0).contains(&hours), "{hours}");
    assert_eq!(get(&server, "/v1/twins", &key).await.0, 200);
    assert_eq!(get(&server, "/v1/keys", &key).await.1["reason"], "SCOPE_MISSING");
    let token = server.handle.client_token().unwrap();
    let (_, keys) = get(&server, "/v1/keys", token).await;
    assert_eq!(keys["keys"][0]["is_sign_in"], true, "{keys}");

    let leave = server.http.delete(server.url("/v1/sign-in")).bearer_auth(&key);
    assert_eq!(leave.send().await.unwrap().status(), 204);
    let (status, refused) = get(&server, "/v1/twins", &key).await;
    assert_eq!((status, &refused["reason"]), (401, &json!("SIGN_IN_ENDED")), "{refused}");
    assert!(refused["detail"].as_str().unwrap().contains("bendtwin login"), "{refused}");
}

#[tokio::test]
async fn signing_out_leaves_other_keys_alone() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    let order = json!({"display_name": "robot", "scopes": ["twins:read"]});
    let (_, key) = make(&server, order).await;
    let leave = server.http.delete(server.url("/v1/sign-in")).bearer_auth(&key);
    assert_eq!(leave.send().await.unwrap().status(), 204);
    let (status, caller) = get(&server, "/v1/caller", &key).await;
    assert_eq!((status, &caller["is_sign_in"]), (200, &json!(false)), "{caller}");
}

#[tokio::test]
async fn an_administrator_revokes_a_sign_in() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    let (name, first) = signed_in(&server, &provider).await;
    let (_, second) = signed_in(&server, &provider).await;
    let revoke = async |key: &str| {
        let request = server.http.delete(server.url(&format!("/v1/{name}"))).bearer_auth(key);
        read(request.send().await.unwrap()).await
    };
    assert_eq!(revoke(&second).await.1["reason"], "SCOPE_MISSING");
    let token = server.handle.client_token().unwrap().to_owned();
    assert_eq!(revoke(&token).await.0, 204);
    assert_eq!(get(&server, "/v1/twins", &first).await.1["reason"], "SIGN_IN_ENDED");
    assert_eq!(get(&server, "/v1/twins", &second).await.0, 200);
}

#[tokio::test]
async fn a_change_of_groups_ends_earlier_sign_ins() {
    let provider = Provider::start().await;
    let server = server(&provider, |o| {
        o.groups
            .insert("makers".to_owned(), vec!["twins:read".to_owned(), "fits:read:own".to_owned()]);
    })
    .await;
    let as_member = async |groups: Value| {
        let mut claims = provider.claims(NONCE);
        claims["groups"] = groups;
        let (status, made) = sign_in(&server, &provider, &provider.key.sign(&claims)).await;
        assert_eq!(status, 201, "{made}");
        made["secret_key"].as_str().unwrap().to_owned()
    };
    let maker = as_member(json!(["lab", "makers"])).await;
    let again = as_member(json!(["makers"])).await;
    for key in [&maker, &again] {
        assert_eq!(get(&server, "/v1/fits", key).await.0, 200);
    }
    let member = as_member(json!(["lab"])).await;
    for key in [&maker, &again] {
        assert_eq!(get(&server, "/v1/fits", key).await.1["reason"], "SIGN_IN_ENDED");
    }
    assert_eq!(get(&server, "/v1/twins", &member).await.0, 200);
    assert_eq!(get(&server, "/v1/fits", &member).await.1["reason"], "SCOPE_MISSING");
}

#[tokio::test]
async fn people_reach_what_their_projects_share() {
    let provider = Provider::start().await;
    let server = server(&provider, |o| {
        o.groups.insert("lab".to_owned(), vec!["captures:read:own".to_owned()]);
    })
    .await;
    let (_, bob) =
        make(&server, json!({"display_name": "bob", "scopes": ["captures:write"]})).await;
    let upload = server.http.post(server.url("/v1/captures")).bearer_auth(&bob).body("archive");
    let (status, capture) = read(upload.send().await.unwrap()).await;
    assert_eq!(status, 201, "{capture}");
    let path = format!("/v1/{}", capture["name"].as_str().unwrap());
    let (_, ada) = signed_in(&server, &provider).await;
    assert_eq!(get(&server, &path, &ada).await.1["reason"], "NOT_OWNER");
    let token = server.handle.client_token().unwrap();
    let order = json!({"display_name": "ropes", "members": ["ada@example.org", "bob"]});
    let made = server.http.post(server.url("/v1/projects")).bearer_auth(token).json(&order);
    let (_, project) = read(made.send().await.unwrap()).await;
    assert_eq!(get(&server, &path, &ada).await.0, 200);
    let project = server.url(&format!("/v1/{}", project["name"].as_str().unwrap()));
    let leave = server.http.patch(project).bearer_auth(token);
    let leave = leave.json(&json!({"remove_members": ["ada@example.org"]}));
    assert_eq!(leave.send().await.unwrap().status(), 200);
    assert_eq!(get(&server, &path, &ada).await.1["reason"], "NOT_OWNER");
}

#[tokio::test]
async fn tokens_that_are_not_right_in_every_way_are_refused() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    let now = Timestamp::now().as_second();
    let without = |name: &str| {
        let mut claims = provider.claims(NONCE);
        claims.as_object_mut().unwrap().remove(name);
        claims
    };
    let with = |name: &str, value: Value| {
        let mut claims = provider.claims(NONCE);
        claims[name] = value;
        claims
    };
    let claims = [
        ("another issuer", with("iss", json!("https://evil.example"))),
        ("issuers", with("iss", json!([provider.url, "https://evil.example"]))),
        ("no issuer", without("iss")),
        ("another client", with("aud", json!("other"))),
        ("no client", without("aud")),
        ("several clients", with("aud", json!(["bendtwin", "other"]))),
        ("another authorized party", with("azp", json!("other"))),
        ("expired", with("exp", json!(now - 61))),
        ("no end", without("exp")),
        ("an end in words", with("exp", json!("9999999999"))),
        ("not valid yet", with("nbf", json!(now + 120))),
        ("old", with("iat", json!(now - 3600))),
        ("of the future", with("iat", json!(now + 120))),
        ("no time", without("iat")),
        ("another nonce", with("nonce", json!(VERIFIER))),
        ("no nonce", without("nonce")),
        ("nobody", with("sub", json!(""))),
        ("no subject", without("sub")),
    ];
    let right = provider.claims(NONCE);
    let stranger = Key::new("first");
    let (unknown, good) = (Key::new("unknown"), provider.key.sign(&right));
    let (text, signature) = good.rsplit_once('.').unwrap();
    let none = unsigned(&json!({"alg": "none", "kid": "first"}), &right);
    let critical = unsigned(&json!({"alg": "ES256", "kid": "first", "crit": ["exp"]}), &right);
    let tokens = [
        ("signed by another", stranger.sign(&right)),
        ("of an unknown key", unknown.sign(&right)),
        ("a symmetric signature", provider.key.sign_with_public_key(&right)),
        ("none", format!("{none}.")),
        ("none with a signature", format!("{none}.{signature}")),
        ("critical", format!("{critical}.{signature}")),
        ("no signature", format!("{text}.")),
        ("two parts", text.to_owned()),
        ("empty", String::new()),
        ("words", "not a token".to_owned()),
        (
            "other claims",
            format!(
                "{}.{signature}",
                unsigned(&json!({"alg": "ES256", "kid": "first"}), &with("sub", json!("root")))
            ),
        ),
    ];
    let signed = claims.map(|(what, claims)| (what, provider.key.sign(&claims)));
    for (what, token) in signed.into_iter().chain(tokens) {
        let (status, refused) = sign_in(&server, &provider, &token).await;
        let reason = &refused["reason"];
        assert_eq!((status, reason), (403, &json!("SIGN_IN_TOKEN_INVALID")), "{what}: {refused}");
        assert!(!refused.to_string().contains(signature), "{what}: {refused}");
    }
    let (status, made) = sign_in(&server, &provider, &good).await;
    assert_eq!(status, 201, "{made}");
    // The nonce of another browser.
    let (_, refused) = server.post("/v1/sign-in", proof(STATE)).await;
    assert_eq!(refused["reason"], "SIGN_IN_TOKEN_INVALID");
}

#[tokio::test]
async fn unknown_keys_make_the_server_read_keys_once_a_minute() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    signed_in(&server, &provider).await;
    assert_eq!(provider.with(|answers| answers.key_readings), 1);
    // The provider has a new key.
    let second = Key::new("second");
    provider.with(|answers| answers.published = vec![second.clone()]);
    let token = second.sign(&provider.claims(NONCE));
    assert_eq!(sign_in(&server, &provider, &token).await.0, 201);
    for n in 0..20 {
        let token = Key::new(&format!("unknown {n}")).sign(&provider.claims(NONCE));
        let (_, refused) = sign_in(&server, &provider, &token).await;
        assert_eq!(refused["reason"], "SIGN_IN_TOKEN_INVALID");
    }
    assert_eq!(provider.with(|answers| answers.key_readings), 2);
}

#[tokio::test]
async fn a_failed_reading_of_keys_does_not_defer_the_next_for_a_minute() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    signed_in(&server, &provider).await;
    let second = Key::new("second");
    provider.with(|answers| {
        answers.published = vec![second.clone()];
        answers.key_status = 503;
    });
    let token = second.sign(&provider.claims(NONCE));
    let (_, refused) = sign_in(&server, &provider, &token).await;
    assert_eq!(refused["reason"], "SIGN_IN_PROVIDER_AWAY", "{refused}");
    provider.with(|answers| answers.key_status = 200);
    tokio::time::sleep(Duration::from_millis(5100)).await;
    let (status, made) = sign_in(&server, &provider, &token).await;
    assert_eq!(status, 201, "{made}");
}

#[tokio::test]
async fn a_wrong_issuer_is_named() {
    let provider = Provider::start().await;
    let server = server(&provider, |o| o.issuer.push_str("/other")).await;
    let (status, refused) = server.post("/v1/sign-in/start", start()).await;
    assert_eq!((status, &refused["reason"]), (409, &json!("SIGN_IN_PROVIDER_UNUSABLE")));
    let detail = refused["detail"].as_str().unwrap();
    assert!(detail.contains("compare sign_in.issuer"), "{detail}");
}

#[tokio::test]
async fn documents_of_the_provider_are_not_trusted() {
    type Change = fn(&mut Value);
    let cases: [(&str, Change); 7] = [
        ("another issuer", |d| d["issuer"] = json!("https://evil.example")),
        ("keys without TLS", |d| d["jwks_uri"] = json!("http://evil.example/keys")),
        ("a service of this machine", |d| d["token_endpoint"] = json!("http://127.0.0.1:9/token")),
        ("an address without a name", |d| {
            d["userinfo_endpoint"] = json!("https://169.254.169.254/latest");
        }),
        ("a script", |d| d["authorization_endpoint"] = json!("javascript:alert(1)")),
        ("no endpoint", |d| drop(d.as_object_mut().unwrap().remove("token_endpoint"))),
        ("huge", |d| d["padding"] = json!("x".repeat(1 << 20))),
    ];
    for (what, change) in cases {
        let provider = Provider::start().await;
        provider.with(|answers| change(&mut answers.discovery));
        let server = server(&provider, |_| ()).await;
        let (status, refused) = server.post("/v1/sign-in/start", start()).await;
        let reason = &refused["reason"];
        assert_eq!(
            (status, reason),
            (409, &json!("SIGN_IN_PROVIDER_UNUSABLE")),
            "{what}: {refused}"
        );
    }
}

#[tokio::test]
async fn keys_are_accepted_while_the_provider_hangs_or_is_away() {
    let provider = Provider::start().await;
    provider.with(|answers| answers.hangs = true);
    let server = server(&provider, |_| ()).await;
    let begun = Instant::now();
    let starting = server.post("/v1/sign-in/start", start());
    let also = server.post("/v1/sign-in/start", start());
    let token = server.handle.client_token().unwrap();
    let working = async {
        assert_eq!(get(&server, "/v1/twins", token).await.0, 200);
        begun.elapsed()
    };
    let (first, second, worked) = tokio::join!(starting, also, working);
    assert!(worked < Duration::from_secs(5), "{worked:?}");
    // Both had one answer: the second did not wait for another.
    assert!(begun.elapsed() < Duration::from_secs(18), "{:?}", begun.elapsed());
    for (status, refused) in [first, second] {
        let reason = &refused["reason"];
        assert_eq!((status, reason), (503, &json!("SIGN_IN_PROVIDER_AWAY")), "{refused}");
    }
}

#[tokio::test]
async fn what_the_provider_says_is_passed_on_as_plain_text() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    let said = format!("<b>no</b>\u{1b}[31m\n{}", "x".repeat(1000));
    let body = json!({"error": "invalid_grant", "error_description": said});
    provider.with(|answers| answers.token = (400, body));
    let (status, refused) = server.post("/v1/sign-in", proof(NONCE)).await;
    assert_eq!((status, &refused["reason"]), (403, &json!("SIGN_IN_REFUSED")), "{refused}");
    let detail = refused["detail"].as_str().unwrap();
    assert!(detail.contains("invalid_grant (<b>no</b>[31mxxx"), "{detail}");
    assert!(detail.len() < 300 && !detail.contains(char::is_control), "{detail}");
    for error in ["invalid_client", "unauthorized_client"] {
        provider.with(|answers| answers.token = (401, json!({"error": error})));
        let (status, refused) = server.post("/v1/sign-in", proof(NONCE)).await;
        assert_eq!((status, &refused["reason"]), (409, &json!("SIGN_IN_CLIENT_REFUSED")));
        assert!(refused["detail"].as_str().unwrap().contains("tell the operator"), "{refused}");
    }
    provider.with(|answers| answers.token = (502, json!("gone")));
    let (status, refused) = server.post("/v1/sign-in", proof(NONCE)).await;
    assert_eq!((status, &refused["reason"]), (503, &json!("SIGN_IN_PROVIDER_AWAY")), "{refused}");
}

#[tokio::test]
async fn a_device_waits_until_it_is_confirmed() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    let (status, device) = server.post("/v1/sign-in/device", json!({})).await;
    assert_eq!(status, 200, "{device}");
    assert_eq!(device["user_code"], "ABCD-EFGH");
    assert_eq!(device["interval_s"].as_f64(), Some(5.0));
    let poll = async || {
        let request = server.http.post(server.url("/v1/sign-in"));
        let response = request.json(&json!({"device_code": "device-code"})).send().await.unwrap();
        let delay = response.headers().get("retry-after").map(|v| v.to_str().unwrap().to_owned());
        (read(response).await, delay)
    };
    for (error, delay, reason) in [
        ("authorization_pending", "5", "SIGN_IN_PENDING"),
        ("slow_down", "10", "SIGN_IN_SLOW_DOWN"),
    ] {
        provider.with(|answers| answers.token = (400, json!({"error": error})));
        let ((status, pending), retry_after) = poll().await;
        assert_eq!((status, &pending["reason"]), (409, &json!(reason)), "{pending}");
        assert_eq!(retry_after.as_deref(), Some(delay));
    }
    // There is no browser, and no nonce.
    let mut claims = provider.claims(NONCE);
    claims.as_object_mut().unwrap().remove("nonce");
    provider.issue(&provider.key.sign(&claims));
    let ((status, made), _) = poll().await;
    assert_eq!((status, &made["key"]["owner"]), (201, &json!("ada@example.org")), "{made}");
    provider.with(|answers| answers.token = (400, json!({"error": "access_denied"})));
    assert_eq!(poll().await.0.1["reason"], "SIGN_IN_REFUSED");
    provider.with(|answers| answers.device.1["verification_uri"] = json!("http://evil.example"));
    let (_, refused) = server.post("/v1/sign-in/device", json!({})).await;
    assert_eq!(refused["reason"], "SIGN_IN_PROVIDER_UNUSABLE", "{refused}");
}

#[tokio::test]
async fn claims_that_the_token_lacks_are_asked_for() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    let mut claims = provider.claims(NONCE);
    let mut person = json!({"sub": "person-1"});
    for name in ["email", "email_verified", "groups"] {
        person[name] = claims.as_object_mut().unwrap().remove(name).unwrap();
    }
    provider.with(|answers| answers.person = person.clone());
    let (status, made) = sign_in(&server, &provider, &provider.key.sign(&claims)).await;
    assert_eq!((status, &made["key"]["owner"]), (201, &json!("ada@example.org")), "{made}");
    for other in [json!("person-2"), Value::Null] {
        provider.with(|answers| answers.person["sub"] = other);
        let (_, refused) = sign_in(&server, &provider, &provider.key.sign(&claims)).await;
        assert_eq!(refused["reason"], "SIGN_IN_TOKEN_INVALID", "{refused}");
    }
}

#[tokio::test]
async fn a_secret_is_shown_as_the_provider_takes_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("secret");
    std::fs::write(&file, "s:e c&ret\n").unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
    for (methods, in_form) in [(json!(null), false), (json!(["client_secret_post"]), true)] {
        let provider = Provider::start().await;
        if !methods.is_null() {
            let name = "token_endpoint_auth_methods_supported";
            provider.with(|answers| answers.discovery[name] = methods);
        }
        let server = server(&provider, |o| o.client_secret_file = Some(file.clone())).await;
        signed_in(&server, &provider).await;
        let (form, credentials) =
            provider.with(|answers| (answers.forms.pop().unwrap(), answers.credentials.pop()));
        let is_in_form = form.contains("client_secret=s%3Ae+c%26ret");
        // `bendtwin:s%3Ae+c%26ret`
        let basic = Some("Basic YmVuZHR3aW46cyUzQWUrYyUyNnJldA==".to_owned());
        assert_eq!((is_in_form, credentials), (in_form, basic.filter(|_| !in_form)), "{form}");
    }
}

#[tokio::test]
async fn redirects_of_the_provider_are_not_followed() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    signed_in(&server, &provider).await;
    let elsewhere = Provider::start().await;
    provider.with(|answers| answers.redirect = Some(format!("{}/token", elsewhere.url)));
    let (status, refused) = server.post("/v1/sign-in", proof(NONCE)).await;
    assert_eq!((status, &refused["reason"]), (403, &json!("SIGN_IN_REFUSED")), "{refused}");
    assert!(elsewhere.with(|answers| answers.forms.is_empty()));
}

#[tokio::test]
async fn people_without_rights_are_told_so() {
    let provider = Provider::start().await;
    let server = server(&provider, |o| o.allowed_domains = vec!["example.org".into()]).await;
    for (name, value) in [
        ("email_verified", json!(false)),
        ("email", json!("ada@evil.example")),
        ("groups", json!(["others"])),
    ] {
        let mut claims = provider.claims(NONCE);
        claims[name] = value;
        let (status, refused) = sign_in(&server, &provider, &provider.key.sign(&claims)).await;
        let reason = &refused["reason"];
        assert_eq!((status, reason), (403, &json!("SIGN_IN_NOT_ALLOWED")), "{name}: {refused}");
    }
}

#[tokio::test]
async fn sign_ins_have_a_bounded_rate_and_form() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    for wrong in ["", "short", &"ä".repeat(43), &"=".repeat(43), &"x".repeat(5000)] {
        let mut order = start();
        order["state"] = json!(wrong);
        assert_eq!(server.post("/v1/sign-in/start", order).await.0, 400, "{wrong}");
        let mut order = proof(NONCE);
        order["code_verifier"] = json!(wrong);
        assert_eq!(server.post("/v1/sign-in", order).await.0, 400, "{wrong}");
    }
    let mut order = proof(NONCE);
    order["code"] = json!("x".repeat(5000));
    assert_eq!(server.post("/v1/sign-in", order).await.0, 400);
    let mut order = proof(NONCE);
    order["device_code"] = json!("device-code");
    let (status, both) = server.post("/v1/sign-in", order).await;
    assert_eq!(status, 400, "{both}");
    assert!(both["detail"].as_str().unwrap().contains("device_code"), "{both}");
    let mut refused = Value::Null;
    for _ in 0..2000 {
        let (status, answer) = server.post("/v1/sign-in/start", start()).await;
        if status != 200 {
            refused = answer;
            break;
        }
    }
    assert_eq!(refused["reason"], "SIGN_IN_BUSY", "{refused}");
    let token = server.handle.client_token().unwrap();
    assert_eq!(get(&server, "/v1/twins", token).await.0, 200);
}

#[tokio::test]
async fn other_sites_cannot_sign_anyone_in() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    let request = server.http.post(server.url("/v1/sign-in")).json(&proof(NONCE));
    let (status, refused) =
        read(request.header("origin", "https://evil.example").send().await.unwrap()).await;
    assert_eq!((status, &refused["reason"]), (403, &json!("FOREIGN_ORIGIN")), "{refused}");
    let page = server.http.get(server.url("/sign-in?code=a&state=b")).send().await.unwrap();
    assert_eq!(page.headers()["referrer-policy"], "no-referrer");
    assert!(page.headers().get("set-cookie").is_none());
    assert!(page.text().await.unwrap().contains("id=\"app\""));
}

#[tokio::test]
async fn a_server_without_a_provider_says_so() {
    let server = Server::start_with(|o| o.client_token = ClientTokenPolicy::Required).await;
    assert_eq!(server.get("/v1/sign-in").await.1["enabled"], false);
    for (path, order) in [
        ("/v1/sign-in/start", start()),
        ("/v1/sign-in/device", json!({})),
        ("/v1/sign-in", proof(NONCE)),
    ] {
        assert_eq!(server.post(path, order).await.1["reason"], "SIGN_IN_OFF", "{path}");
    }
    let token = server.handle.client_token().unwrap();
    let (_, caller) = get(&server, "/v1/caller", token).await;
    assert_eq!((caller["owner"].as_str(), caller["key"].as_str()), (Some("local"), Some("")));
}
