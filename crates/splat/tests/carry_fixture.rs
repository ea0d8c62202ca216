//! `console/src/view3d/splats/carry.fixture.json`: Gaussians on a bent and turned sheet, which a test
//! of the console carries, too. `BENDTWIN_BLESS=1` rewrites it.

use std::path::Path;

use bendtwin_core::{Graph, NodeKind, Point, Skin};
use bendtwin_splat::Carrier;
use serde_json::{Value, json};

#[test]
fn the_console_is_held_to_these_numbers() {
    let made = fixture();
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../console/src/view3d/splats/carry.fixture.json");
    let stored: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let differs = |(name, value): (&String, &Value)| {
        let (made, stored) = (numbers(value), numbers(&stored[name]));
        let is_off = made.iter().zip(&stored).any(|(a, b)| (a - b).abs() > 1e-6);
        (is_off || made.len() != stored.len()).then(|| name.clone())
    };
    let different: Vec<String> = made.as_object().unwrap().iter().filter_map(differs).collect();
    // Last digits depend on the machine: a file that agrees stays as it is.
    if different.is_empty() {
        return;
    }
    let is_blessed = std::env::var_os("BENDTWIN_BLESS").is_some();
    assert!(is_blessed, "{different:?}: write it anew with BENDTWIN_BLESS=1");
    std::fs::write(&path, serde_json::to_string(&made).unwrap() + "\n").unwrap();
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        other => other.as_f64().into_iter().collect(),
    }
}

/// A sheet of 4 x 5 nodes with two control points, rolled and turned by about a third of a circle.
fn fixture() -> Value {
    let (rows, columns) = (4u32, 5u32);
    let count = rows * columns;
    let node = |r: u32, c: u32| r * columns + c;
    let rest: Vec<Point> =
        (0..count).map(|i| [0.1 * (i % columns) as f32, 0.1 * (i / columns) as f32, 0.0]).collect();
    let mut springs = vec![[0, count], [4, count + 1]];
    for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let ahead = [(r, c + 1), (r + 1, c), (r + 1, c + 1)];
        let inside = ahead.into_iter().filter(|(r, c)| *r < rows && *c < columns);
        springs.extend(inside.map(|(r2, c2)| [node(r, c), node(r2, c2)]));
    }
    let mut skin = Skin::default();
    skin.push(0, &[(6, 1.0)], [Skin::NO_FRAME; 3], [0.0; 3]);
    skin.push(1, &[(6, 0.5), (7, 0.3), (11, 0.2)], [6, 7, 11], [0.01, -0.02, 0.03]);
    skin.push(2, &[(19, 1.2), (18, -0.2)], [19, 18, 14], [0.0, 0.0, 0.05]);
    skin.push(
        3,
        &[(0, 0.25), (4, 0.25), (15, 0.25), (19, 0.25)],
        [Skin::NO_FRAME; 3],
        [0.0, 0.1, 0.0],
    );
    let graph = Graph {
        kinds: vec![NodeKind::Observed; count as usize],
        masses: vec![1.0; count as usize],
        object_ids: vec![0; count as usize],
        observed_points: vec![Graph::NOT_OBSERVED; count as usize],
        control_rest: vec![[0.0, -0.1, 0.0], [0.4, -0.1, 0.0]],
        rest_positions: rest.clone(),
        springs,
        triplets: Vec::new(),
        pins: Vec::new(),
        rods: Vec::new(),
    };
    let (sine, cosine) = 2.2f32.sin_cos();
    let nodes: Vec<Point> = rest
        .iter()
        .map(|[x, y, _]| {
            let [bent, up] = [0.15 * (x / 0.15).sin(), 0.15 * (1.0 - (x / 0.15).cos())];
            [cosine * bent - sine * y + 0.3, sine * bent + cosine * y, up - 0.2 * y]
        })
        .collect();
    let carried = Carrier::new(&graph, &skin).unwrap().at(&nodes).unwrap();
    let weights: Vec<Vec<(u32, f32)>> =
        (0..skin.len()).map(|g| skin.weights_of(g).collect()).collect();
    json!({
        "rest": rest,
        "springs": graph.springs,
        "nodes": nodes,
        "weight_counts": weights.iter().map(Vec::len).collect::<Vec<_>>(),
        "weight_nodes": weights.iter().flatten().map(|w| w.0).collect::<Vec<_>>(),
        "weights": weights.iter().flatten().map(|w| w.1).collect::<Vec<_>>(),
        "frames": skin.frames,
        "offsets": skin.offsets_m,
        "means": carried.means_m,
        "rotations": carried.rotations,
    })
}
