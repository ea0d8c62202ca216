use bendtwin_core::{Environment, Problem as _, Twin, ids::TwinId};
use bendtwin_engine::Model;
use tokio::sync::OnceCell;

use super::*;
use crate::rollout::tests::twin;

const WORK: u64 = 1_000_000_000;

fn settled(twin: Twin, work: u64) -> Result<Start, Error> {
    let backend = bendtwin_engine::cpu_with_threads(1);
    let loaded = backend.load(Arc::new(Model::from(&twin))).unwrap();
    let warm = Warm { id: TwinId::generate(), twin, loaded, fast: OnceCell::new(), _share: None };
    settle(&warm, work, backend.as_ref(), &CancelToken::default())
}

/// Four nodes of 1 kg hang below one another from springs of 500 N per unit strain and 0.1 m.
#[test]
fn a_chain_hangs_as_its_springs_say() {
    let start = settled(twin(), WORK).unwrap();
    let mut height = 0.6;
    for (node, position) in start.state.positions.iter().enumerate() {
        let carried = (4 - node) as f32;
        height -= 0.1 * (1.0 + carried * 9.81 / 500.0);
        assert!((position[2] - height).abs() < 1e-3, "{node}: {position:?}, not at {height}");
    }
    assert!(start.state.velocities.iter().all(|v| *v == [0.0; 3]));
    assert_eq!(*start.controls, [[0.0, 0.0, 0.6]]);
    assert_eq!(start.state, settled(twin(), WORK).unwrap().state, "the same bits");
}

#[test]
fn what_falls_for_ever_is_refused() {
    let mut falling = twin();
    falling.environment = Environment { ground: None, ..falling.environment };
    falling.graph.springs[0] = [0, 1];
    falling.graph.springs[1] = [1, 2];
    falling.graph.springs[2] = [2, 3];
    falling.graph.springs[3] = [0, 2];
    falling.params.rest_lengths_m[3] = 0.2;
    let error = settled(falling, WORK).err().unwrap();
    assert_eq!(error.reason(), "NEVER_AT_REST");
    assert!(error.to_string().contains("m/s"), "{error}");
}

#[test]
fn too_much_work_is_refused() {
    let error = settled(twin(), 1000).err().unwrap();
    assert_eq!(error.reason(), "ROLLOUT_TOO_LARGE");
}
