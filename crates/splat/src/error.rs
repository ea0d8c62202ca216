//! Errors of rendering.

use bendtwin_core::Problem;

/// The reason for which an image, or gradients, cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Problem)]
pub enum Error {
    /// A parameter of a Gaussian is not finite, or outside of its range.
    #[error("Gaussian {index} has {what} {value}: {rule}")]
    #[problem(InvalidArgument, "SPLATS_INVALID")]
    Gaussian {
        /// Index of the Gaussian.
        index: usize,
        /// Name of the parameter.
        what: &'static str,
        /// The parameter.
        value: f32,
        /// The range, as a sentence.
        rule: &'static str,
    },
    /// Arrays of different lengths.
    #[error("{expected} {of} but {got} {what}")]
    #[problem(InvalidArgument, "SPLATS_INVALID")]
    Lengths {
        /// Entries that there must be.
        expected: usize,
        /// Their name.
        of: &'static str,
        /// Entries that there are.
        got: usize,
        /// Their name.
        what: &'static str,
    },
    /// A parameter of the camera is out of range.
    #[error("the camera's {what} is {value}: {rule}")]
    #[problem(InvalidArgument, "SPLATS_INVALID")]
    Camera {
        /// Name of the parameter.
        what: &'static str,
        /// The parameter.
        value: f32,
        /// The range, as a sentence.
        rule: &'static str,
    },
    /// A derivative of the loss by a pixel is not finite.
    #[error("d loss / d {what} of pixel {pixel} is {value}: it must be finite")]
    #[problem(InvalidArgument, "SPLATS_INVALID")]
    Bar {
        /// Name of the channel.
        what: &'static str,
        /// Index of the pixel, row-major.
        pixel: usize,
        /// The derivative.
        value: f32,
    },
    /// More Gaussians, or more tiles under them, than memory is given for.
    #[error("{count} {what}, at most {most}: use fewer or smaller Gaussians, or a smaller image")]
    #[problem(ResourceExhausted, "SPLATS_TOO_MANY")]
    TooMany {
        /// Name of the counted things.
        what: &'static str,
        /// Number of them.
        count: usize,
        /// Most that may be.
        most: usize,
    },
    /// The graph and the Gaussians that it carries do not fit each other.
    #[error("{0}")]
    #[problem(InvalidArgument, "SPLATS_INVALID")]
    Carrier(String),
    /// A device failed or is missing.
    #[error("the compute device failed: {0}")]
    #[problem(Internal, "DEVICE_FAILED")]
    Device(String),
    /// A device has too little memory.
    #[error(
        "rendering needs {needed} bytes of device memory, {available} are available: use fewer Gaussians or a smaller image"
    )]
    #[problem(ResourceExhausted, "DEVICE_OUT_OF_MEMORY")]
    OutOfMemory {
        /// Bytes that are needed.
        needed: u64,
        /// Bytes that there are.
        available: u64,
    },
}
