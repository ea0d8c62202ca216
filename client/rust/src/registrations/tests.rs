use bendtwin_proto::v1::{self, observation::Tracks};

use super::*;

#[test]
fn what_was_seen_is_sent() {
    let points = [[0.0, 0.0, 1.0], [0.0, 0.5, 1.0]];
    let seen = Observation::nodes(&points, &[3, 1]).weights(&[1.0, 0.5]).cameras(&[[0.0; 3]]);
    let twin = TwinId::generate();
    let request = Registration::of(twin, seen).near().noise_m(0.002).controls(&points).request;
    let observation = request.observation.unwrap();
    assert_eq!(request.twin, twin.to_string());
    assert_eq!(observation.points.unwrap().unpack_points("p").unwrap().1, points);
    assert!(matches!(observation.tracks, Some(Tracks::Nodes(_))));
    assert_eq!(observation.weights.unwrap().shape, [2]);
    assert!(observation.velocities.is_none());
    let options = request.options.unwrap();
    assert!(options.near && options.noise_m == Some(0.002) && options.give.is_none());

    let tracked: v1::Observation = Observation::tracks(&points, &points, &[]).into();
    let Some(Tracks::Places(places)) = tracked.tracks else { panic!("no places") };
    assert!(places.points.is_some() && places.node_positions.is_none());
}

#[test]
fn a_registered_state_is_read() {
    let state = State {
        positions: vec![[1.0; 3], [2.0; 3]],
        velocities: vec![[0.0; 3]; 2],
        controls: vec![[3.0; 3]],
        ..State::default()
    };
    let wire = RegisteredState {
        state: Some(GivenState::from(&state)),
        after: Some(v1::Residual { median_mm: 2.0, ..v1::Residual::default() }),
        motion: vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        ..RegisteredState::default()
    };
    let found = Registered::try_from(wire.clone()).unwrap();
    assert_eq!(found.state, state);
    assert_eq!(found.after.median_mm, 2.0);
    let short = RegisteredState { motion: vec![0.0; 3], ..wire };
    assert_eq!(Registered::try_from(short).unwrap_err().reason(), "MALFORMED_REPLY");
}
