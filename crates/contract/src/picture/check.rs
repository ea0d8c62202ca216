//! The check of pictures. Numbers of slots, cameras and pixels come before the values of tensors, and nothing is
//! allocated but shapes.

use bendtwin_proto::v1::{
    Light, PictureCamera, Prop, RenderSessionRequest, Tensor, prop::Shape,
    render_session_request::Look, tensor::Dtype,
};

use super::Error;
use crate::rollout::{self, Limits, SHORTEST_QUATERNION, tensors, world};

/// Most slots of which pictures are taken together.
pub const MAX_SLOTS: u64 = 1024;
/// Most cameras.
pub const MAX_CAMERAS: usize = 8;
/// Fewest and most columns or rows of a picture.
const SIDES: std::ops::RangeInclusive<u32> = 8..=MAX_SIDE;
/// Most columns or rows of a picture.
pub const MAX_SIDE: u32 = 2048;
/// Most pixels of all pictures of a request together.
pub const MAX_PIXELS: u64 = 1 << 23;
/// Most props.
pub const MAX_PROPS: usize = 64;
/// Largest focal length, or distance of the principal point from the first pixel [px].
const MOST_FOCAL_PX: f32 = 1e6;
/// Farthest that anything is from the origin [m].
const FARTHEST_M: f32 = 1000.0;
/// Largest factor of the light.
const MOST_BRIGHTNESS: f32 = 4.0;
/// Bytes of the reply beside pixels: for each array, and for each slot.
const ARRAY: u64 = 64;
const SLOT: u64 = 8;
/// Memory of a reply at a worker, beside its size: as pictures, as arrays, and as a message.
const COPIES: u64 = 3;

/// Checks a request for pictures of a number of slots.
///
/// # Errors
/// The first fault that is found.
pub fn check_pictures(
    request: &RenderSessionRequest,
    slots: u64,
    limits: &Limits,
) -> Result<(), Error> {
    if slots > MAX_SLOTS {
        let fault = format!("are {slots}: pictures of at most {MAX_SLOTS} are taken together");
        return Err(Error::field("slots", fault));
    }
    look(request)?;
    let cameras = request.cameras.len();
    if !(1..=MAX_CAMERAS).contains(&cameras) {
        let fault = format!("are {cameras}: give 1 to {MAX_CAMERAS}");
        return Err(Error::field("cameras", fault));
    }
    for (i, camera) in request.cameras.iter().enumerate() {
        let field = |part: &str| format!("cameras[{i}].{part}");
        for (part, side) in [("width", camera.width), ("height", camera.height)] {
            if !SIDES.contains(&side) {
                let fault =
                    format!("is {side}: {} to {MAX_SIDE} pixels are possible", SIDES.start());
                return Err(Error::field(field(part), fault));
            }
        }
    }
    let advice = "take smaller pictures, or of fewer slots together";
    within("the number of pixels", pixels(request, slots), MAX_PIXELS, advice)?;
    let bytes = reply_bytes(request, slots);
    within("the size of the reply in bytes", bytes, limits.reply_bytes, advice)?;
    let bytes = memory_bytes(request, slots);
    within("the memory at a worker in bytes", bytes, limits.memory_bytes, advice)?;
    for (i, camera) in request.cameras.iter().enumerate() {
        self::camera(camera, &|part| format!("cameras[{i}].{part}"), slots, limits)?;
    }
    if request.props.len() > MAX_PROPS {
        let fault = format!("are {}: at most {MAX_PROPS} are possible", request.props.len());
        return Err(Error::field("props", fault));
    }
    for (i, prop) in request.props.iter().enumerate() {
        self::prop(prop, &|part| format!("props[{i}].{part}"), slots)?;
    }
    request.light.as_ref().map_or(Ok(()), |light| self::light(light, slots))
}

/// The look that is asked for.
///
/// # Errors
/// If there is no such look.
pub fn look(request: &RenderSessionRequest) -> Result<Look, Error> {
    Look::try_from(request.look).map_err(|_| {
        let fault = format!("is {}: SURFACE and GAUSSIANS are possible", request.look);
        Error::field("look", fault)
    })
}

/// Pixels of all pictures.
pub fn pixels(request: &RenderSessionRequest, slots: u64) -> u64 {
    let of = |camera: &PictureCamera| u64::from(camera.width) * u64::from(camera.height);
    let each = request.cameras.iter().map(of).fold(0, u64::saturating_add);
    each.saturating_mul(slots)
}

/// Largest size of the reply [bytes].
pub fn reply_bytes(request: &RenderSessionRequest, slots: u64) -> u64 {
    let pixel = 3 + if request.depths { 4 } else { 0 } + u64::from(request.labels);
    let arrays = (3 * ARRAY).saturating_mul(request.cameras.len() as u64);
    pixels(request, slots)
        .saturating_mul(pixel)
        .saturating_add(arrays)
        .saturating_add(slots.saturating_mul(SLOT))
        .saturating_add(ARRAY)
}

/// Memory of the pictures at a worker, beside what it draws them with [bytes].
pub fn memory_bytes(request: &RenderSessionRequest, slots: u64) -> u64 {
    reply_bytes(request, slots).saturating_mul(COPIES)
}

fn camera(
    camera: &PictureCamera,
    field: &impl Fn(&str) -> String,
    slots: u64,
    limits: &Limits,
) -> Result<(), Error> {
    let is_printable = !camera.name.chars().any(char::is_control);
    if camera.name.len() as u64 > limits.name_bytes || !is_printable {
        let fault = format!("is longer than {} bytes or not printable", limits.name_bytes);
        return Err(Error::field(field("name"), fault));
    }
    let intrinsics = required(&camera.intrinsics, &field("intrinsics"))?;
    rows(intrinsics, &field("intrinsics"), Dtype::Float32, &[4], slots)?;
    for values in groups::<4>(intrinsics) {
        let [fx, fy, ..] = values;
        let is_possible = |x: &f32| x.abs() <= MOST_FOCAL_PX;
        if !values.iter().all(is_possible) || fx <= 0.0 || fy <= 0.0 {
            let fault = format!(
                "has {values:?}: fx and fy must be above 0, and all within {MOST_FOCAL_PX} pixels"
            );
            return Err(Error::field(field("intrinsics"), fault));
        }
    }
    pose(required(&camera.pose, &field("pose"))?, &field("pose"), slots)?;
    let Some(background) = tensors::given(camera.background.as_ref()) else { return Ok(()) };
    let name = field("background");
    let (_, shape) = tensors::required(Some(background), &name, Dtype::Uint8)?;
    let (height, width) = (u64::from(camera.height), u64::from(camera.width));
    match shape[..] {
        [3] => Ok(()),
        [s, 3] if s == slots => Ok(()),
        [h, w, 3] if (h, w) == (height, width) => Ok(()),
        [s, h, w, 3] if s == slots && (h, w) == (height, width) => Ok(()),
        _ => {
            let fault = format!(
                "has shape {shape:?}, not [{height}, {width}, 3] or [3], with the {slots} slots in front if they differ"
            );
            Err(Error::field(name, fault))
        }
    }
}

fn prop(prop: &Prop, field: &impl Fn(&str) -> String, slots: u64) -> Result<(), Error> {
    match &prop.shape {
        None => {
            let fault = "is missing: give sphere, capsule, cuboid or convex_mesh";
            return Err(Error::field(field("shape"), fault));
        }
        Some(Shape::Sphere(s)) => world::sphere(s, &field("sphere"))?,
        Some(Shape::Capsule(c)) => world::capsule(c, &field("capsule"))?,
        Some(Shape::Cuboid(c)) => world::cuboid(c, &field("cuboid"))?,
        Some(Shape::ConvexMesh(m)) => {
            world::mesh(m.points.as_ref(), &field("convex_mesh.points"))?;
        }
    }
    if let Some(given) = tensors::given(prop.pose.as_ref()) {
        pose(given, &field("pose"), slots)?;
    }
    match tensors::given(prop.color.as_ref()) {
        Some(color) => rows(color, &field("color"), Dtype::Uint8, &[3], slots),
        None => Ok(()),
    }
}

fn light(light: &Light, slots: u64) -> Result<(), Error> {
    if let Some(direction) = tensors::given(light.direction.as_ref()) {
        const FIELD: &str = "light.direction";
        rows(direction, FIELD, Dtype::Float32, &[3], slots)?;
        for values in groups::<3>(direction) {
            let longest = values.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
            if !values.iter().all(|x| x.is_finite()) || longest < f32::MIN_POSITIVE {
                let fault =
                    format!("has {values:?}: three finite numbers, not all 0, are a direction");
                return Err(Error::field(FIELD, fault));
            }
        }
    }
    share(light.ambient.as_ref(), "light.ambient", 1.0, slots)?;
    share(light.brightness.as_ref(), "light.brightness", MOST_BRIGHTNESS, slots)
}

/// Checks numbers from 0 to `most`, one or one for each slot.
fn share(tensor: Option<&Tensor>, field: &str, most: f32, slots: u64) -> Result<(), Error> {
    let Some(tensor) = tensors::given(tensor) else { return Ok(()) };
    let (_, shape) = tensors::required(Some(tensor), field, Dtype::Float32)?;
    if !matches!(shape[..], [count] if count == 1 || count == slots) {
        let fault = format!("has shape {shape:?}, not [1] or [{slots}], the slots");
        return Err(Error::field(field, fault));
    }
    match tensors::floats(tensor).find(|x| !(0.0..=most).contains(x)) {
        Some(x) => Err(Error::field(field, format!("has {x}: it must lie in 0..={most}"))),
        None => Ok(()),
    }
}

/// Checks poses, one or one for each slot.
fn pose(tensor: &Tensor, field: &str, slots: u64) -> Result<(), Error> {
    rows(tensor, field, Dtype::Float32, &[7], slots)?;
    for values in groups::<7>(tensor) {
        if let Some(x) = values[..3].iter().find(|x| !x.is_finite() || x.abs() > FARTHEST_M) {
            let fault = format!("has {x}: coordinates are in metres, up to {FARTHEST_M}");
            return Err(Error::field(field, fault));
        }
        let quaternion = &values[3..];
        let longest = quaternion.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        if !quaternion.iter().all(|x| x.is_finite()) || longest < SHORTEST_QUATERNION {
            let fault = format!(
                "has the quaternion {quaternion:?}: it must be finite and not of length zero; no rotation is [0, 0, 0, 1]"
            );
            return Err(Error::field(field, fault));
        }
    }
    Ok(())
}

fn required<'t>(tensor: &'t Option<Tensor>, field: &str) -> Result<&'t Tensor, Error> {
    tensors::given(tensor.as_ref()).ok_or_else(|| Error::field(field, "is missing"))
}

/// Refuses a tensor that is not of this shape, alone or with the slots in front.
fn rows(
    tensor: &Tensor,
    field: &str,
    dtype: Dtype,
    inner: &[u64],
    slots: u64,
) -> Result<(), Error> {
    let (_, shape) = tensors::required(Some(tensor), field, dtype)?;
    match shape.split_first() {
        _ if shape == inner => Ok(()),
        Some((first, rest)) if *first == slots && rest == inner => Ok(()),
        _ => {
            let fault = format!(
                "has shape {shape:?}, not {inner:?}, with the {slots} slots in front if they differ"
            );
            Err(Error::field(field, fault))
        }
    }
}

/// Numbers of a checked FLOAT32 tensor, N at a time.
fn groups<const N: usize>(tensor: &Tensor) -> impl Iterator<Item = [f32; N]> + '_ {
    let numbers = tensor.data.as_chunks::<4>().0.as_chunks::<N>().0;
    numbers.iter().map(|group| group.map(f32::from_le_bytes))
}

fn within(what: &'static str, asked: u64, limit: u64, advice: &'static str) -> Result<(), Error> {
    if asked > limit {
        return Err(rollout::Error::TooLarge { what, asked, limit, advice }.into());
    }
    Ok(())
}
