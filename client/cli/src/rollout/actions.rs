//! Control trajectories from files, and two test motions.

use std::path::Path;

use anyhow::Context as _;
use bendtwin_client::Point;

use super::npy;
use crate::failure::Usage;

/// A batch of control trajectories.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Actions {
    /// Instances B, rows K, control points C.
    pub(super) shape: [usize; 3],
    /// [m], shape [B, K, C].
    pub(super) positions: Vec<Point>,
}

impl Actions {
    /// Reads a batch, or one instance, from .npy or .json.
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
            let text = std::fs::read_to_string(path)
                .with_context(|| format!("cannot read {}", path.display()))?;
            return from_json(&text)
                .map_err(|fault| Usage::error(format!("{}: {fault}", path.display())));
        }
        let array = npy::read(path)?;
        let shape = match array.shape[..] {
            [b, k, c, 3] => [b, k, c],
            [k, c, 3] => [1, k, c],
            _ => {
                let fault = format!("has shape {:?}, not [B, K, C, 3] or [K, C, 3]", array.shape);
                return Err(Usage::error(format!("{}: {fault}", path.display())));
            }
        };
        Ok(Self { shape, positions: array.values.as_chunks::<3>().0.to_vec() })
    }

    /// All control points swing along x and back once: x + a sin(2 pi t).
    pub(super) fn sway(rest: &[Point], amplitude_m: f32, frames: usize) -> Self {
        Self::moved(rest, frames, |t| [amplitude_m * (std::f32::consts::TAU * t).sin(), 0.0, 0.0])
    }

    /// All control points move by a vector, starting and ending gently.
    pub(super) fn shift(rest: &[Point], by_m: Point, frames: usize) -> Self {
        Self::moved(rest, frames, |t| by_m.map(|d| d * t * t * (3.0 - 2.0 * t)))
    }

    /// Actions of one instance. `offset` is a function of the time as a fraction of the horizon.
    fn moved(rest: &[Point], frames: usize, offset: impl Fn(f32) -> Point) -> Self {
        let rows = (0..=frames).map(|f| offset(f as f32 / frames as f32));
        let positions = rows
            .flat_map(|o| rest.iter().map(move |p| std::array::from_fn(|i| p[i] + o[i])))
            .collect();
        Self { shape: [1, frames + 1, rest.len()], positions }
    }
}

fn from_json(text: &str) -> Result<Actions, String> {
    type Instance = Vec<Vec<Point>>;
    let batch: Vec<Instance> = match serde_json::from_str::<Vec<Instance>>(text) {
        Ok(batch) => batch,
        Err(_) => vec![serde_json::from_str::<Instance>(text).map_err(|e| {
            format!("must be nested lists of shape [B, K, C, 3] or [K, C, 3] ({e})")
        })?],
    };
    let rows = batch.first().map_or(0, Vec::len);
    let controls = batch.first().and_then(|b| b.first()).map_or(0, Vec::len);
    if batch.iter().any(|b| b.len() != rows || b.iter().any(|r| r.len() != controls)) {
        return Err("has lists of different lengths".to_owned());
    }
    let shape = [batch.len(), rows, controls];
    Ok(Actions { shape, positions: batch.into_iter().flatten().flatten().collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_of_both_depths() {
        let one = from_json("[[[0,0,0]],[[1,2,3]]]").unwrap();
        assert_eq!(one.shape, [1, 2, 1]);
        assert_eq!(one.positions[1], [1.0, 2.0, 3.0]);
        let batch = from_json("[[[[0,0,0]],[[1,2,3]]],[[[0,0,0]],[[1,2,3]]]]").unwrap();
        assert_eq!(batch.shape, [2, 2, 1]);
        assert!(from_json("[[[0,0,0]],[[1,2,3],[4,5,6]]]").is_err());
        assert!(from_json("{}").is_err());
    }

    #[test]
    fn test_motions_start_at_rest() {
        let rest = [[0.0, 0.0, 1.0], [0.1, 0.0, 1.0]];
        let sway = Actions::sway(&rest, 0.05, 4);
        assert_eq!((sway.shape, &sway.positions[..2]), ([1, 5, 2], &rest[..]));
        assert!((sway.positions[2][0] - 0.05).abs() < 1e-6);
        let shift = Actions::shift(&rest, [0.0, 0.0, 0.2], 4);
        assert_eq!(shift.positions[..2], rest);
        assert!((shift.positions[8][2] - 1.2).abs() < 1e-6);
    }
}
