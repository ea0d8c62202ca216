//! Reasons why a capture cannot be read, with what its owner should do. The reasons double as codes
//! of [`crate::check`] findings.

use bendtwin_core::Problem;

/// Reason for which a capture cannot be read or written.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// No file or folder at the path.
    #[error("there is no capture at `{0}`: check the path")]
    #[problem(NotFound, "CAPTURE_NOT_FOUND")]
    NotFound(String),
    /// The operating system failed.
    #[error("`{at}` cannot be read or written: {source}")]
    #[problem(Internal, "CAPTURE_IO")]
    Io {
        /// The file concerned.
        at: String,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Neither a bundle, nor a PhysTwin case, nor motion capture.
    #[error(
        "`{name}` is no capture, {there}: it needs `capture.json` (a BendTwin bundle), `final_data.pkl` or `metadata.json` \
         with `color` (a PhysTwin case) or `transforms.json` (nerfstudio), unless it is an MCAP file or motion capture (an .npz with its .json \
         beside it, C3D, CSV of OptiTrack, or TRC)"
    )]
    #[problem(InvalidArgument, "UNKNOWN_CAPTURE_KIND")]
    UnknownKind {
        /// Name of the folder or file.
        name: String,
        /// Files that lie there instead, in words.
        there: String,
    },
    /// A format that has to be converted first.
    #[error("`{at}` is {what}: {advice}")]
    #[problem(InvalidArgument, "FORMAT_NOT_READ")]
    OtherFormat {
        /// The file.
        at: String,
        /// Format of the file.
        what: &'static str,
        /// The command that converts it.
        advice: String,
    },
    /// A recorded but unprocessed case.
    #[error("`{0}` is a raw recording: colour and depth, not yet points. Ingest it first")]
    #[problem(InvalidArgument, "RAW_CAPTURE")]
    RawOnly(String),
    /// More than one capture in one archive or folder.
    #[error(
        "there are several captures ({0}): send one capture at a time, or put a recordings.json beside \
         them if they are recordings of one object"
    )]
    #[problem(InvalidArgument, "SEVERAL_CAPTURES")]
    Several(String),
    /// A recording among several of an object cannot be read.
    #[error("recording `{name}`: {error}")]
    #[problem(transparent)]
    InRecording {
        /// Name of the recording.
        name: String,
        /// The reason.
        error: Box<Error>,
    },
    /// An archive that is cut off or corrupted.
    #[error("the archive is damaged or cut off ({0}): upload or copy it again")]
    #[problem(InvalidArgument, "ARCHIVE_DAMAGED")]
    ArchiveDamaged(String),
    /// Too many entries.
    #[error(
        "the archive has {entries} entries, the limit is {limit}: pack only the capture's files"
    )]
    #[problem(ResourceExhausted, "ARCHIVE_TOO_MANY_ENTRIES")]
    ArchiveEntries {
        /// Entries found.
        entries: usize,
        /// Entries allowed.
        limit: usize,
    },
    /// A compression bomb.
    #[error(
        "`{at}` unpacks to {ratio} times its size (limit {limit}), as only a decompression bomb does: \
         store it uncompressed if it is real"
    )]
    #[problem(InvalidArgument, "ARCHIVE_BOMB")]
    ArchiveRatio {
        /// The entry.
        at: String,
        /// Decompressed over compressed size.
        ratio: u64,
        /// Largest accepted ratio.
        limit: u64,
    },
    /// A name that leaves the archive, is absolute, or is too long.
    #[error(
        "the archive has an entry named `{0}`, which is not a plain path inside it: pack the folder anew"
    )]
    #[problem(InvalidArgument, "ARCHIVE_UNSAFE_NAME")]
    ArchiveName(String),
    /// A link, device or encrypted entry where a file is needed.
    #[error("`{at}` in the archive is {kind}, not a regular file: pack the files themselves")]
    #[problem(InvalidArgument, "ARCHIVE_NOT_A_FILE")]
    ArchiveEntryKind {
        /// The entry.
        at: String,
        /// Kind of entry.
        kind: &'static str,
    },
    /// An entry in a compression that is not read.
    #[error(
        "`{at}` in the archive is compressed with {method}: pack it with Deflate, Zstandard, bzip2 or without compression"
    )]
    #[problem(InvalidArgument, "ARCHIVE_COMPRESSION_NOT_READ")]
    ArchiveCompression {
        /// The entry.
        at: String,
        /// Compression method.
        method: String,
    },
    /// A compressed tar archive that is larger than what may be held in memory.
    #[error(
        "`{at}` unpacks to more than {limit} bytes, and a .tar.gz is held in memory: \
         send the recording as .zip or .tar, which are not"
    )]
    #[problem(ResourceExhausted, "ARCHIVE_TOO_LARGE_FOR_MEMORY")]
    UnpackedInMemory {
        /// The archive.
        at: String,
        /// Bytes allowed.
        limit: u64,
    },
    /// An MCAP file that was compressed as a whole and is larger than what may be held in memory.
    #[error(
        "`{at}` unpacks to more than {limit} bytes, and a compressed file is held in memory: unpack it with `zstd -d {at}`, \
         or record with `--compression-mode message`"
    )]
    #[problem(ResourceExhausted, "MCAP_TOO_LARGE_FOR_MEMORY")]
    McapInMemory {
        /// The file.
        at: String,
        /// Bytes allowed.
        limit: u64,
    },
    /// Two entries of one name.
    #[error("the archive has several entries of the same name: pack the folder anew")]
    #[problem(InvalidArgument, "ARCHIVE_DUPLICATE_NAME")]
    ArchiveDuplicate,
    /// Entries that share bytes.
    #[error(
        "entries of the archive share the same bytes, as only those of a decompression bomb do: pack the folder anew"
    )]
    #[problem(InvalidArgument, "ARCHIVE_OVERLAP")]
    ArchiveOverlap,
    /// More pixels than a file of its size may hold.
    #[error(
        "the images of the recording have {pixels} pixels in all, the limit for a file of {length} bytes is {limit}: \
         send at most {fitting} of its {frames} frames, or images of lower resolution"
    )]
    #[problem(ResourceExhausted, "RECORDING_TOO_MANY_PIXELS")]
    Pixels {
        /// Pixels of all images.
        pixels: u64,
        /// Pixels allowed.
        limit: u64,
        /// Size of the file [bytes].
        length: u64,
        /// Frames of the recording.
        frames: u64,
        /// Frames that would fit.
        fitting: u64,
    },
    /// A limit on sizes.
    #[error(
        "{what} needs {bytes} bytes, beyond the limit of {limit}: use fewer frames or points, or split the capture"
    )]
    #[problem(ResourceExhausted, "CAPTURE_TOO_LARGE")]
    TooLarge {
        /// Thing that is too large.
        what: String,
        /// Size.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// A limit on counts.
    #[error("{what}: {count}, the limit is {limit}: use a smaller capture")]
    #[problem(ResourceExhausted, "CAPTURE_TOO_MANY")]
    TooMany {
        /// Things that are too many.
        what: &'static str,
        /// Number of them.
        count: u64,
        /// The limit.
        limit: u64,
    },
    /// A file that must be there is not.
    #[error("`{0}` is missing: add it to the capture")]
    #[problem(InvalidArgument, "MISSING_FILE")]
    MissingFile(String),
    /// An array inside a file that must be there is not.
    #[error("`{at}` has no array `{array}`: add it")]
    #[problem(InvalidArgument, "MISSING_ARRAY")]
    MissingArray {
        /// The file.
        at: String,
        /// The array.
        array: String,
    },
    /// A kind of image that a camera lacks.
    #[error(
        "camera `{camera}` has no {what}, looked for as {wanted}, but {there}: add them, or name them so"
    )]
    #[problem(InvalidArgument, "IMAGES_NOT_FOUND")]
    ImagesMissing {
        /// The camera's name.
        camera: String,
        /// Kind of image.
        what: &'static str,
        /// Names that were looked for.
        wanted: String,
        /// Files that lie there, in words.
        there: String,
    },
    /// Images whose numbers contradict each other or the description.
    #[error("{0}")]
    #[problem(InvalidArgument, "FRAME_NUMBERS_UNCLEAR")]
    FrameNumbers(String),
    /// An archive or folder of masks without masks.
    #[error(
        "there are no masks, {there}: put those of camera 0 into `mask/0`, as images with the number of their frame, \
         and so on (docs/use/cameras.md#masks)"
    )]
    #[problem(InvalidArgument, "NO_MASKS")]
    NoMasks {
        /// What lies there, in words.
        there: String,
    },
    /// Labels of masks that do not distinguish the object from the manipulator.
    #[error("{0}")]
    #[problem(InvalidArgument, "MASK_LABELS_UNCLEAR")]
    MaskLabels(String),
    /// A JSON document that is wrong.
    #[error("`{at}` is not as specified: {fault}")]
    #[problem(InvalidArgument, "INVALID_DOCUMENT")]
    Document {
        /// The file.
        at: String,
        /// Description of the fault.
        fault: String,
    },
    /// A newer bundle.
    #[error("`capture.json` has version {found}, this build reads up to {known}: update BendTwin")]
    #[problem(InvalidArgument, "UNSUPPORTED_VERSION")]
    Version {
        /// Version found.
        found: u64,
        /// Newest version known.
        known: u64,
    },
    /// Units other than those known.
    #[error("the units are `{0}`: declare one of m, cm, mm")]
    #[problem(InvalidArgument, "UNKNOWN_UNITS")]
    Units(String),
    /// Undeclared or impossible axes.
    #[error("{0}")]
    #[problem(InvalidArgument, "INVALID_AXES")]
    Axes(String),
    /// An .npy, .npz or pickle file that is cut off or corrupted.
    #[error("`{at}` is damaged or cut off: {fault}; write it again")]
    #[problem(InvalidArgument, "FILE_DAMAGED")]
    Damaged {
        /// The file.
        at: String,
        /// Description of the fault.
        fault: String,
    },
    /// A header that claims more than there is.
    #[error(
        "`{at}` claims {claimed} bytes of data but holds {present}: it is cut off or its header is wrong"
    )]
    #[problem(InvalidArgument, "HEADER_CLAIMS_TOO_MUCH")]
    Absurd {
        /// The file or array.
        at: String,
        /// Bytes that its header claims, saturated.
        claimed: u64,
        /// Bytes present.
        present: u64,
    },
    /// A pickle that names something outside the allow-list.
    #[error(
        "`{at}` asks to load `{global}`: only plain numpy arrays, dictionaries, lists and numbers are read; \
         save it again with `numpy.asarray` on each array"
    )]
    #[problem(InvalidArgument, "PICKLE_GLOBAL_REFUSED")]
    PickleGlobal {
        /// The file.
        at: String,
        /// The refused global.
        global: String,
    },
    /// A pickle beyond the limits or with an opcode outside the allow-list.
    #[error("`{at}` is refused: {fault}")]
    #[problem(InvalidArgument, "PICKLE_REFUSED")]
    Pickle {
        /// The file.
        at: String,
        /// Why.
        fault: String,
    },
    /// An array of another type.
    #[error("`{at}` holds {found}: it must hold {needed}")]
    #[problem(InvalidArgument, "WRONG_DTYPE")]
    Dtype {
        /// The array.
        at: String,
        /// Element type found.
        found: String,
        /// The types accepted.
        needed: &'static str,
    },
    /// An array of another shape.
    #[error("`{at}` has shape {found:?}: it must be {needed}")]
    #[problem(InvalidArgument, "WRONG_SHAPE")]
    Shape {
        /// The array.
        at: String,
        /// Shape found.
        found: Vec<usize>,
        /// The shape needed, in letters.
        needed: String,
    },
    /// Arrays that disagree in length.
    #[error("{0}")]
    #[problem(InvalidArgument, "LENGTH_MISMATCH")]
    Lengths(String),
    /// A camera whose calibration is impossible.
    #[error("camera `{camera}`: {fault}: calibrate it anew or correct the file")]
    #[problem(InvalidArgument, "INVALID_CAMERA")]
    Camera {
        /// The camera's name.
        camera: String,
        /// Description of the fault.
        fault: String,
    },
    /// Extrinsics that no camera can have.
    #[error(
        "camera `{0}` is mirrored (the determinant of its extrinsics is -1): an axis was flipped when they were written; \
         write a rotation from the camera (x right, y down, z forward) to the world"
    )]
    #[problem(InvalidArgument, "MIRRORED_EXTRINSICS")]
    MirroredPose(String),
    /// An image of another size.
    #[error(
        "`{at}` is {} x {} pixels, its camera {} x {}: write all images of a camera in its size, with depth aligned to colour",
        found[0], found[1], needed[0], needed[1]
    )]
    #[problem(InvalidArgument, "WRONG_IMAGE_SIZE")]
    ImageSize {
        /// The file.
        at: String,
        /// Columns and rows of the image.
        found: [usize; 2],
        /// The camera's columns and rows.
        needed: [usize; 2],
    },
    /// A colour image that is to be shown turned.
    #[error(
        "`{at}` says by EXIF that it is to be shown {turn} (orientation {number}), and nothing says whether depth, masks and \
         intrinsics belong to its pixels as stored or as shown: set `image_orientation` beside the cameras' description to \
         \"stored\" or \"shown\", or write the images anew without EXIF"
    )]
    #[problem(InvalidArgument, "IMAGE_TURNED")]
    Turned {
        /// The file.
        at: String,
        /// The turn in words.
        turn: &'static str,
        /// EXIF's number of the turn.
        number: u8,
    },
    /// Depth in a frame other than colour's.
    #[error(
        "camera `{camera}`: no depth images have the frame_id of its colour, `{frame_id}` (there is {found}): \
         record depth aligned to colour, such as aligned_depth_to_color; docs/use/cameras.md#depth"
    )]
    #[problem(InvalidArgument, "DEPTH_NOT_ALIGNED")]
    DepthNotAligned {
        /// The camera.
        camera: String,
        /// Frame of its colour images.
        frame_id: String,
        /// The depth topics that there are.
        found: String,
    },
    /// A CameraInfo of another resolution than the images that it belongs to.
    #[error(
        "camera `{camera}`: its images are {} x {} pixels, and `{info}` describes images of {} x {}: record the camera_info \
         of these images, or images of that size; docs/use/cameras.md#calibration",
        images[0], images[1], lens[0], lens[1]
    )]
    #[problem(InvalidArgument, "LENS_SIZE_MISMATCH")]
    LensSize {
        /// The camera's name.
        camera: String,
        /// Columns and rows of its images.
        images: [usize; 2],
        /// The topic of the CameraInfo.
        info: String,
        /// Columns and rows that the CameraInfo describes.
        lens: [usize; 2],
    },
    /// Topics of images between which nothing decides, or which are all not read.
    #[error("{0}")]
    #[problem(InvalidArgument, "TOPICS_UNCLEAR")]
    Topics(String),
    /// Coordinate frames that do not place the cameras.
    #[error("{0}")]
    #[problem(InvalidArgument, "TRANSFORMS_UNCLEAR")]
    Transforms(String),
    /// A camera that a recording does not have.
    #[error("the recording has no camera number {0}")]
    #[problem(InvalidArgument, "NO_SUCH_CAMERA")]
    NoCamera(usize),
    /// An edge that names a point that is not there.
    #[error(
        "edge {index} joins points {a} and {b}, but there are {points} points (0 to {points} exclusive, two different ones)"
    )]
    #[problem(InvalidArgument, "EDGE_OUT_OF_RANGE")]
    EdgeRange {
        /// Index of the edge.
        index: usize,
        /// First end.
        a: i64,
        /// Second end.
        b: i64,
        /// Number of points.
        points: usize,
    },
    /// A pin that names a point or control point that is not there.
    #[error(
        "pin {index} joins point {point} and control point {control}, but there are {points} points and {controls} control points"
    )]
    #[problem(InvalidArgument, "PIN_OUT_OF_RANGE")]
    PinRange {
        /// Index of the pin.
        index: usize,
        /// Index of the point.
        point: i64,
        /// Index of the control point.
        control: i64,
        /// Number of points.
        points: usize,
        /// Number of control points.
        controls: usize,
    },
    /// A split outside the recording.
    #[error(
        "the split of `{sequence}` is at frame {split}, but there are {frames} frames: let it end within 0..={frames}"
    )]
    #[problem(InvalidArgument, "SPLIT_OUT_OF_RANGE")]
    SplitRange {
        /// The sequence.
        sequence: String,
        /// Frame at which it is split.
        split: i64,
        /// Length of the sequence.
        frames: usize,
    },
    /// Readable, but not fit for fitting: the first error of the check.
    #[error("the capture cannot be fitted: {message} ({code})")]
    #[problem(InvalidArgument, "UNUSABLE_CAPTURE")]
    Unusable {
        /// Code of the finding.
        code: String,
        /// The messages of all errors.
        message: String,
    },
}
