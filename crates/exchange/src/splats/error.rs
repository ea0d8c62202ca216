//! Reasons why Gaussians cannot be read or placed, with what to do.

use bendtwin_core::Problem;

/// Reason for which Gaussians cannot be read, or placed on a twin.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// Neither of the formats that are read.
    #[error(
        "this is no file of Gaussians that can be read: export it as binary .ply of Gaussian splatting or as .spz"
    )]
    #[problem(InvalidArgument, "SPLATS_FORMAT_UNKNOWN")]
    Format,
    /// A file that is cut off, corrupted or against its format.
    #[error("the file of Gaussians is damaged: {0}; export it again")]
    #[problem(InvalidArgument, "SPLATS_DAMAGED")]
    Damaged(String),
    /// A part of its format that is not read.
    #[error(
        "the file of Gaussians has {0}, which is not read: export it as binary little-endian .ply with x, f_dc, opacity, scale and rot, or as .spz of version 2, 3 or 4"
    )]
    #[problem(InvalidArgument, "SPLATS_UNSUPPORTED")]
    Unsupported(String),
    /// An empty file.
    #[error("the file has no Gaussians: look at what was exported")]
    #[problem(InvalidArgument, "SPLATS_EMPTY")]
    Empty,
    /// More Gaussians than are read or kept.
    #[error("there are {count} Gaussians, the limit is {limit}: crop them to the object first")]
    #[problem(ResourceExhausted, "SPLATS_TOO_MANY")]
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
    #[problem(InvalidArgument, "SPLATS_OUT_OF_RANGE")]
    Gaussians(bendtwin_splat::Error),
    /// A matrix that is no similarity.
    #[error(
        "the transform is not a rotation with one positive scale and a translation (last row 0 0 0 1): give a matrix [R s, t]"
    )]
    #[problem(InvalidArgument, "SPLATS_TRANSFORM")]
    Transform,
    /// No alignment with the twin.
    #[error(
        "the Gaussians could not be brought to the twin by themselves ({0}): crop them to the object, or give --transform"
    )]
    #[problem(FailedPrecondition, "SPLATS_NOT_ALIGNED")]
    NotAligned(bendtwin_mesh::Error),
    /// Nothing near the twin.
    #[error(
        "no Gaussian lies within {within_mm:.1} mm of the twin's skin: look at the unit, the axes and --transform"
    )]
    #[problem(FailedPrecondition, "SPLATS_ELSEWHERE")]
    Elsewhere {
        /// Largest distance of a Gaussian that is kept [mm].
        within_mm: f32,
    },
}
