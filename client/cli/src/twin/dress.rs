//! `bendtwin twin dress`: Gaussians of a file, from a phone or a trainer, on a twin.

use std::{path::PathBuf, str::FromStr};

use anyhow::Context as _;
use bendtwin_core::Twin;
use bendtwin_exchange::{Format, splats};
use clap::Args;
use serde_json::json;

use super::exchange::Points;
use super::source::Source;
use crate::{failure, global::Global, output};

#[derive(Debug, Args)]
pub(super) struct Dress {
    /// twins/{uuid}, or a twin file on this machine, which needs no server
    twin: Source,
    /// Gaussians: .ply of Gaussian splatting, or .spz
    gaussians: PathBuf,
    /// The twin file to write
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Matrix from the file's coordinates to the twin's, 16 numbers row by row; without it the
    /// Gaussians are aligned to the twin's skin
    #[arg(long, value_name = "NUMBERS", allow_hyphen_values = true)]
    transform: Option<Matrix>,
}

/// Sixteen numbers with commas between them, row by row.
#[derive(Clone, Copy, Debug)]
struct Matrix([[f64; 4]; 4]);

impl FromStr for Matrix {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        let numbers: [f64; 16] = numbers
            .ok()
            .and_then(|numbers| numbers.try_into().ok())
            .ok_or("give 16 numbers with commas between them")?;
        Ok(Self(std::array::from_fn(|i| std::array::from_fn(|j| numbers[4 * i + j]))))
    }
}

pub(super) async fn run(args: Dress, global: &Global) -> anyhow::Result<()> {
    let (_, content) = args.twin.read(global).await?;
    let mut twin = Twin::decode(&content).map_err(failure::failed)?;
    let by =
        args.transform.map(|m| splats::similarity_of(m.0)).transpose().map_err(failure::failed)?;
    let path = args.gaussians.display();
    let file = std::fs::read(&args.gaussians).with_context(|| format!("cannot read {path}"))?;
    let loaded = splats::read(&file).map_err(failure::failed)?;
    let placed = splats::place(&loaded.gaussians, &twin, by).map_err(failure::failed)?;
    let (kept, dropped) = (placed.splats.len(), placed.dropped);
    twin.appearance.get_or_insert_default().splats = Some(placed.splats);
    Points::default().write("", &twin, None, Format::Twin, &args.out)?;
    let written = json!({
        "path": args.out, "gaussians": kept, "dropped": dropped,
        "left_out_harmonics": loaded.left_out_harmonics,
        "rotation": placed.similarity.rotation, "scale": placed.similarity.scale,
        "translation": placed.similarity.translation,
    });
    output::print(global, &written, || {
        let view = match loaded.left_out_harmonics {
            0 => "",
            _ => "; colours that change with the direction of view were left out",
        };
        let out = args.out.display();
        format!("{out} ({kept} Gaussians, {dropped} dropped far from the twin{view})")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_has_sixteen_numbers() {
        let Matrix(rows) = "1,0,0,-2.5, 0,1,0,0, 0,0,1,0, 0,0,0,1".parse().unwrap();
        assert_eq!(rows[0], [1.0, 0.0, 0.0, -2.5]);
        for text in
            ["", "1,2", "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1,7", "a,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1"]
        {
            assert!(text.parse::<Matrix>().is_err(), "{text}");
        }
    }
}
