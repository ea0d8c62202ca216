//! Errors of making masks.

use bendtwin_core::Problem;

/// The reason for which no masks can be made.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// No stroke marks the object.
    #[error("no stroke marks the object: click on it in one image (docs/use/cameras.md#masks)")]
    #[problem(InvalidArgument, "OBJECT_NOT_MARKED")]
    NoObject,
    /// A camera has no pose.
    #[error(
        "camera `{0}` has no pose, by which the cameras share what was marked: calibrate the cameras first \
         (docs/use/cameras.md#calibration)"
    )]
    #[problem(InvalidArgument, "NOT_CALIBRATED")]
    NotCalibrated(String),
    /// The strokes on the object lie where no depth was measured.
    #[error(
        "no stroke on the object meets measured depth in an image that exists: mark it where depth was measured, away \
         from its rim (docs/use/cameras.md#masks)"
    )]
    #[problem(InvalidArgument, "OBJECT_WITHOUT_DEPTH")]
    ObjectWithoutDepth,
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] bendtwin_capture::Error),
    /// An image has another size than its camera says.
    #[error(
        "colour or depth of camera `{camera}`, frame {frame}, has {found:?} pixels where its calibration says {expected:?}: \
         export colour and depth on one grid"
    )]
    #[problem(InvalidArgument, "IMAGE_SIZE_MISMATCH")]
    ImageSize {
        /// Name of the camera.
        camera: String,
        /// Number of the frame.
        frame: usize,
        /// Columns and rows found.
        found: [usize; 2],
        /// Columns and rows of the camera.
        expected: [usize; 2],
    },
    /// Stopped on request.
    #[error("making masks was cancelled")]
    #[problem(Cancelled, "CANCELLED")]
    Cancelled,
}
