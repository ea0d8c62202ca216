//! Kalibr's `camchain.yaml`: `cam0`, `cam1`, ..., each with its pinhole and lens, and from the second
//! on with the motion `T_cn_cnm1` from the camera before it. The world is the first camera's.

use bendtwin_capture::raw::{Distortion, Intrinsics, Pose};

use super::{Described, matrix, value::Value};

/// The cameras of a chain; `None` if it is another document.
pub(super) fn cameras(document: &Value) -> Result<Option<Vec<Described>>, String> {
    let chain: Vec<&(String, Value)> = document
        .entries()
        .iter()
        .filter(|(_, value)| {
            value.get(&["camera_model"]).is_some() && value.get(&["intrinsics"]).is_some()
        })
        .collect();
    if chain.is_empty() {
        return Ok(None);
    }
    let mut cameras = Vec::new();
    // From the first camera to this one.
    let mut so_far: Option<Pose> = Some(Pose::IDENTITY);
    for (index, (key, value)) in chain.into_iter().enumerate() {
        if index > 0 {
            let step = value.get(&["T_cn_cnm1"]).and_then(matrix::motion);
            so_far = step.zip(so_far).map(|(step, before)| step.after(&before));
        }
        cameras.push(Described {
            name: value.get(&["rostopic"]).and_then(Value::text).unwrap_or(key).to_owned(),
            size: size(value),
            intrinsics: Some(intrinsics(key, value)?),
            distortion: Some(distortion(key, value)?),
            pose: so_far.map(|motion| motion.inverse()),
        });
    }
    if let Some(lost) = cameras.iter().find(|camera| camera.pose.is_none()) {
        return Err(format!(
            "`{}` has no T_cn_cnm1 of 4 x 4: calibrate all cameras in one run of kalibr_calibrate_cameras",
            lost.name
        ));
    }
    Ok(Some(cameras))
}

fn size(value: &Value) -> Option<[usize; 2]> {
    let [width, height] = matrix::flat(value.get(&["resolution"])?)?.try_into().ok()?;
    let whole = |x: f64| ((1.0..1e6).contains(&x) && x.fract() == 0.0).then_some(x as usize);
    Some([whole(width)?, whole(height)?])
}

fn intrinsics(key: &str, value: &Value) -> Result<Intrinsics, String> {
    let model = value.get(&["camera_model"]).and_then(Value::text).unwrap_or_default();
    if model != "pinhole" {
        let model: String = model.chars().take(20).collect();
        return Err(format!(
            "`{key}` has the camera model `{model}`: pinhole is read; calibrate with pinhole-radtan or pinhole-equi"
        ));
    }
    match value.get(&["intrinsics"]).and_then(matrix::flat).as_deref() {
        Some([fx, fy, cx, cy]) => Ok(Intrinsics { fx: *fx, fy: *fy, cx: *cx, cy: *cy }),
        _ => Err(format!("`{key}` needs 4 intrinsics: fx, fy, cx, cy")),
    }
}

fn distortion(key: &str, value: &Value) -> Result<Distortion, String> {
    let model = value.get(&["distortion_model"]).and_then(Value::text).unwrap_or("none");
    let numbers = value.get(&["distortion_coeffs"]).and_then(matrix::flat).unwrap_or_default();
    match model {
        "none" => Ok(Distortion::None),
        "radtan" => matrix::distortion(&numbers, false),
        "equidistant" => matrix::distortion(&numbers, true),
        other => {
            let other: String = other.chars().take(20).collect();
            Err(format!(
                "`{key}` has the distortion `{other}`: radtan, equidistant and none are read"
            ))
        }
    }
}
