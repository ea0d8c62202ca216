use bendtwin_core::CancelToken;
use bendtwin_engine::cpu_with_threads;

use crate::strip::strip;

use super::*;

/// Distances of the middle of the far region and of the near one from their starts at the end of a
/// motion [m].
fn travelled(hold: Hold, act: Act) -> [f64; 2] {
    let twin = strip(true);
    let regions = Regions::of(&twin);
    let scene = scene(&twin, &regions, None, hold, act);
    let rollout = scene.base(&*cpu_with_threads(1), &CancelToken::default()).unwrap().unwrap();
    let nodes = twin.graph.node_count();
    let last = &rollout.positions[(scene.frames - 1) * nodes..];
    let rest = &twin.graph.rest_positions;
    [[0, 4], [76, 80]].map(|[from, to]| {
        let middle = |of: &[Point]| {
            of[from..to].iter().fold([0.0; 3], |s, p| add(s, scaled(wide(*p), 0.25)))
        };
        distance(middle(last), middle(rest))
    })
}

#[test]
fn motions_hold_what_they_say_and_move_what_they_say() {
    let [near, far] = travelled(Hold::Own, Act::Hang);
    assert!(near < 0.02 && far > 0.1, "it hangs from the hand: {near} {far}");
    let twin = strip(true);
    let last = Regions::of(&twin).far;
    let [near, far] = travelled(Hold::Region(last), Act::Hang);
    assert!(near > 0.1 && far < 0.02, "it hangs from its other end: {near} {far}");
    let [near, far] = travelled(Hold::Own, Act::Push(last));
    assert!(near < 0.02 && (far - PUSH_M).abs() < 0.01, "{near} {far}");
    let [near, far] = travelled(Hold::Own, Act::Bend(last));
    assert!(near < 0.05 && far > 0.08, "{near} {far}");
    let [near, far] = travelled(Hold::Own, Act::Pull(last));
    assert!(near < 0.05 && far > 0.01 && far < 0.03, "{near} {far}");
}
