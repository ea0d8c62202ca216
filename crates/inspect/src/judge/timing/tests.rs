use super::*;

/// The pause that a frame lies in, found from that frame.
fn is_pause(same: &[Vec<Option<bool>>], frame: usize, least: usize) -> bool {
    let frames = same.iter().map(Vec::len).max().unwrap_or(0);
    let all = |f: usize| same.iter().all(|camera| camera.get(f).is_some_and(|s| *s != Some(false)));
    let first = (0..=frame).rev().take_while(|f| all(*f)).last();
    let last = (frame..frames).take_while(|f| all(*f)).last();
    let (Some(first), Some(last)) = (first, last) else { return false };
    first <= 1 || last + 1 == frames || last - first + 1 >= least
}

#[test]
fn pauses_last_or_lie_at_an_end() {
    let mut state = 5_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        match state >> 28 {
            0..3 => Some(false),
            3 => None,
            _ => Some(true),
        }
    };
    for length in [0, 1, 2, 7, 200] {
        let same: Vec<Vec<_>> =
            (0..3).map(|k| (k..length.max(k)).map(|_| next()).collect()).collect();
        let found = pauses(&same, 4);
        let expected: Vec<bool> = (0..found.len()).map(|f| is_pause(&same, f, 4)).collect();
        assert_eq!(found, expected, "{same:?}");
    }
}

/// 10¹⁰ steps, if each frame finds the pause that it lies in.
#[test]
fn a_long_pause_is_found_once() {
    let start = std::time::Instant::now();
    let still = vec![vec![Some(true); 200_000]; 4];
    assert!(pauses(&still, 4).iter().all(|pause| *pause));
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}
