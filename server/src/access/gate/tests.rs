use std::{sync::Arc, time::Duration};

use axum::http::{HeaderValue, header};
use bendtwin_store::{ManualClock, NewKey, Options, Quotas};

use super::*;

#[tokio::test]
async fn keys_and_sign_ins_end_at_their_time_and_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let clock = Arc::new(ManualClock::default());
    let options = Options { clock: clock.clone(), ..Options::new(folder.path().join("data")) };
    let store = Store::open(options).await.unwrap();
    let ring = KeyRing::new(store.clone(), Quotas::default());
    let gate = Gate::new(Some("the token"), ring, store.clone());
    let session = Duration::from_secs(3600);
    for (person, reason) in [(Some("issuer 1"), "SIGN_IN_ENDED"), (None, "KEY_EXPIRED")] {
        let made = key::make().unwrap();
        let new = NewKey {
            id: made.id,
            display_name: "a key".to_owned(),
            owner: "ada".to_owned(),
            hash: made.hash,
            scopes: vec!["twins:read".to_owned()],
            quotas: Quotas::default(),
            expires: Some(store.now() + session),
            signed_in_as: person.map(str::to_owned),
        };
        let key = store.keys().create(new).await.unwrap();
        gate.keys.learn(&key);
        let shown = HeaderValue::try_from(format!("Bearer {}", made.text)).unwrap();
        let headers = HeaderMap::from_iter([(header::AUTHORIZATION, shown)]);
        clock.advance(session - Duration::from_millis(1));
        let caller = gate.identify(&headers).await.ok().unwrap();
        assert_eq!((caller.key, &*caller.owner), (Some(made.id), "ada"));
        clock.advance(Duration::from_millis(1));
        assert_eq!(gate.identify(&headers).await.err().unwrap().reason(), reason);
    }
}
