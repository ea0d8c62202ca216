//! Hypotheses about calibrations: the cameras as they would stand if a certain mistake had been
//! made and were undone.

use bendtwin_capture::raw::{Camera, Pose};

use super::View;

/// A change of one camera's calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PoseChange {
    /// The calibration as declared.
    None,
    /// World-to-camera was written for camera-to-world.
    Inverse,
    /// Only the rotation is transposed.
    RotationInverse,
    /// OpenGL's camera axes were written for OpenCV's.
    OpenGl,
    /// The axes of a robot's body (x forward, y left, z up; ROS REP 103) were written for OpenCV's.
    Body,
    /// Both the inversion and OpenGL's axes.
    InverseOpenGl,
    /// The world was mirrored along an axis, and the camera's x with it.
    Mirrored(usize),
    /// A coordinate of the translation has the wrong sign.
    MirroredPlace(usize),
    /// Translations are in other units.
    Units(f64),
}

/// The supposed calibration of one camera.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraHypothesis {
    /// The view whose declared calibration it has, an index into the views.
    pub(crate) calibration: usize,
    pub(crate) change: PoseChange,
    /// Factor that its depth is multiplied by.
    pub(crate) depth_scale: f64,
    /// Moves the camera after all that: rotation about a pivot, then translation.
    pub(crate) moved: Option<Pose>,
}

/// A supposed calibration for every view.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hypothesis(pub(crate) Vec<CameraHypothesis>);

/// A camera with its supposed pose and the factor for its depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosedCamera<'a> {
    pub(crate) camera: &'a Camera,
    pub(crate) pose: Pose,
    pub(crate) depth_scale: f64,
}

impl Hypothesis {
    /// Everything as declared.
    pub(crate) fn declared(count: usize) -> Self {
        let one = |calibration| CameraHypothesis {
            calibration,
            change: PoseChange::None,
            depth_scale: 1.0,
            moved: None,
        };
        Self((0..count).map(one).collect())
    }

    /// The hypothesis with the calibration of one view changed.
    pub(crate) fn with(&self, view: usize, change: impl FnOnce(&mut CameraHypothesis)) -> Self {
        let mut other = self.clone();
        other.0.get_mut(view).into_iter().for_each(change_once(change));
        other
    }

    /// The hypothesis with every calibration changed.
    pub(crate) fn with_all(&self, change: impl Fn(&mut CameraHypothesis)) -> Self {
        let mut other = self.clone();
        other.0.iter_mut().for_each(change);
        other
    }

    /// A view's camera as supposed, in a frame; `None` if there is no such view.
    pub(crate) fn posed<'a>(
        &self,
        views: &[View<'a>],
        view: usize,
        frame: usize,
    ) -> Option<PosedCamera<'a>> {
        let supposed = self.0.get(view)?;
        let camera = views.get(view)?.camera;
        let declared = views.get(supposed.calibration)?.camera.pose(frame);
        let mut pose = supposed.change.apply(declared);
        if let Some(moved) = &supposed.moved {
            pose = moved.after(&pose);
        }
        Some(PosedCamera { camera, pose, depth_scale: supposed.depth_scale })
    }
}

/// `for_each` wants a function that can be called often; this one is called once at most.
fn change_once<'a>(
    change: impl FnOnce(&mut CameraHypothesis) + 'a,
) -> impl FnMut(&mut CameraHypothesis) + 'a {
    let mut change = Some(change);
    move |supposed| {
        if let Some(change) = change.take() {
            change(supposed);
        }
    }
}

impl PoseChange {
    pub(crate) fn apply(self, pose: &Pose) -> Pose {
        let Pose { rotation: r, translation: t } = *pose;
        let transposed = std::array::from_fn(|i| std::array::from_fn(|j| r[j][i]));
        let sign = |axis: usize, at: usize| if axis == at { -1.0 } else { 1.0 };
        match self {
            Self::None => *pose,
            Self::Inverse => pose.inverse(),
            Self::RotationInverse => Pose { rotation: transposed, translation: t },
            Self::OpenGl => Pose { rotation: r.map(|[x, y, z]| [x, -y, -z]), translation: t },
            // OpenCV's z is the body's x, its x the body's -y, its y the body's -z.
            Self::Body => Pose { rotation: r.map(|[x, y, z]| [-y, -z, x]), translation: t },
            Self::InverseOpenGl => Self::OpenGl.apply(&Self::Inverse.apply(pose)),
            Self::Mirrored(axis) => Pose {
                rotation: std::array::from_fn(|i| {
                    std::array::from_fn(|j| r[i][j] * sign(axis, i) * sign(0, j))
                }),
                translation: std::array::from_fn(|i| t[i] * sign(axis, i)),
            },
            Self::MirroredPlace(axis) => {
                Pose { rotation: r, translation: std::array::from_fn(|i| t[i] * sign(axis, i)) }
            }
            Self::Units(factor) => Pose { rotation: r, translation: t.map(|x| x * factor) },
        }
    }
}
