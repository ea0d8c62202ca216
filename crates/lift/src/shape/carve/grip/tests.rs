use super::*;

const CELL_M: f64 = 0.004;
const ROPE_M: f32 = 0.012;
const FIST_M: f32 = 0.03;

/// A rope along x of which a fist hides what lies between two places; the cells that are filled.
fn filled(fist: std::ops::Range<f32>, rope: std::ops::Range<f32>) -> Vec<Point> {
    let volume = Volume::around(&[[0.0; 3], [0.2, 0.0, 0.0]], CELL_M).unwrap();
    let cells: Vec<Point> = (0..volume.count()).map(|i| volume.centre(i)).collect();
    let aside = |p: &Point| (p[1] * p[1] + p[2] * p[2]).sqrt();
    let hidden: Vec<bool> =
        cells.iter().map(|p| fist.contains(&p[0]) && aside(p) < FIST_M).collect();
    let mut solid: Vec<bool> = cells
        .iter()
        .map(|p| rope.contains(&p[0]) && !fist.contains(&p[0]) && aside(p) < ROPE_M)
        .collect();
    let around = |x: f32| {
        (0..16).map(move |k| {
            let (s, c) = (std::f32::consts::TAU * k as f32 / 16.0).sin_cos();
            [x, FIST_M * s, FIST_M * c]
        })
    };
    let steps = (0..=30).map(|i| fist.start + (fist.end - fist.start) * i as f32 / 30.0);
    let hands: Vec<Point> = steps.flat_map(around).collect();
    let before = solid.clone();
    let count = fill(&volume, &mut solid, &hidden, &hands, &CancelToken::default()).unwrap();
    let new = (0..cells.len()).filter(|i| solid[*i] && !before[*i]);
    let new: Vec<Point> = new.map(|i| cells[i]).collect();
    assert_eq!(new.len(), count);
    assert!(new.iter().all(|p| fist.contains(&p[0])), "only what is hidden is filled");
    let wide = new.iter().map(aside).fold(0.0, f32::max);
    assert!(wide < ROPE_M + CELL_M as f32, "{wide} m is no section of the rope");
    new
}

/// Slices of the rope, a cell thick, that have about as many cells as its section.
fn slices(filled: &[Point], range: std::ops::Range<f32>) -> usize {
    let section = std::f64::consts::PI * f64::from(ROPE_M).powi(2) / CELL_M.powi(2);
    let within = filled.iter().filter(|p| range.contains(&p[0])).count();
    (within as f64 / section).round() as usize
}

#[test]
fn the_end_of_a_rope_continues_to_the_middle_of_the_fist() {
    let cells = filled(0.0..0.06, 0.0..0.2);
    assert!(slices(&cells, 0.0..0.06) >= 4, "{} cells", cells.len());
    assert!(cells.iter().all(|p| p[0] > 0.02), "what lies beyond the middle is not known");
}

#[test]
fn both_sides_of_a_rope_meet_in_the_fist() {
    let cells = filled(0.06..0.1, 0.0..0.2);
    assert!(slices(&cells, 0.06..0.1) >= 9, "{} cells", cells.len());
}

#[test]
fn a_hand_beside_the_object_adds_nothing() {
    assert_eq!(filled(0.0..0.06, 0.1..0.2), Vec::<Point>::new());
}
