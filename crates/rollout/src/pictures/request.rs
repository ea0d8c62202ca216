//! The parts of a checked request for pictures, in the types of the renderer.

use bendtwin_contract::picture;
use bendtwin_core::{
    CancelToken, Point,
    geometry::{self, add, unit},
};
use bendtwin_engine::backend;
use bendtwin_proto::v1::{self, PictureCamera, RenderSessionRequest, Tensor, prop::Shape};
use bendtwin_render::{Background, Face, Light, Pose, Prop, Solid, Wanted};
use bendtwin_splat::Camera;
use bytes::Bytes;

use super::row::PerSlot;
use crate::{
    error::Error,
    world::{hull, sides, three},
};

/// Background and colour of props where none is given (sRGB): greys.
const BACKGROUND: [u8; 3] = [214, 214, 214];
const PROP: [u8; 3] = [150, 150, 150];
/// Share of the even light, and brightness, where they are not given.
const AMBIENT: f32 = 0.5;
const BRIGHTNESS: f32 = 1.0;

/// A request for pictures.
pub(super) struct Asked {
    pub(super) cameras: Vec<AskedCamera>,
    pub(super) wanted: Wanted,
    props: Vec<AskedProp>,
    /// Direction of the light; `None` for that of the first camera.
    direction: Option<PerSlot<[f32; 3]>>,
    ambient: PerSlot<[f32; 1]>,
    brightness: PerSlot<[f32; 1]>,
}

/// A camera for all slots, or one for each.
pub(super) struct AskedCamera {
    pub(super) width: u32,
    pub(super) height: u32,
    intrinsics: PerSlot<[f32; 4]>,
    pose: PerSlot<[f32; 7]>,
    background: Backdrop,
}

enum Backdrop {
    Colors(PerSlot<[u8; 3]>),
    /// An image for all slots, or one for each.
    Images {
        colors: Bytes,
        differ: bool,
    },
}

struct AskedProp {
    solid: Solid,
    pose: PerSlot<[f32; 7]>,
    color: PerSlot<[u8; 3]>,
}

impl Asked {
    /// Reads a checked request.
    ///
    /// # Errors
    /// If a tensor is not what the check saw, the points of a convex mesh have no hull, or on cancellation.
    pub(super) fn read(request: RenderSessionRequest, cancel: &CancelToken) -> Result<Self, Error> {
        let cameras = request.cameras.into_iter().enumerate();
        let cameras = cameras.map(|(i, camera)| AskedCamera::read(camera, i));
        let props = request.props.into_iter().enumerate().map(|(i, prop)| {
            if cancel.is_cancelled() {
                return Err(backend::Error::Cancelled.into());
            }
            AskedProp::read(prop, i)
        });
        let light = request.light.unwrap_or_default();
        let share = |tensor: Option<Tensor>, field: &str, default: f32| match given(tensor) {
            Some(tensor) => PerSlot::floats(&tensor, field),
            None => Ok(PerSlot::all([default])),
        };
        let direction = given(light.direction);
        let direction = direction.map(|tensor| PerSlot::floats(&tensor, "light.direction"));
        Ok(Self {
            cameras: cameras.collect::<Result<_, _>>()?,
            wanted: Wanted { depths: request.depths, labels: request.labels },
            props: props.collect::<Result<_, _>>()?,
            direction: direction.transpose()?,
            ambient: share(light.ambient, "light.ambient", AMBIENT)?,
            brightness: share(light.brightness, "light.brightness", BRIGHTNESS)?,
        })
    }

    /// Pixels of the pictures of a slot.
    pub(super) fn slot_pixels(&self) -> usize {
        self.cameras.iter().map(|camera| camera.width as usize * camera.height as usize).sum()
    }

    /// The props of a slot.
    pub(super) fn props_of(&self, slot: usize) -> Vec<Prop<'_>> {
        let of = |prop: &'_ AskedProp| (Pose::new(prop.pose.of(slot)), prop.color.of(slot));
        let placed = |prop| {
            let (pose, color) = of(prop);
            Prop { solid: &prop.solid, pose, color }
        };
        self.props.iter().map(placed).collect()
    }

    /// The light of a slot.
    pub(super) fn light(&self, slot: usize) -> Light {
        let up = [0.0, 0.0, 1.0];
        let direction = match (&self.direction, self.cameras.first()) {
            (Some(direction), _) => geometry::wide(direction.of(slot)),
            (None, Some(camera)) => {
                let behind = Pose::new(camera.pose.of(slot)).rotation.map(|row| -row[2]);
                add(up, behind)
            }
            (None, None) => up,
        };
        // Scaled first, as the square of a tiny length is 0.
        let longest = direction.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let direction = unit(direction.map(|x| x / longest.max(f64::MIN_POSITIVE))).unwrap_or(up);
        let ([ambient], [brightness]) = (self.ambient.of(slot), self.brightness.of(slot));
        Light { direction: direction.map(|x| x as f32), ambient, brightness }
    }
}

impl AskedCamera {
    fn read(camera: PictureCamera, index: usize) -> Result<Self, Error> {
        let field = |part: &str| format!("cameras[{index}].{part}");
        let (width, height) = (camera.width, camera.height);
        let intrinsics = camera.intrinsics.unwrap_or_default();
        let pose = camera.pose.unwrap_or_default();
        let background = match given(camera.background) {
            None => Backdrop::Colors(PerSlot::all(BACKGROUND)),
            Some(tensor) if tensor.shape.len() <= 2 => {
                Backdrop::Colors(PerSlot::colors(&tensor, &field("background"))?)
            }
            Some(tensor) => {
                Backdrop::Images { differ: tensor.shape.len() == 4, colors: tensor.data }
            }
        };
        Ok(Self {
            width,
            height,
            intrinsics: PerSlot::floats(&intrinsics, &field("intrinsics"))?,
            pose: PerSlot::floats(&pose, &field("pose"))?,
            background,
        })
    }

    /// The camera of a slot.
    pub(super) fn of(&self, slot: usize) -> Camera {
        let [fx, fy, cx, cy] = self.intrinsics.of(slot);
        let world_to_camera = Pose::new(self.pose.of(slot)).world_to_camera();
        Camera { width: self.width, height: self.height, fx, fy, cx, cy, world_to_camera }
    }

    /// The background of a slot.
    pub(super) fn background_of(&self, slot: usize) -> Background<'_> {
        match &self.background {
            Backdrop::Colors(colors) => Background::Color(colors.of(slot)),
            Backdrop::Images { colors, differ } => {
                let size = 3 * self.width as usize * self.height as usize;
                let first = if *differ { slot * size } else { 0 };
                Background::Image(colors.get(first..first + size).unwrap_or_default())
            }
        }
    }
}

impl AskedProp {
    fn read(prop: v1::Prop, index: usize) -> Result<Self, Error> {
        let field = |part: &str| format!("props[{index}].{part}");
        let solid = match prop.shape {
            None => return Err(picture::Error::field(field("shape"), "is missing").into()),
            Some(Shape::Sphere(sphere)) => {
                let center = three(&sphere.center);
                Solid::Round { from: center, to: center, radius_m: sphere.radius_m }
            }
            Some(Shape::Capsule(capsule)) => Solid::Round {
                from: three(&capsule.from),
                to: three(&capsule.to),
                radius_m: capsule.radius_m,
            },
            Some(Shape::Cuboid(cuboid)) => {
                let bounds = [three(&cuboid.low), three(&cuboid.high)];
                convex(sides(bounds[0], bounds[1]), bounds)
            }
            Some(Shape::ConvexMesh(mesh)) => {
                let field = field("convex_mesh.points");
                let (_, points) = mesh.points.unwrap_or_default().unpack_points(&field)?;
                let bounds = geometry::bounds(&points).unwrap_or_default();
                let faces = hull(&points);
                let faces =
                    faces.map_err(|fault| picture::Error::field(field, fault.to_string()))?;
                convex(faces, bounds)
            }
        };
        let pose = match given(prop.pose) {
            Some(tensor) => PerSlot::floats(&tensor, &field("pose"))?,
            None => PerSlot::all([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
        };
        let color = match given(prop.color) {
            Some(tensor) => PerSlot::colors(&tensor, &field("color"))?,
            None => PerSlot::all(PROP),
        };
        Ok(Self { solid, pose, color })
    }
}

fn convex(faces: Vec<bendtwin_engine::world::Face>, bounds: [Point; 2]) -> Solid {
    let face =
        |face: bendtwin_engine::world::Face| Face { normal: face.normal, offset_m: face.offset_m };
    Solid::Convex { faces: faces.into_iter().map(face).collect(), bounds }
}

fn given(tensor: Option<Tensor>) -> Option<Tensor> {
    tensor.filter(|tensor| !tensor.is_absent())
}
