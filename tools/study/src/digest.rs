//! Digest of a run, in 64 letters: the same capture, settings and build give the same digest, and
//! the same figures.

use bendtwin_core::{FitSettings, Point};

/// Digest of a run: of its capture's content, its settings (the seed among them) and the build,
/// hex.
pub(crate) fn of_run(capture_digest: &str, settings: &FitSettings, build: &str) -> String {
    let settings = serde_json::to_vec(settings).unwrap_or_default();
    let mut hash = blake3::Hasher::new();
    for part in [b"bendtwin run 1", capture_digest.as_bytes(), &settings, build.as_bytes()] {
        hash.update(&(part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize().to_hex().to_string()
}

/// Digest of the nodes' positions, hex: equal for graphs that have the same nodes, however
/// connected.
pub(crate) fn of_nodes(positions: &[Point]) -> String {
    let mut hash = blake3::Hasher::new();
    for x in positions.iter().flatten() {
        hash.update(&x.to_le_bytes());
    }
    hash.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_of_a_run_counts() {
        let settings = FitSettings::default();
        let other = FitSettings { seed: 1, ..settings.clone() };
        let digests = [
            of_run("a", &settings, "b"),
            of_run("b", &settings, "b"),
            of_run("a", &other, "b"),
            of_run("a", &settings, "a"),
        ];
        assert!((1..4).all(|i| digests[i] != digests[0]));
        assert_eq!(digests[0], of_run("a", &settings, "b"));
    }
}
