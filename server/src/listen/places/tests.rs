use super::*;
use crate::listen::activity::Turn;

fn ip(text: &str) -> IpAddr {
    text.parse().unwrap()
}

#[test]
fn the_longest_quiet_connection_makes_room_and_one_at_work_never() {
    let places = Places::new("public", 3, 2, Metrics::new());
    let first = places.take(ip("10.0.0.1")).unwrap();
    let second = places.take(ip("10.0.0.1")).unwrap();
    // The share of the peer is used up: its own oldest connection goes.
    let third = places.take(ip("10.0.0.1")).unwrap();
    assert!(first.evicted.is_cancelled() && !second.evicted.is_cancelled());
    drop(first);
    // With a request at work on both, nothing can be had.
    let (at_work, waits) = (second.activity.exchange(), third.activity.exchange());
    assert!(places.take(ip("10.0.0.1")).is_none());
    // Another peer has its own share.
    let other = places.take(ip("10.0.0.2")).unwrap();
    let busy = other.activity.exchange();
    assert!(places.take(ip("10.0.0.3")).is_none());
    // A request whose body does not come makes room.
    waits.set_turn(Turn::Body);
    let last = places.take(ip("10.0.0.3")).unwrap();
    assert!(third.evicted.is_cancelled() && !last.evicted.is_cancelled());
    drop((at_work, waits, busy, last));
}

#[test]
fn places_are_given_back() {
    let places = Places::new("public", 2, 2, Metrics::new());
    for _ in 0..10 {
        let place = places.take(ip("::1")).unwrap();
        let _request = place.activity.exchange();
        let second = places.take(ip("::1")).unwrap();
        let _request = second.activity.exchange();
        assert!(places.take(ip("::1")).is_none());
    }
    assert!(places.shared.taken().by_peer.is_empty());
}

#[test]
fn a_network_of_ipv6_is_one_peer() {
    assert_eq!(network_of(ip("2001:db8::1")), network_of(ip("2001:db8::ffff:2")));
    assert_ne!(network_of(ip("2001:db8::1")), network_of(ip("2001:db8:0:1::1")));
    assert_eq!(network_of(ip("::ffff:10.0.0.1")), ip("10.0.0.1"));
}
