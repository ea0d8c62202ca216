use bendtwin_engine::model::State;

use super::*;

fn start(x: f32) -> Start {
    let state = State { positions: vec![[x, 0.0, 0.0]], ..State::default() };
    Start::new(Arc::new(state), Arc::default())
}

fn session(slots: usize, idle: Duration) -> Session {
    let setup = Setup {
        twin: TwinId::generate(),
        owner: String::new(),
        capture: String::new(),
        fidelity: v1::Fidelity::Exact,
        world: None,
        grasps: Vec::new(),
        idle,
    };
    Session::new(setup, (0..slots).map(|i| start(i as f32)).collect(), None)
}

fn places(session: &Session) -> Vec<f32> {
    let all: Vec<usize> = (0..session.slots()).collect();
    session.states(&all).0.iter().map(|s| s.state.positions[0][0]).collect()
}

#[test]
fn slots_are_advanced_forked_and_reset() {
    let session = session(3, Duration::from_secs(60));
    session.commit(&[2, 0], vec![start(7.0), start(8.0)], 5);
    assert_eq!(places(&session), [8.0, 1.0, 7.0]);
    assert_eq!(session.describe("workers/w").frames, [5, 0, 5]);
    session.commit(&[2], vec![start(9.0)], 1);
    session.fork(2, &[0, 1]);
    assert_eq!(places(&session), [9.0; 3]);
    assert_eq!(session.describe("").frames, [6; 3]);
    session.reset(&[1], None);
    session.reset(&[0], Some(vec![start(-1.0)]));
    assert_eq!(places(&session), [-1.0, 1.0, 9.0]);
    assert_eq!(session.describe("").frames, [0, 0, 6]);
}

#[test]
fn slots_that_are_not_there_are_refused() {
    let session = session(2, Duration::from_secs(60));
    assert_eq!(session.chosen(&[], [1]).unwrap(), [1]);
    assert_eq!(session.chosen(&[1, 0, 1], []).unwrap(), [1, 0, 1]);
    assert_eq!(session.distinct(&[1, 0], []).unwrap(), [1, 0]);
    let error = session.distinct(&[1, 0, 1], []).unwrap_err().to_string();
    assert!(error.contains("slot 1 twice"), "{error}");
    let error = session.chosen(&[0, 2], []).unwrap_err().to_string();
    assert!(error.contains("slot 2 of 2"), "{error}");
}

#[test]
fn an_unused_session_ends_and_says_so() {
    use bendtwin_core::Problem as _;

    let sessions = Sessions::default();
    let kept = sessions.add(session(1, Duration::from_secs(3600))).unwrap();
    let ended = sessions.add(session(1, Duration::ZERO)).unwrap();
    std::thread::sleep(Duration::from_millis(2));
    let held = sessions.list();
    assert_eq!(held.len(), 1);
    assert_eq!(
        (&held[0].session, &held[0].twin),
        (&kept.id.to_string(), &kept.setup.twin.to_string())
    );
    assert_eq!((held[0].slots, held[0].grasps), (1, 0));
    let error = sessions.get(&ended.id.to_string()).err().unwrap();
    assert_eq!(error.reason(), "SESSION_LOST");
    assert!(sessions.get(&kept.id.to_string()).is_ok());
    sessions.close(kept.id);
    assert!(sessions.get(&kept.id.to_string()).is_err());
}

#[tokio::test]
async fn a_session_that_is_advanced_does_not_end() {
    let sessions = Sessions::default();
    let session = sessions.add(session(1, Duration::ZERO)).unwrap();
    let turn = session.begin_advance().await;
    std::thread::sleep(Duration::from_millis(2));
    assert_eq!(sessions.list().len(), 1);
    drop(turn);
    assert!(sessions.list().is_empty());
}

#[test]
fn there_is_a_most_of_sessions() {
    let sessions = Sessions::default();
    for _ in 0..MOST {
        sessions.add(session(1, Duration::from_secs(60))).unwrap();
    }
    assert!(sessions.add(session(1, Duration::from_secs(60))).is_err());
}

#[test]
fn idle_times_have_bounds() {
    assert_eq!(idle(0.0).unwrap(), Duration::from_secs_f64(IDLE_S));
    assert_eq!(idle(1.5).unwrap(), Duration::from_millis(1500));
    for wrong in [-1.0, 0.5, 1e9, f64::NAN] {
        assert!(idle(wrong).is_err(), "{wrong}");
    }
}
