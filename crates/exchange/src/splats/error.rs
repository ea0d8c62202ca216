//! Reasons why Gaussians cannot be read or placed, with what to do.

use bendtwin_core::{Category, Problem};

/// Reason for which Gaussians cannot be read, or placed on a twin.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Neither of the formats that are read.
    #[error(
        "this is no file of Gaussians that can be read: export it as binary .ply of Gaussian splatting or as .spz"
    )]
    Format,
    /// A file that is cut off, corrupted or against its format.
    #[error("the file of Gaussians is damaged: {0}; export it again")]
    Damaged(String),
    /// A part of its format that is not read.
    #[error(
        "the file of Gaussians has {0}, which is not read: export it as binary little-endian .ply with x, f_dc, opacity, scale and rot, or as .spz of version 2 or 3"
    )]
    Unsupported(String),
    /// An empty file.
    #[error("the file has no Gaussians: look at what was exported")]
    Empty,
    /// More Gaussians than are read or kept.
    #[error("there are {count} Gaussians, the limit is {limit}: crop them to the object first")]
    TooMany {
        /// Their number.
        count: u64,
        /// The limit.
        limit: usize,
    },
    /// A number that is not finite or out of range.
    #[error(
        "the file of Gaussians cannot be used: {0}; clean it in an editor of splats and export it again"
    )]
    Gaussians(bendtwin_splat::Error),
    /// A matrix that is no similarity.
    #[error(
        "the transform is not a rotation with one positive scale and a translation (last row 0 0 0 1): give a matrix [R s, t]"
    )]
    Transform,
    /// No alignment with the twin.
    #[error(
        "the Gaussians could not be brought to the twin by themselves ({0}): crop them to the object, or give --transform"
    )]
    NotAligned(bendtwin_mesh::Error),
    /// Nothing near the twin.
    #[error(
        "no Gaussian lies within {within_mm:.1} mm of the twin's skin: look at the unit, the axes and --transform"
    )]
    Elsewhere {
        /// Largest distance of a Gaussian that is kept [mm].
        within_mm: f32,
    },
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::TooMany { .. } => Category::ResourceExhausted,
            Self::NotAligned(_) | Self::Elsewhere { .. } => Category::FailedPrecondition,
            _ => Category::InvalidArgument,
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::Format => "SPLATS_FORMAT_UNKNOWN",
            Self::Damaged(_) => "SPLATS_DAMAGED",
            Self::Unsupported(_) => "SPLATS_UNSUPPORTED",
            Self::Empty => "SPLATS_EMPTY",
            Self::TooMany { .. } => "SPLATS_TOO_MANY",
            Self::Gaussians(_) => "SPLATS_OUT_OF_RANGE",
            Self::Transform => "SPLATS_TRANSFORM",
            Self::NotAligned(_) => "SPLATS_NOT_ALIGNED",
            Self::Elsewhere { .. } => "SPLATS_ELSEWHERE",
        }
    }
}
