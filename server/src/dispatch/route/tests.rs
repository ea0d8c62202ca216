use std::collections::HashSet;

use bendtwin_core::ids::{TwinId, WorkerId};

use super::{Bounds, Candidate, Choice, choose};

const BOUNDS: Bounds = Bounds { running: 2, waiting: 3 };

fn idle(n: usize) -> Vec<Candidate> {
    let new = || Candidate { worker: WorkerId::generate(), usable: true, warm: false, load: 0 };
    std::iter::repeat_with(new).take(n).collect()
}

#[test]
fn warm_workers_first() {
    let twin = TwinId::generate();
    let mut workers = idle(5);
    workers[3].warm = true;
    assert_eq!(choose(twin, &workers, BOUNDS), Choice::Worker(3));
    workers[3].usable = false;
    assert_ne!(choose(twin, &workers, BOUNDS), Choice::Worker(3));
}

#[test]
fn a_lost_worker_moves_only_its_own_twins() {
    let mut workers = idle(4);
    let twins: Vec<TwinId> = std::iter::repeat_with(TwinId::generate).take(200).collect();
    let before: Vec<Choice> = twins.iter().map(|t| choose(*t, &workers, BOUNDS)).collect();
    let used: HashSet<_> = before.iter().map(|c| format!("{c:?}")).collect();
    assert_eq!(used.len(), 4);
    workers[1].usable = false;
    for (twin, before) in twins.iter().zip(before) {
        let after = choose(*twin, &workers, BOUNDS);
        assert!(after == before || before == Choice::Worker(1));
    }
}

#[test]
fn one_popular_twin_spreads_and_is_refused_when_all_are_full() {
    let twin = TwinId::generate();
    let mut workers = idle(3);
    workers[0].warm = true;
    for total in 0..15usize {
        let Choice::Worker(i) = choose(twin, &workers, BOUNDS) else { panic!("room is left") };
        workers[i].load += 1;
        // A quarter above the average of three, or what runs at once.
        assert!(workers[i].load <= ((total + 1) * 5).div_ceil(12).max(BOUNDS.running));
    }
    assert_eq!(choose(twin, &workers, BOUNDS), Choice::AllFull);
    assert_eq!(choose(twin, &[], BOUNDS), Choice::NoneThere);
}
