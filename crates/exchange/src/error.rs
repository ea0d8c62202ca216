//! Reasons why something cannot be exchanged, with what to do.

use std::path::Path;

use bendtwin_core::{Problem, twin::format::FormatError};

use crate::Format;

/// Reason for which a twin or its motion cannot be written, or made of results.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// A name without a known extension.
    #[error("`{name}` names no known format: {}, or say it with --format", Format::list())]
    #[problem(InvalidArgument, "EXPORT_FORMAT_UNKNOWN")]
    UnknownFormat {
        /// The file's name.
        name: String,
    },
    /// A format for one state, asked to hold several.
    #[error("{format} holds no motion: {}", Format::list_of_motion())]
    #[problem(InvalidArgument, "EXPORT_HOLDS_NO_MOTION")]
    NoMotion {
        /// The format.
        format: Format,
    },
    /// A format in which only nodes have a meaning.
    #[error("{format} holds the nodes of a twin: omit --surface, --skin and --mesh")]
    #[problem(InvalidArgument, "EXPORT_HOLDS_NODES_ONLY")]
    NodesOnly {
        /// The format.
        format: Format,
    },
    /// More frames than a format bears.
    #[error(
        "{format} takes at most {limit} frames, and there are {frames}: record fewer with --every"
    )]
    #[problem(InvalidArgument, "EXPORT_TOO_MANY_FRAMES")]
    TooManyFrames {
        /// The format.
        format: Format,
        /// Frames of the motion.
        frames: usize,
        /// The limit.
        limit: usize,
    },
    /// A motion that is not the twin's.
    #[error(
        "the motion has {found} {what} where the twin needs {needed}: was it made with this twin?"
    )]
    #[problem(InvalidArgument, "EXPORT_MOTION_SHAPE")]
    MotionShape {
        /// The points concerned.
        what: &'static str,
        /// Their number in all frames.
        found: usize,
        /// The number that fits.
        needed: usize,
    },
    /// A motion that diverged.
    #[error("frame {frame} of the motion holds a number that is not finite: it has diverged")]
    #[problem(InvalidArgument, "EXPORT_NOT_FINITE")]
    NotFinite {
        /// The frame, counted from 0.
        frame: usize,
    },
    /// Nothing to draw.
    #[error("the twin has no {0}: write its nodes (--nodes)")]
    #[problem(InvalidArgument, "EXPORT_NO_POINTS")]
    NoPoints(&'static str),
    /// No Gaussians to write.
    #[error(
        "the twin has no Gaussians: train them in a fit, or bring a file of them with `bendtwin twin dress`"
    )]
    #[problem(InvalidArgument, "EXPORT_NO_SPLATS")]
    NoSplats,
    /// A mesh in other units or axes, or of something else.
    #[error(
        "the mesh is {mesh_m:.3} m large and {apart_m:.3} m from the middle of the twin at rest, which is {twin_m:.3} m large: \
         write it in the twin's coordinates (metres, z up)"
    )]
    #[problem(InvalidArgument, "EXPORT_MESH_ELSEWHERE")]
    MeshElsewhere {
        /// Diagonal of the box around the mesh [m].
        mesh_m: f32,
        /// Diagonal of the box around the nodes [m].
        twin_m: f32,
        /// Distance between the middles of both [m].
        apart_m: f32,
    },
    /// A file that its format cannot address.
    #[error(
        "the file would have {bytes} bytes, and {format} ends at {limit}: record fewer frames with --every"
    )]
    #[problem(InvalidArgument, "EXPORT_TOO_LARGE")]
    TooLarge {
        /// The format.
        format: Format,
        /// Bytes that it would have.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// A point of a case without a position.
    #[error(
        "point {point} of the case has no position in its first frame: fill it in, or leave it out"
    )]
    #[problem(InvalidArgument, "IMPORT_POINT_MISSING")]
    PointMissing {
        /// Index among observed, completed and interior points and control points.
        point: usize,
    },
    /// More than one case for one result.
    #[error("there are {0} cases, and a fit by PhysTwin is of one: name the folder of that case")]
    #[problem(InvalidArgument, "IMPORT_SEVERAL_CASES")]
    SeveralCases(usize),
    /// A training of other springs.
    #[error(
        "the training has stiffnesses of {} springs ({} between object points), but the case's points with the radii of the \
         search have {} ({}): take all files from the same case and the same run",
        found[0], found[1], needed[0], needed[1]
    )]
    #[problem(InvalidArgument, "IMPORT_OTHER_SPRINGS")]
    OtherSprings {
        /// Springs of the training, and those between object points.
        found: [usize; 2],
        /// Springs that the case has, and those between object points.
        needed: [usize; 2],
    },
    /// The twin contradicts itself.
    #[error(transparent)]
    Twin(#[from] FormatError),
    /// The operating system failed.
    #[error("`{at}` cannot be written: {source}")]
    #[problem(Internal, "EXPORT_IO")]
    Io {
        /// The file.
        at: String,
        /// Error of the system.
        source: std::io::Error,
    },
}

impl Error {
    /// The error with the file's name, if it had none.
    pub(crate) fn of_file(self, path: &Path) -> Self {
        match self {
            Self::Io { source, .. } => Self::Io { at: path.display().to_string(), source },
            other => other,
        }
    }
}

impl From<std::io::Error> for Error {
    fn from(source: std::io::Error) -> Self {
        Self::Io { at: "the file".to_owned(), source }
    }
}

impl From<zip::result::ZipError> for Error {
    fn from(error: zip::result::ZipError) -> Self {
        std::io::Error::other(error).into()
    }
}

impl From<::mcap::McapError> for Error {
    fn from(error: ::mcap::McapError) -> Self {
        std::io::Error::other(error).into()
    }
}
