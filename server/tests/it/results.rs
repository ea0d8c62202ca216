//! Results as workers send them.

use bendtwin_core::{Graph, NodeKind, Params, Timing, Twin, twin::Provenance};

/// A twin file of 5 nodes, 4 springs, 3 triplets and 1 control point, different for each label.
pub(crate) fn twin_file(label: &[u8]) -> Vec<u8> {
    let n = 5;
    let graph = Graph {
        rest_positions: (0..n).map(|i| [0.1 * i as f32, 0.0, 0.1]).collect(),
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: (0..n as u32).collect(),
        control_rest: vec![[0.5, 0.0, 0.1]],
        springs: (0..n as u32 - 1).map(|i| [i, i + 1]).collect(),
        triplets: (0..n as u32 - 2).map(|i| [i, i + 1, i + 2]).collect(),
        ..Graph::default()
    };
    let params = Params {
        rest_lengths_m: vec![0.1; n - 1],
        spring_stiffness: vec![100.0; n - 1],
        spring_dashpot: vec![1.0; n - 1],
        bend_stiffness: vec![0.5; n - 2],
        bend_damping: vec![0.01; n - 2],
        rest_angles_rad: vec![std::f32::consts::PI; n - 2],
        ..Params::default()
    };
    let label = String::from_utf8_lossy(label).into_owned();
    let twin = Twin {
        provenance: Provenance { build: label, ..Provenance::default() },
        ..Twin::new(graph, params, Timing { fps: 30.0, substeps: 10 })
    };
    twin.encode().unwrap()
}

/// The begin of an observation, different for each label.
pub(crate) fn observation(label: &[u8]) -> Vec<u8> {
    let name = b"capture.json";
    let mut bytes = b"PK\x03\x04".to_vec();
    bytes.resize(26, 0);
    bytes.extend([name.len() as u8, 0, 0, 0]);
    bytes.extend(name);
    bytes.extend(label);
    bytes
}

/// The begin of a playback.
pub(crate) fn playback() -> Vec<u8> {
    b"BENDPLAY and the rest".to_vec()
}

/// The begin of an archive of masks, different for each label.
pub(crate) fn masks(label: &[u8]) -> Vec<u8> {
    [b"PK\x03\x04", label].concat()
}

/// A report of this verdict.
pub(crate) fn report(verdict: &str) -> String {
    format!(r#"{{"format":"bendtwin-capture-report","version":1,"verdict":"{verdict}"}}"#)
}
