use std::collections::HashSet;

use bendtwin_core::ids::{TwinId, WorkerId};

use super::{BUSY, Candidate, Choice, FAIR, NEAR_S, choose};

fn idle(n: usize) -> Vec<Candidate> {
    let new = || Candidate {
        worker: WorkerId::generate(),
        usable: true,
        warm: false,
        has_room: true,
        ahead_s: 0.0,
        calls: 0,
        has_fit: false,
    };
    std::iter::repeat_with(new).take(n).collect()
}

#[test]
fn warm_workers_first() {
    let twin = TwinId::generate();
    let mut workers = idle(5);
    workers[3].warm = true;
    assert_eq!(choose(twin, &workers), Choice::Worker(3));
    workers[3].usable = false;
    assert_ne!(choose(twin, &workers), Choice::Worker(3));
}

#[test]
fn a_lost_worker_moves_only_its_own_twins() {
    let mut workers = idle(4);
    let twins: Vec<TwinId> = std::iter::repeat_with(TwinId::generate).take(200).collect();
    let before: Vec<Choice> = twins.iter().map(|t| choose(*t, &workers)).collect();
    let used: HashSet<_> = before.iter().map(|c| format!("{c:?}")).collect();
    assert_eq!(used.len(), 4);
    workers[1].usable = false;
    for (twin, before) in twins.iter().zip(before) {
        let after = choose(*twin, &workers);
        assert!(after == before || before == Choice::Worker(1));
    }
}

#[test]
fn one_popular_twin_spreads_and_is_refused_when_all_are_full() {
    let twin = TwinId::generate();
    let mut workers = idle(3);
    workers[0].warm = true;
    for done in 0..15_u32 {
        let Choice::Worker(i) = choose(twin, &workers) else { panic!("room is left") };
        let ahead = workers[i].ahead_s;
        assert!(ahead <= (FAIR * f64::from(done) * 10.0 / 3.0).max(NEAR_S), "{ahead}");
        workers[i].ahead_s += 10.0;
    }
    workers.iter_mut().for_each(|w| w.has_room = false);
    assert_eq!(choose(twin, &workers), Choice::AllFull);
    assert_eq!(choose(twin, &[]), Choice::NoneThere);
}

#[test]
fn work_counts_and_not_the_number_of_rollouts() {
    let twin = TwinId::generate();
    let mut workers = idle(2);
    // One large rollout weighs more than many small ones.
    (workers[0].warm, workers[0].ahead_s) = (true, 100.0);
    (workers[1].warm, workers[1].ahead_s) = (true, 2.0);
    assert_eq!(choose(twin, &workers), Choice::Worker(1));
    // A moment's work is no reason to load the twin elsewhere.
    workers[1].warm = false;
    workers[0].ahead_s = 0.9;
    workers[1].ahead_s = 0.0;
    assert_eq!(choose(twin, &workers), Choice::Worker(0));
    workers[0].has_room = false;
    assert_eq!(choose(twin, &workers), Choice::Worker(1));
}

#[test]
fn an_idle_worker_is_asked_before_one_with_a_fit_and_that_before_a_busy_one() {
    let twin = TwinId::generate();
    let mut workers = idle(2);
    (workers[0].warm, workers[0].has_fit) = (true, true);
    assert_eq!(choose(twin, &workers), Choice::Worker(1));
    // One rollout at a worker without a fit is less than a fit.
    workers[1].calls = 1;
    assert_eq!(choose(twin, &workers), Choice::Worker(1));
    // With as much to do at both, the twin stays where it is loaded.
    workers[1].calls = BUSY;
    assert_eq!(choose(twin, &workers), Choice::Worker(0));
    workers[0].calls = 1;
    assert_eq!(choose(twin, &workers), Choice::Worker(1));
    // Where all run fits, the one that has it loaded.
    workers.iter_mut().for_each(|w| (w.has_fit, w.calls) = (true, 0));
    assert_eq!(choose(twin, &workers), Choice::Worker(0));
}

#[test]
fn the_first_calls_of_a_hot_twin_spread_evenly_and_few_calls_stay_together() {
    let twin = TwinId::generate();
    let mut workers = idle(4);
    let first = choose(twin, &workers);
    let Choice::Worker(home) = first else { panic!("all are idle") };
    for _ in 0..8 {
        let Choice::Worker(i) = choose(twin, &workers) else { panic!("room is left") };
        workers[i].calls += 1;
    }
    assert!(workers.iter().all(|w| w.calls == 2), "{workers:?}");
    // Once they are loaded everywhere, a lone closed loop still stays at one.
    workers.iter_mut().for_each(|w| (w.calls, w.warm) = (0, true));
    workers[home].calls = 1;
    assert_eq!(choose(twin, &workers), first);
}
