//! Every code that a report of a recording can contain.

/// Declares the codes, each once, with its name, meaning and advice.
macro_rules! codes {
    ($($code:ident $name:literal, $meaning:literal, $advice:literal;)*) => {
        /// Fault that a report of a recording can contain, in the order in which faults are worth
        /// repairing: a file that cannot be read comes before a calibration, a calibration before
        /// what is measured with it. Observed captures have the codes of `bendtwin_capture::check`;
        /// damaged files have the reader's reason.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Code {
            $(#[doc = concat!("`", $name, "`: ", $meaning, ".")] $code,)*
        }

        impl Code {
            /// All codes, in their order.
            pub const ALL: &[Self] = &[$(Self::$code),*];

            /// Stable UPPER_SNAKE_CASE word.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$code => $name,)* }
            }

            /// The fault, in a few words.
            pub const fn meaning(self) -> &'static str {
                match self { $(Self::$code => $meaning,)* }
            }

            /// The advice to the recording's owner: what to do.
            pub const fn advice(self) -> &'static str {
                match self { $(Self::$code => $advice,)* }
            }
        }
    };
}

codes! {
    // This one is reported by the check of lifted points.
    GravityDirection "GRAVITY_DIRECTION",
        "gravity does not point straight down onto the ground",
        "check the up axis";
    RecordingTooLong "RECORDING_TOO_LONG",
        "more images than a report looks at",
        "cut the recording into manipulations of a few hundred frames";
    NoFrames "NO_FRAMES",
        "no camera has a frame",
        "record again, or check the folders' names and numbering (docs/use/cameras.md#recording)";
    OneFrame "ONE_FRAME",
        "there is one frame",
        "record at least two seconds of the manipulation";
    FpsInvalid "FPS_INVALID",
        "the frame rate is no positive number",
        "give the cameras' frames per second";
    FramesDamaged "FRAMES_DAMAGED",
        "files cannot be decoded",
        "copy or export these files again";
    CameraEmpty "CAMERA_EMPTY",
        "a camera has no usable frame",
        "add its colour and depth, or remove the camera from the recording (docs/use/cameras.md#recording)";
    MeshUnusable "MESH_UNUSABLE",
        "the mesh cannot be read",
        "repair or export it again, or ingest without it (`completion.mesh`: false)";
    IntrinsicsInvalid "INTRINSICS_INVALID",
        "a focal length or principal point is no usable number",
        "calibrate the camera again, or read the intrinsics from its driver (docs/use/cameras.md#calibration)";
    IntrinsicsImplausible "INTRINSICS_IMPLAUSIBLE",
        "intrinsics do not suit the image",
        "give the intrinsics of this resolution: they scale with the image (docs/use/cameras.md#calibration)";
    NotCalibrated "NOT_CALIBRATED",
        "cameras have no pose",
        "measure the poses with a board that all cameras see, or read them from a file (docs/use/cameras.md#calibration)";
    ExtrinsicsInvalid "EXTRINSICS_INVALID",
        "a pose is not finite or has no valid rotation",
        "export the poses again as rigid camera-to-world transforms (docs/use/cameras.md#calibration)";
    ExtrinsicsMirrored "EXTRINSICS_MIRRORED",
        "a pose or the world is mirrored",
        "write right-handed poses: do not negate an axis, turn the world instead (docs/use/cameras.md#calibration)";
    ExtrinsicsInverted "EXTRINSICS_INVERTED",
        "poses are world-to-camera",
        "invert the matrices: camera-to-world is needed (docs/use/cameras.md#calibration)";
    ExtrinsicsAxes "EXTRINSICS_AXES",
        "poses are for other camera axes: OpenGL's, or a robot body's",
        "write rotations for x right, y down, z into the scene: from OpenGL's axes negate the second and third column; from a body's (x forward, y left, z up) take minus the second, minus the third and the first column, or the pose of the optical frame (docs/use/cameras.md#calibration)";
    DepthInverted "DEPTH_INVERTED",
        "depth is larger where things are nearer",
        "write depth along the optical axis, not disparities: focal length times baseline over disparity";
    DepthMisaligned "DEPTH_MISALIGNED",
        "depth is on another grid than colour and masks",
        "align depth to colour while recording (RealSense: `rs.align(rs.stream.color)`; ROS: `align_depth.enable`), and give the intrinsics of colour (docs/use/cameras.md#depth)";
    MasksMisaligned "MASKS_MISALIGNED",
        "masks are on another grid than colour and depth",
        "segment the images that are recorded, at their resolution, uncropped and not mirrored";
    ColorMisaligned "COLOR_MISALIGNED",
        "colour is mirrored against depth and masks",
        "store colour as the camera gives it: no mirroring after depth was aligned and masks were drawn";
    CamerasSwapped "CAMERAS_SWAPPED",
        "calibrations or images of cameras are exchanged",
        "exchange the calibrations of these cameras, or their folders (docs/use/cameras.md#calibration)";
    CamerasCoincide "CAMERAS_COINCIDE",
        "two cameras have one pose",
        "calibrate each camera; a copied matrix is not its pose (docs/use/cameras.md#calibration)";
    ExtrinsicsUnits "EXTRINSICS_UNITS",
        "translations of the poses are in other units than depth",
        "give the translations in the declared units (metres in a PhysTwin case) (docs/use/cameras.md#calibration)";
    DepthUnits "DEPTH_UNITS",
        "depth of all cameras is in other units",
        "declare the depth's units: `depth_unit_m` in the recording's metadata, the metres for each 1 of depth (docs/use/cameras.md#depth)";
    DepthScale "DEPTH_SCALE",
        "depth of one camera is too large or too small",
        "set this camera's depth scale as its driver gives it (docs/use/cameras.md#depth)";
    ScaleTooLarge "SCALE_TOO_LARGE",
        "the object is larger than anything that hands move",
        "check the units of depth and poses: centimetres or millimetres for metres?";
    ScaleTooSmall "SCALE_TOO_SMALL",
        "the object is smaller than a camera can resolve",
        "check the units of depth and poses: metres taken for millimetres?";
    UpAxisWrong "UP_AXIS_WRONG",
        "the world is upside down",
        "declare the axis that points up; in a PhysTwin case z points down (docs/use/cameras.md#ground)";
    MasksMissing "MASKS_MISSING",
        "there are no masks of the object",
        "mark the object and the hand with a click each, in the console or with `bendtwin capture mask`, or add the masks of any segmenter (docs/use/cameras.md#masks)";
    MasksNotFollowed "MASKS_NOT_FOLLOWED",
        "there are masks of the first images alone",
        "follow the masks through all frames: `bendtwin capture mask`, the console, or a segmenter of videos (docs/use/cameras.md#masks)";
    ObjectNotSeen "OBJECT_NOT_SEEN",
        "no mask of the object has a pixel with depth",
        "check which label is the object's, and that the masks are not black (docs/use/cameras.md#masks)";
    MaskCoversImage "MASK_COVERS_IMAGE",
        "a mask covers most of the image",
        "invert the mask: it must show the object, not the background";
    MasksSwapped "MASKS_SWAPPED",
        "masks of object and manipulator are exchanged",
        "exchange the labels in the mask's description";
    MasksOverlap "MASKS_OVERLAP",
        "pixels belong to both masks",
        "give every pixel to one of them: the segmenter counted it twice";
    DepthEmpty "DEPTH_EMPTY",
        "there is no depth on the object",
        "record depth aligned to colour; nothing can be lifted without (docs/use/cameras.md#depth)";
    DepthSparse "DEPTH_SPARSE",
        "much of the object has no depth",
        "move the camera nearer, light the scene, or use a matte object (docs/use/cameras.md#depth)";
    MaskShowsBackground "MASK_SHOWS_BACKGROUND",
        "the mask shows much that lies far from the object",
        "keep masks off the background, and align depth to colour";
    DepthNotFinite "DEPTH_NOT_FINITE",
        "depth is NaN, infinite or negative",
        "write 0 where nothing was measured";
    DepthFilled "DEPTH_FILLED",
        "a number stands for no depth",
        "write 0 where nothing was measured";
    DepthFrozen "DEPTH_FROZEN",
        "depth stands still while colour moves",
        "restart the depth stream and record again";
    ColorFrozen "COLOR_FROZEN",
        "colour stands still while depth moves",
        "restart the colour stream and record again";
    CamerasSkewed "CAMERAS_SKEWED",
        "a camera shows things later than the others",
        "synchronise the cameras by hardware, or shift its frames by the skew (docs/use/cameras.md#time)";
    ClocksDrift "CLOCKS_DRIFT",
        "the skew between cameras changes",
        "write a file for every frame, also for dropped ones, or trigger the cameras together (docs/use/cameras.md#time)";
    FramesDropped "FRAMES_DROPPED",
        "frames are missing",
        "record to a faster disk or fewer pixels; fewer USB cameras on one controller (docs/use/cameras.md#time)";
    CameraRateUnclear "CAMERA_RATE_UNCLEAR",
        "a camera has as many images as one of a lower rate, without gaps between them",
        "give the cameras' rates, as in \"fps\": [30, 15, 30], or number its images by the frame (docs/use/cameras.md#time)";
    CameraSlower "CAMERA_SLOWER",
        "a camera records at a lower rate than the others",
        "nothing: the other cameras show what happens between its frames (docs/use/cameras.md#time)";
    FramesSkipped "FRAMES_SKIPPED",
        "motion jumps although no frame is missing",
        "keep the numbers of dropped frames free instead of closing up (docs/use/cameras.md#time)";
    FramesDuplicated "FRAMES_DUPLICATED",
        "frames repeat the one before",
        "record at the rate that the camera gives, or declare its frame rate and leave the repeats out (docs/use/cameras.md#time)";
    FramesLate "FRAMES_LATE",
        "frames come later than the rate says",
        "record to a faster disk, with a fixed exposure (docs/use/cameras.md#time)";
    FpsMismatch "FPS_MISMATCH",
        "times and frame rate disagree",
        "correct the frame rate: speeds and forces depend on it (docs/use/cameras.md#time)";
    FpsImplausible "FPS_IMPLAUSIBLE",
        "the frame rate is unusual",
        "give frames per second, not the time of a frame";
    CameraOff "CAMERA_OFF",
        "a camera's calibration is off",
        "apply the correction that the report measured, calibrate this camera again, or leave it out (docs/use/cameras.md#calibration)";
    CamerasDisagree "CAMERAS_DISAGREE",
        "cameras see the object in different places",
        "calibrate the cameras again (docs/use/cameras.md#calibration)";
    BelowGround "BELOW_GROUND",
        "object points lie below the ground",
        "correct the ground's height or the up axis (docs/use/cameras.md#ground)";
    ObjectMaskEmpty "OBJECT_MASK_EMPTY",
        "the object's mask is empty in some frames",
        "segment these frames again; the object must not leave the view (docs/use/cameras.md#masks)";
    ObjectOutOfView "OBJECT_OUT_OF_VIEW",
        "the object leaves the view of a camera",
        "nothing, as long as other cameras see it";
    MaskJumps "MASK_JUMPS",
        "the area of a mask jumps",
        "look at these frames in the segmenter: it lost the object or took in something else";
    ObjectNotTracked "OBJECT_NOT_TRACKED",
        "nothing can be followed on the object from the first frame on",
        "begin the recording with the object in view, or give tracks that lie on it (docs/use/cameras.md#tracks)";
    HandNotTracked "HAND_NOT_TRACKED",
        "the hand is not in the first frame",
        "begin the recording when the hand is in view, and mask it from the first frame on (docs/use/cameras.md#masks)";
    HandLost "HAND_LOST",
        "the hand's masks have a long gap",
        "segment the hand in these frames, cut the recording there, or raise `controls.max_gap_frames` of the ingest (docs/use/cameras.md#masks)";
    NothingMoves "NOTHING_MOVES",
        "object and hand stand still",
        "record the manipulation, not the scene";
    ObjectStill "OBJECT_STILL",
        "the hand moves, the object does not",
        "check that the object's mask shows what the hand moves";
    ManipulatorNotSeen "MANIPULATOR_NOT_SEEN",
        "no hand or gripper is seen",
        "mask the hand or gripper too: nothing but gravity would move the twin (docs/use/cameras.md#masks); a gripper whose poses were recorded needs no masks (docs/use/cameras.md#grippers)";
    NoContact "NO_CONTACT",
        "the hand never touches the object",
        "record a manipulation with contact, and mask the hand that touches";
    MotionTooFast "MOTION_TOO_FAST",
        "the object moves too far between frames",
        "move more slowly or record at a higher rate";
    FewFrames "FEW_FRAMES",
        "the recording is short",
        "record at least two seconds";
    SplitEmpty "SPLIT_EMPTY",
        "too few frames are for fitting",
        "move the split";
    TracksTransposed "TRACKS_TRANSPOSED",
        "tracks are row, column instead of x, y (or the reverse)",
        "exchange the two coordinates of the tracks (docs/use/cameras.md#tracks)";
    TracksOffObject "TRACKS_OFF_OBJECT",
        "tracks lie outside the masks",
        "run the tracker on these images, at their resolution (docs/use/cameras.md#tracks)";
    TracksLost "TRACKS_LOST",
        "few tracks survive",
        "track backwards too, add query frames, or keep hands out of the view";
    TracksStill "TRACKS_STILL",
        "tracks stand still while the object moves",
        "run the tracker again: its output is a copy of the first frame";
    TracksNotFinite "TRACKS_NOT_FINITE",
        "visible tracks are NaN or infinite",
        "mark lost tracks invisible";
    TooManyCameras "TOO_MANY_CAMERAS",
        "more cameras than are compared",
        "leave out cameras that do not see the object";
    ObjectAboveGround "OBJECT_ABOVE_GROUND",
        "the object never comes near the ground",
        "check the ground's height, unless the object hangs freely (docs/use/cameras.md#ground)";
    SingleCamera "SINGLE_CAMERA",
        "one camera sees one side",
        "add a second camera opposite, or a mesh of the object (docs/use/cameras.md#recording)";
    TracksMissing "TRACKS_MISSING",
        "there are no tracks",
        "nothing: the built-in tracker follows the object; a point tracker's tracks are better on plain surfaces (docs/use/cameras.md#tracks)";
}

impl Code {
    /// The code of this name; a reader's reason is not among them.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.name() == name)
    }

    /// Place of a name in the order of repair; unknown names (a reader's reasons) come first.
    pub(crate) fn rank(name: &str) -> usize {
        Self::named(name).map_or(0, |code| code as usize)
    }
}

impl AsRef<str> for Code {
    fn as_ref(&self) -> &str {
        self.name()
    }
}

#[cfg(test)]
mod tests;
