//! The lens of a camera as a CameraInfo describes it.

use super::super::messages::Calibration;
use crate::{
    Error,
    raw::{Distortion, Intrinsics},
};

/// Coefficients of the rational model, which is read; thin prisms and tilted sensors follow them.
const RATIONAL: usize = 8;

/// The pinhole and distortion of a camera; `rectified` images have neither distortion nor K.
pub(super) fn lens(
    c: &Calibration,
    rectified: bool,
    camera: &str,
) -> Result<(Intrinsics, Distortion), Error> {
    let fail = |fault: String| Err(Error::Camera { camera: camera.to_owned(), fault });
    if rectified {
        let &[fx, _, cx, _, _, fy, cy, ..] = c.p.as_slice() else {
            return fail("its images are rectified, but its CameraInfo has no P".to_owned());
        };
        return Ok((Intrinsics { fx, fy, cx, cy }, Distortion::None));
    }
    let &[fx, skew, cx, _, fy, cy, ..] = c.k.as_slice() else {
        return fail("its CameraInfo has no K".to_owned());
    };
    if skew.abs() > 1e-6 {
        return fail(format!("its K is skewed by {skew}"));
    }
    match distortion(c) {
        Ok(distortion) => Ok((Intrinsics { fx, fy, cx, cy }, distortion)),
        Err(fault) => fail(fault),
    }
}

/// What was taken of a CameraInfo, in words.
pub(super) fn form(c: &Calibration, rectified: bool) -> String {
    match (rectified, c.d.iter().all(|d| *d == 0.0)) {
        (true, _) => "P, as the images are rectified".to_owned(),
        (false, true) => "K, no distortion".to_owned(),
        (false, false) => format!("K and D ({})", c.model.chars().take(40).collect::<String>()),
    }
}

fn distortion(c: &Calibration) -> Result<Distortion, String> {
    let model: String = c.model.chars().take(40).collect();
    let is_fisheye = matches!(c.model.as_str(), "equidistant" | "fisheye" | "kannala_brandt");
    if !is_fisheye && c.d.iter().all(|d| *d == 0.0) {
        return Ok(Distortion::None);
    }
    if is_fisheye {
        return match c.d.as_slice() {
            [k1, k2, k3, k4, rest @ ..] if rest.iter().all(|d| *d == 0.0) => {
                Ok(Distortion::KannalaBrandt([*k1, *k2, *k3, *k4]))
            }
            _ => Err(format!(
                "its distortion is `{model}` with {} coefficients: it has 4",
                c.d.len()
            )),
        };
    }
    if !matches!(c.model.as_str(), "plumb_bob" | "rational_polynomial" | "radtan") {
        return Err(format!(
            "its distortion is `{model}`: plumb_bob, rational_polynomial and equidistant are known. Rectify the images \
             (image_proc) and record image_rect"
        ));
    }
    // Drivers write the 14 numbers of OpenCV's largest model, those of thin prisms and tilt being 0.
    let (rational, rest) = c.d.split_at(c.d.len().min(RATIONAL));
    if let Some(at) = rest.iter().position(|d| *d != 0.0) {
        let what = if at < 4 { "a thin prism (s1 to s4)" } else { "a tilted sensor (tau)" };
        return Err(format!(
            "coefficient {} of its distortion is {} and not 0: {what} is not read. Calibrate with 5 or 8 coefficients, or \
             rectify the images (image_proc) and record image_rect",
            RATIONAL + at + 1,
            rest[at]
        ));
    }
    Distortion::brown_conrady(rational).ok_or_else(|| {
        format!(
            "its distortion is `{model}` with {} coefficients: 4, 5, 8, 12 or 14 are known",
            c.d.len()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(model: &str, d: &[f64]) -> Result<Distortion, String> {
        distortion(&Calibration {
            model: model.to_owned(),
            d: d.to_vec(),
            ..Calibration::default()
        })
    }

    #[test]
    fn coefficients_that_are_0_do_not_matter() {
        let eight = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];
        let expected = Distortion::BrownConrady(eight);
        for zeros in [0, 4, 6] {
            let d = [&eight[..], &vec![0.0; zeros]].concat();
            assert_eq!(of("rational_polynomial", &d), Ok(expected), "{zeros}");
            assert_eq!(of("plumb_bob", &d), Ok(expected), "{zeros}");
        }
        assert_eq!(of("thin_prism_fisheye", &[0.0; 14]), Ok(Distortion::None));
        let five = [0.1, 0.2, 0.3, 0.4, 0.0];
        assert_eq!(of("equidistant", &five), Ok(Distortion::KannalaBrandt([0.1, 0.2, 0.3, 0.4])));
        for (at, what) in [(8, "thin prism"), (11, "thin prism"), (12, "tilted"), (13, "tilted")] {
            let mut d = [0.0; 14];
            d[at] = 0.01;
            let fault = of("rational_polynomial", &d).unwrap_err();
            assert!(fault.contains(what) && fault.contains(&(at + 1).to_string()), "{fault}");
        }
        assert!(of("thin_prism_fisheye", &eight).is_err());
        assert!(of("equidistant", &eight).is_err());
        assert!(of("plumb_bob", &eight[..7]).is_err());
    }
}
