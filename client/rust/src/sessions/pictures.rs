//! Pictures of the states of a session.

use bendtwin_core::ids::SessionId;
use bendtwin_proto::v1::{
    self, RenderSessionRequest, RenderedSession, Tensor, collider, prop,
    render_session_request::Look,
};

use crate::{Error, Point, Shape, WirePose};

/// A camera without distortion. Its axes are those of OpenCV: x to the right, y down, z forward; the centre of the
/// first pixel is at (0, 0).
#[derive(Clone, Debug)]
pub struct PictureCamera(v1::PictureCamera);

/// A rigid thing in pictures, which the simulation does not know.
#[derive(Clone, Debug)]
pub struct Prop(v1::Prop);

/// Pictures to be taken.
#[derive(Clone, Debug, Default)]
pub struct Rendering(RenderSessionRequest);

/// The pictures that a camera took, one for each slot. S is the number of slots.
#[derive(Clone, Debug, PartialEq)]
pub struct Pictures {
    /// Slots, rows and columns of the arrays.
    pub shape: [usize; 3],
    /// Colours (sRGB), shape [S, height, width, 3].
    pub colors: Vec<u8>,
    /// Distance along the camera's axis of what the label names [m]; 0 for the background. Shape [S, height, width];
    /// empty if they were not asked for.
    pub depths: Vec<f32>,
    /// What covers most of a pixel: 0 the background, 1 the object, 2 + i prop i. Shape [S, height, width]; empty if
    /// they were not asked for.
    pub labels: Vec<u8>,
}

impl PictureCamera {
    /// A camera with `[width, height]` and the intrinsics fx, fy, cx, cy in pixels, and its pose in the world.
    pub fn new([width, height]: [u32; 2], intrinsics: [f32; 4], pose: WirePose) -> Self {
        Self(v1::PictureCamera {
            width,
            height,
            intrinsics: Some(Tensor::pack(&[4], &intrinsics)),
            pose: Some(Tensor::pack(&[7], &pose)),
            ..v1::PictureCamera::default()
        })
    }

    /// Sets a pose for each slot, in their order.
    #[must_use]
    pub fn poses(mut self, poses: &[WirePose]) -> Self {
        self.0.pose = Some(Tensor::pack(&[poses.len(), 7], poses.as_flattened()));
        self
    }

    /// Sets a colour (sRGB) as background.
    #[must_use]
    pub fn background(mut self, color: [u8; 3]) -> Self {
        self.0.background = Some(Tensor::pack(&[3], &color));
        self
    }

    /// Sets an image as background (sRGB), shape [height, width, 3].
    #[must_use]
    pub fn background_image(mut self, colors: &[u8]) -> Self {
        let shape = [self.0.height as usize, self.0.width as usize, 3];
        self.0.background = Some(Tensor::pack(&shape, colors));
        self
    }

    /// Sets the name in errors.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.0.name = name.into();
        self
    }
}

impl Prop {
    /// A grey thing at the origin.
    pub fn new(shape: Shape) -> Self {
        let shape = match shape.0 {
            collider::Shape::Sphere(sphere) => prop::Shape::Sphere(sphere),
            collider::Shape::Capsule(capsule) => prop::Shape::Capsule(capsule),
            collider::Shape::Cuboid(cuboid) => prop::Shape::Cuboid(cuboid),
            collider::Shape::ConvexMesh(mesh) => prop::Shape::ConvexMesh(mesh),
        };
        Self(v1::Prop { shape: Some(shape), ..v1::Prop::default() })
    }

    /// Sets its pose in the world.
    #[must_use]
    pub fn at(mut self, pose: WirePose) -> Self {
        self.0.pose = Some(Tensor::pack(&[7], &pose));
        self
    }

    /// Sets a pose for each slot, in their order.
    #[must_use]
    pub fn poses(mut self, poses: &[WirePose]) -> Self {
        self.0.pose = Some(Tensor::pack(&[poses.len(), 7], poses.as_flattened()));
        self
    }

    /// Sets its colour (sRGB).
    #[must_use]
    pub fn color(mut self, color: [u8; 3]) -> Self {
        self.0.color = Some(Tensor::pack(&[3], &color));
        self
    }
}

impl Rendering {
    /// Pictures by these cameras.
    pub fn by(cameras: impl IntoIterator<Item = PictureCamera>) -> Self {
        let cameras = cameras.into_iter().map(|camera| camera.0).collect();
        Self(RenderSessionRequest { cameras, ..RenderSessionRequest::default() })
    }

    /// Shows the surface of the twin, also if it has Gaussians.
    #[must_use]
    pub fn surface(mut self) -> Self {
        self.0.set_look(Look::Surface);
        self
    }

    /// Shows the Gaussians of the twin; refused if it has none.
    #[must_use]
    pub fn gaussians(mut self) -> Self {
        self.0.set_look(Look::Gaussians);
        self
    }

    /// Adds a thing.
    #[must_use]
    pub fn prop(mut self, prop: Prop) -> Self {
        self.0.props.push(prop.0);
        self
    }

    /// Sets the direction from which the light comes, of any length.
    #[must_use]
    pub fn light_from(mut self, direction: Point) -> Self {
        self.light().direction = Some(Tensor::pack(&[3], &direction));
        self
    }

    /// Sets the share of the even light, 0..1.
    #[must_use]
    pub fn ambient(mut self, share: f32) -> Self {
        self.light().ambient = Some(Tensor::pack(&[1], &[share]));
        self
    }

    /// Sets the factor of all light, 0..4.
    #[must_use]
    pub fn brightness(mut self, factor: f32) -> Self {
        self.light().brightness = Some(Tensor::pack(&[1], &[factor]));
        self
    }

    /// Returns depths as well.
    #[must_use]
    pub fn depths(mut self) -> Self {
        self.0.depths = true;
        self
    }

    /// Returns labels as well.
    #[must_use]
    pub fn labels(mut self) -> Self {
        self.0.labels = true;
        self
    }

    fn light(&mut self) -> &mut v1::Light {
        self.0.light.get_or_insert_default()
    }

    pub(super) fn into_request(self, name: SessionId, slots: &[u32]) -> RenderSessionRequest {
        RenderSessionRequest { name: name.to_string(), slots: slots.to_vec(), ..self.0 }
    }
}

/// The pictures of a reply, one set for each camera.
pub(super) fn read(reply: RenderedSession) -> Result<Vec<Pictures>, Error> {
    let of_camera = |pictures: v1::rendered_session::Pictures| {
        let (shape, colors) =
            pictures.colors.unwrap_or_default().unpack::<u8>("colors").map_err(Error::malformed)?;
        let depths = pictures
            .depths
            .map(|tensor| tensor.unpack::<f32>("depths"))
            .transpose()
            .map_err(Error::malformed)?;
        let labels = pictures
            .labels
            .map(|tensor| tensor.unpack::<u8>("labels"))
            .transpose()
            .map_err(Error::malformed)?;
        Ok(Pictures {
            shape: [0, 1, 2].map(|k| shape.get(k).copied().unwrap_or_default()),
            colors,
            depths: depths.map(|(_, values)| values).unwrap_or_default(),
            labels: labels.map(|(_, values)| values).unwrap_or_default(),
        })
    };
    reply.cameras.into_iter().map(of_camera).collect()
}
