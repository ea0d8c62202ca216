use bendtwin_core::{PreviewErrors, Stage, quality::Measure};
use prost::Message as _;

use super::*;

/// What a server accepts of a preview [bytes].
const LIMIT: usize = 64 << 10;

#[test]
fn the_largest_preview_is_within_what_a_server_accepts() {
    let (frames, points) = (Preview::MOST_FRAMES, Preview::MOST_POINTS);
    let along = |i: usize| [0.001 * i as f32, -0.5, 2.0];
    let preview = Preview {
        stage: Stage::Refine,
        variant: "x".repeat(64),
        iteration: u32::MAX,
        sequence: u32::MAX,
        frames: (u32::MAX - frames as u32..u32::MAX).collect(),
        positions: (0..frames * points).map(along).collect(),
        errors: PreviewErrors {
            measure: Measure::Coordinate,
            error_m: 0.1,
            held_back_m: Some(0.2),
            baseline_m: 0.3,
        },
    };
    let wire = wire_preview(&preview);
    assert!(wire.encoded_len() <= LIMIT, "{}", wire.encoded_len());
    let (shape, read) = wire.positions.unwrap().unpack_points("positions").unwrap();
    assert_eq!(shape, [frames, points]);
    let extent_m = 0.001 * (frames * points) as f32;
    let off = |(a, b): (&[f32; 3], &[f32; 3])| {
        a.iter().zip(b).any(|(x, y)| (x - y).abs() > extent_m / 65_000.0)
    };
    assert!(!read.iter().zip(&preview.positions).any(off));
}
