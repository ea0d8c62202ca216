use super::*;
use crate::v1::{CreateKeyResponse, Key};

#[test]
fn a_reply_without_the_name_of_what_was_made_is_an_error() {
    let mut routes = RPCS.iter().flat_map(|rpc| rpc.routes);
    let route = routes.find(|route| (route.method, route.path) == ("POST", "/v1/keys")).unwrap();
    let write = route.messages.as_ref().unwrap().write;
    let named = Key { name: "keys/1".to_owned(), ..Key::default() };
    let made = |key| write(&CreateKeyResponse { key, ..Default::default() }.encode_to_vec());
    assert_eq!(made(Some(named)).unwrap().made.as_deref(), Some("keys/1"));
    assert!(made(None).is_err());
}
