//! Errors of building a graph from a capture.

use bendtwin_core::Problem;

/// An error that prevents sampling nodes from a capture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Problem)]
pub enum Error {
    /// No point of the capture can become a node.
    #[error(
        "the capture has no usable point at frame {frame} of its first sequence \
         ({left_out} of {points} tracked points are missing or hidden there): \
         start the capture at a frame in which the object is seen"
    )]
    #[problem(InvalidArgument, "CAPTURE_HAS_NO_POINTS")]
    NoPoints {
        /// The start frame.
        frame: usize,
        /// Tracked points that cannot be used.
        left_out: usize,
        /// Tracked points in all.
        points: usize,
    },
    /// An array of the capture does not have the declared shape.
    #[error("the capture contradicts itself: {0}; write it again with arrays of matching shapes")]
    #[problem(InvalidArgument, "CAPTURE_INCONSISTENT")]
    Inconsistent(String),
    /// A point that cannot be left out has no position at the start.
    #[error(
        "tracked point {point} has no position at frame {frame}, but {why}: fill it in, or start later"
    )]
    #[problem(InvalidArgument, "CAPTURE_POINT_MISSING")]
    PointMissing {
        /// Tracked point index.
        point: usize,
        /// The start frame.
        frame: usize,
        /// Reason why the point is needed.
        why: &'static str,
    },
    /// A control point has no position at the start.
    #[error(
        "control point {control} has no position at frame {frame}: fill it in, or leave it out of the capture"
    )]
    #[problem(InvalidArgument, "CAPTURE_CONTROL_MISSING")]
    ControlMissing {
        /// Control point index.
        control: usize,
        /// The start frame.
        frame: usize,
    },
}
