//! Gaussians in the files of other programs, and on twins.
//!
//! [`read()`] takes the `.ply` that trainers of Gaussian splatting write and the `.spz` of phones;
//! [`place()`] brings what was read to a twin and lets its nodes carry it; [`write_ply`] is the way
//! out. Colours that change with the direction of view are left out: an appearance of a twin has
//! none.

mod error;
mod place;
mod ply;
mod spz;

use bendtwin_core::Twin;
use bendtwin_splat::Gaussians;

pub use self::{
    error::Error,
    place::{Placement, place, similarity_of},
    ply::write_ply,
};

/// Most Gaussians of a file: a room by a phone has two million.
pub const MOST_GAUSSIANS: usize = 4_000_000;

/// Value of the first spherical harmonic: a colour is 1/2 plus this times its coefficient.
const HARMONIC: f32 = 0.282_094_8;

/// Gaussians of a file, in its own unit and axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loaded {
    /// Gaussians; lengths are in the unit of the file.
    pub gaussians: Gaussians,
    /// Coefficients of colours that depend on the direction of view, for each Gaussian and channel;
    /// they were left out.
    pub left_out_harmonics: usize,
}

/// Gaussians of a `.ply` or `.spz` file's content, by its first bytes.
///
/// # Errors
/// Another format, a damaged file, too many Gaussians, or numbers that are not finite.
pub fn read(content: &[u8]) -> Result<Loaded, Error> {
    let loaded = if content.starts_with(b"ply") {
        ply::read(content)?
    } else if content.starts_with(&[0x1f, 0x8b]) || content.starts_with(spz::MAGIC) {
        spz::read(content)?
    } else {
        return Err(Error::Format);
    };
    if loaded.gaussians.is_empty() {
        return Err(Error::Empty);
    }
    loaded.gaussians.check().map_err(Error::Gaussians)?;
    Ok(loaded)
}

/// Gaussians of a twin at rest; none if it has no appearance with them.
pub fn of_twin(twin: &Twin) -> Option<Gaussians> {
    let splats = twin.appearance.as_ref()?.splats.as_ref()?;
    Some(Gaussians {
        means_m: splats.carriers.positions(&twin.graph.rest_positions),
        scales_m: splats.scales_m.clone(),
        rotations: splats.rotations.clone(),
        opacities: splats.opacities.clone(),
        colors: splats.colors.clone(),
    })
}

/// Refuses more Gaussians than are read.
fn check_count(count: u64) -> Result<usize, Error> {
    usize::try_from(count)
        .ok()
        .filter(|n| *n <= MOST_GAUSSIANS)
        .ok_or(Error::TooMany { count, limit: MOST_GAUSSIANS })
}

#[cfg(test)]
mod tests;
