//! The parts of `transforms.json` that are read; the rest concerns the training of radiance fields.

use serde::Deserialize;

use crate::{
    Error,
    bundle::Ground,
    raw::{Distortion, Intrinsics},
};

#[derive(Deserialize)]
pub(super) struct Document {
    #[serde(flatten)]
    pub(super) lens: Lens,
    pub(super) frames: Vec<FrameEntry>,
    pub(super) depth_unit_scale_factor: Option<f64>,
    pub(super) applied_scale: Option<f64>,
    pub(super) fps: Option<f64>,
    pub(super) up_axis: Option<String>,
    pub(super) ground: Option<Ground>,
    pub(super) train_frame_count: Option<usize>,
    pub(super) image_orientation: Option<String>,
}

impl Document {
    /// Writes all paths with `/`, as programs on Windows do not.
    pub(super) fn settle_paths(&mut self) {
        for frame in &mut self.frames {
            let optional = [
                &mut frame.depth_file_path,
                &mut frame.mask_path,
                &mut frame.manipulator_mask_path,
            ];
            for path in optional.into_iter().flatten().chain([&mut frame.file_path]) {
                if path.contains('\\') {
                    *path = path.replace('\\', "/");
                }
            }
        }
    }
}

#[derive(Deserialize)]
pub(super) struct FrameEntry {
    #[serde(flatten)]
    pub(super) lens: Lens,
    pub(super) file_path: String,
    pub(super) depth_file_path: Option<String>,
    pub(super) mask_path: Option<String>,
    pub(super) manipulator_mask_path: Option<String>,
    /// Camera to world, row-major, shape [4, 4] or [3, 4].
    pub(super) transform_matrix: Vec<[f64; 4]>,
    pub(super) camera_label: Option<Label>,
    pub(super) frame_index: Option<usize>,
    /// Seconds.
    pub(super) time: Option<f64>,
}

#[derive(Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum Label {
    Text(String),
    Number(i64),
}

/// Intrinsics of a frame or, as a default, of all frames.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub(super) struct Lens {
    camera_model: Option<String>,
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    w: Option<f64>,
    h: Option<f64>,
    k1: Option<f64>,
    k2: Option<f64>,
    k3: Option<f64>,
    k4: Option<f64>,
    p1: Option<f64>,
    p2: Option<f64>,
}

/// Centre of the first pixel in nerfstudio; OpenCV has it at 0.
pub(super) const PIXEL_CENTER: f64 = 0.5;

impl Lens {
    pub(super) fn or(&self, all: &Self) -> Self {
        Self {
            camera_model: self.camera_model.clone().or_else(|| all.camera_model.clone()),
            fl_x: self.fl_x.or(all.fl_x),
            fl_y: self.fl_y.or(all.fl_y),
            cx: self.cx.or(all.cx),
            cy: self.cy.or(all.cy),
            w: self.w.or(all.w),
            h: self.h.or(all.h),
            k1: self.k1.or(all.k1),
            k2: self.k2.or(all.k2),
            k3: self.k3.or(all.k3),
            k4: self.k4.or(all.k4),
            p1: self.p1.or(all.p1),
            p2: self.p2.or(all.p2),
        }
    }

    pub(super) fn size(&self, camera: &str) -> Result<[usize; 2], Error> {
        let side = |key: &str, value: Option<f64>| match value {
            Some(n) if (1.0..1e9).contains(&n) && n.fract() == 0.0 => Ok(n as usize),
            Some(n) => Err(fault(camera, format!("`{key}` is {n}: give a whole number of pixels"))),
            None => Err(fault(camera, format!("`{key}` is missing: give w and h in pixels"))),
        };
        Ok([side("w", self.w)?, side("h", self.h)?])
    }

    pub(super) fn intrinsics(&self, camera: &str) -> Result<Intrinsics, Error> {
        let need = |key: &str, value: Option<f64>| {
            value.ok_or_else(|| {
                fault(camera, format!("`{key}` is missing: give fl_x, fl_y, cx and cy in pixels"))
            })
        };
        let fx = need("fl_x", self.fl_x)?;
        Ok(Intrinsics {
            fx,
            fy: self.fl_y.unwrap_or(fx),
            cx: need("cx", self.cx)? - PIXEL_CENTER,
            cy: need("cy", self.cy)? - PIXEL_CENTER,
        })
    }

    pub(super) fn distortion(&self, camera: &str) -> Result<Distortion, Error> {
        let [k1, k2, k3, k4, p1, p2] =
            [self.k1, self.k2, self.k3, self.k4, self.p1, self.p2].map(|k| k.unwrap_or(0.0));
        let model = self.camera_model.as_deref().unwrap_or("OPENCV");
        match model {
            "OPENCV_FISHEYE" => Ok(Distortion::KannalaBrandt([k1, k2, k3, k4])),
            "OPENCV" | "PINHOLE" | "SIMPLE_PINHOLE" | "SIMPLE_RADIAL" | "RADIAL" if k4 == 0.0 => {
                let coefficients = [k1, k2, p1, p2, k3];
                Ok(Distortion::brown_conrady(&coefficients).unwrap_or_default())
            }
            "OPENCV" => Err(fault(
                camera,
                "k4 of the OPENCV model is a fourth radial term that OpenCV does not have: calibrate with k1 to k3"
                    .into(),
            )),
            other => Err(unknown(camera, other)),
        }
    }
}

fn unknown(camera: &str, model: &str) -> Error {
    fault(
        camera,
        format!(
            "its camera_model is `{}`: PINHOLE, OPENCV and OPENCV_FISHEYE are known",
            model.chars().take(40).collect::<String>()
        ),
    )
}

fn fault(camera: &str, fault: String) -> Error {
    Error::Camera { camera: camera.to_owned(), fault }
}
