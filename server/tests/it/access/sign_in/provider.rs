//! A stand-in for an identity provider, which sends what a test wants.

use std::{
    future::pending,
    sync::{Arc, Mutex},
};

use axum::{
    Json, Router,
    extract::State,
    http::{HeaderMap, StatusCode},
    response::{IntoResponse, Redirect, Response},
    routing::{get, post},
};
use base64::{Engine as _, prelude::BASE64_URL_SAFE_NO_PAD as BASE64URL};
use jiff::Timestamp;
use ring::{
    hmac,
    rand::SystemRandom,
    signature::{ECDSA_P256_SHA256_FIXED_SIGNING, EcdsaKeyPair, KeyPair as _},
};
use serde_json::{Value, json};

/// A pair of keys and its id.
#[derive(Clone)]
pub(in crate::access) struct Key {
    pair: Arc<EcdsaKeyPair>,
    id: String,
}

/// What the provider answers.
#[derive(Clone)]
pub(in crate::access) struct Answers {
    pub(super) discovery: Value,
    /// Status and body of the token endpoint.
    pub(in crate::access) token: (u16, Value),
    pub(super) device: (u16, Value),
    /// What the provider states about a person who is asked for.
    pub(super) person: Value,
    pub(super) published: Vec<Key>,
    pub(super) hangs: bool,
    /// True if the token endpoint does not answer.
    pub(super) token_hangs: bool,
    /// Status of the document with the keys.
    pub(super) key_status: u16,
    /// Times that the keys were read.
    pub(super) key_readings: usize,
    /// Forms that the token endpoint got, and the credentials in their headers.
    pub(super) forms: Vec<String>,
    pub(super) credentials: Vec<String>,
    /// Address to which the token endpoint sends those who ask.
    pub(super) redirect: Option<String>,
}

#[derive(Clone)]
pub(in crate::access) struct Provider {
    pub(super) url: String,
    pub(in crate::access) key: Key,
    answers: Arc<Mutex<Answers>>,
}

impl Key {
    pub(super) fn new(id: &str) -> Self {
        let random = SystemRandom::new();
        let algorithm = &ECDSA_P256_SHA256_FIXED_SIGNING;
        let document = EcdsaKeyPair::generate_pkcs8(algorithm, &random).unwrap();
        let pair = EcdsaKeyPair::from_pkcs8(algorithm, document.as_ref(), &random).unwrap();
        Self { pair: Arc::new(pair), id: id.to_owned() }
    }

    fn public(&self) -> Value {
        let (x, y) = self.pair.public_key().as_ref()[1..].split_at(32);
        json!({
            "kty": "EC", "crv": "P-256", "use": "sig", "alg": "ES256", "kid": self.id,
            "x": BASE64URL.encode(x), "y": BASE64URL.encode(y),
        })
    }

    /// A signed token.
    pub(in crate::access) fn sign(&self, claims: &Value) -> String {
        let text = unsigned(&json!({"alg": "ES256", "kid": self.id}), claims);
        let signature = self.pair.sign(&SystemRandom::new(), text.as_bytes()).unwrap();
        format!("{text}.{}", BASE64URL.encode(signature))
    }

    /// A token with a symmetric signature, whose secret is the public key.
    pub(super) fn sign_with_public_key(&self, claims: &Value) -> String {
        let text = unsigned(&json!({"alg": "HS256", "kid": self.id}), claims);
        let secret = hmac::Key::new(hmac::HMAC_SHA256, self.pair.public_key().as_ref());
        format!("{text}.{}", BASE64URL.encode(hmac::sign(&secret, text.as_bytes())))
    }
}

/// Head and claims of a token.
pub(super) fn unsigned(header: &Value, claims: &Value) -> String {
    let part = |part: &Value| BASE64URL.encode(part.to_string());
    format!("{}.{}", part(header), part(claims))
}

impl Provider {
    pub(in crate::access) async fn start() -> Self {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let key = Key::new("first");
        let answers = Answers {
            discovery: json!({
                "issuer": url,
                "authorization_endpoint": format!("{url}/authorize?tenant=1"),
                "token_endpoint": format!("{url}/token"),
                "jwks_uri": format!("{url}/keys"),
                "device_authorization_endpoint": format!("{url}/device"),
                "userinfo_endpoint": format!("{url}/person"),
            }),
            token: (400, json!({"error": "invalid_grant"})),
            device: (
                200,
                json!({
                    "device_code": "device-code", "user_code": "ABCD-EFGH", "expires_in": 600,
                    "verification_uri": format!("{url}/activate"),
                    "verification_uri_complete": null,
                }),
            ),
            person: json!({}),
            published: vec![key.clone()],
            hangs: false,
            token_hangs: false,
            key_status: 200,
            key_readings: 0,
            forms: Vec::new(),
            credentials: Vec::new(),
            redirect: None,
        };
        let provider = Self { url, key, answers: Arc::new(Mutex::new(answers)) };
        let router = Router::new()
            .route("/.well-known/openid-configuration", get(discovery))
            .route("/keys", get(keys))
            .route("/token", post(token))
            .route("/device", post(device))
            .route("/person", get(person))
            .with_state(provider.clone());
        tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        provider
    }

    /// Changes what it answers, or reads what it got.
    pub(in crate::access) fn with<T>(&self, change: impl FnOnce(&mut Answers) -> T) -> T {
        change(&mut self.answers.lock().unwrap())
    }

    /// Claims that are right.
    pub(in crate::access) fn claims(&self, nonce: &str) -> Value {
        let now = Timestamp::now().as_second();
        json!({
            "iss": self.url, "aud": "bendtwin", "sub": "person-1", "nonce": nonce,
            "iat": now, "exp": now + 300,
            "email": "Ada@Example.org", "email_verified": true, "groups": ["lab"],
        })
    }

    /// Answers the next requests of tokens with this one.
    pub(in crate::access) fn issue(&self, token: &str) {
        self.with(|answers| answers.token = (200, json!({"id_token": token, "access_token": "a"})));
    }
}

fn answer((status, body): (u16, Value)) -> Response {
    (StatusCode::from_u16(status).unwrap(), Json(body)).into_response()
}

async fn discovery(State(provider): State<Provider>) -> Response {
    if provider.with(|answers| answers.hangs) {
        pending::<()>().await;
    }
    answer((200, provider.with(|answers| answers.discovery.clone())))
}

async fn keys(State(provider): State<Provider>) -> Response {
    let keys: Vec<Value> = provider.with(|answers| {
        answers.key_readings += 1;
        answers.published.iter().map(Key::public).collect()
    });
    // A kind of key that the server does not know.
    let other = json!({"kty": "AKP", "alg": "ML-DSA-44", "pub": "AAAA"});
    let keys = [vec![other], keys].concat();
    answer((provider.with(|answers| answers.key_status), json!({"keys": keys})))
}

async fn token(State(provider): State<Provider>, headers: HeaderMap, form: String) -> Response {
    if provider.with(|answers| answers.token_hangs) {
        pending::<()>().await;
    }
    provider.with(|answers| {
        answers.forms.push(form);
        let credentials = headers.get("authorization").map(|value| value.to_str().unwrap());
        answers.credentials.extend(credentials.map(str::to_owned));
        match &answers.redirect {
            Some(address) => Redirect::temporary(address).into_response(),
            None => answer(answers.token.clone()),
        }
    })
}

async fn person(State(provider): State<Provider>, headers: HeaderMap) -> Response {
    assert_eq!(headers["authorization"], "Bearer a");
    answer((200, provider.with(|answers| answers.person.clone())))
}

async fn device(State(provider): State<Provider>) -> Response {
    answer(provider.with(|answers| answers.device.clone()))
}
