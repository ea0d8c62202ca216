//! A batch that several workers share.

use bendtwin_contract::rollout::{Batch, split};
use prost::Message as _;

use super::*;

#[test]
fn a_batch_that_workers_share_has_the_bits_of_the_whole() {
    let mut whole = request(7);
    whole.returns = Some(Returns {
        every_frames: 2,
        final_state: true,
        diagnostics: true,
        control_gradients: true,
        ..Returns::default()
    });
    // Some succeed.
    whole.costs[0].success_at_most = Some(0.05);
    // One instance diverges: its number has to be that of the whole.
    let fast = [[0.0, 0.0, 0.6], [1e9, 0.0, 0.6]];
    let Some(Actions::Trajectories(t)) = &mut whole.actions else { panic!("trajectories") };
    let (_, mut knots) = t.positions.as_ref().unwrap().unpack::<f32>("p").unwrap();
    knots[5 * 6..6 * 6].copy_from_slice(fast.as_flattened());
    t.positions = Some(Tensor::pack(&[7, 2, 1, 3], &knots));
    let bench = Bench::new();
    let expected = bench.run(whole.clone(), 0).unwrap().remove(0);
    assert_eq!(expected.diverged.iter().map(|d| d.instance).collect::<Vec<_>>(), [5]);
    let (_, successes) = expected.successes.as_ref().unwrap().unpack::<f32>("s").unwrap();
    assert!(successes[5] == 0.0 && [0.0, 1.0].iter().all(|s| successes[..5].contains(s)));
    let batch = Batch { instances: 7, knots: 2, frames: 6 };
    for count in 1..=7 {
        // Each worker has a separate device.
        let replies = split::runs(7, count, 1).map(|run| {
            let part = split::part(&whole, &batch, run);
            Bench::new().run(part, 0).unwrap().remove(0)
        });
        let joined = split::join(replies.collect()).unwrap();
        // Bytes, for NaN equals nothing.
        assert_eq!(joined.encode_to_vec(), expected.encode_to_vec(), "{count} workers");
    }
}
