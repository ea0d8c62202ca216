//! Constants of the rendering that every implementation shares: kernels of other devices are
//! compiled with them.

/// Variance that every projected Gaussian gains, for the width of a pixel [px²].
pub const BLUR_PX2: f32 = 0.3;
/// Largest opacity of a Gaussian at a pixel: behind it something is always left.
pub const MOST_ALPHA: f32 = 0.99;
/// Opacity at a pixel below which a Gaussian is left out.
pub const LEAST_ALPHA: f32 = 1.0 / 255.0;
/// Transmittance below which a pixel takes no more Gaussians.
pub const LEAST_TRANSMITTANCE: f32 = 1e-4;
/// Depth below which Gaussians are left out [m].
pub const NEAR_M: f32 = 0.05;
/// Columns and rows of a tile [px].
pub const TILE_PX: u32 = 16;
/// Largest tangent of the angle from the optical axis at which the projection is made linear.
///
/// The linear projection of a Gaussian far beside the image is far too wide. Trainers limit the
/// tangent at 1.3 times that of the field of view. A crop does not know the field of view of its
/// image, and must give the same pixels; so the limit is the same for every camera, 63 degrees.
pub const MOST_TANGENT: f32 = 2.0;

/// Most columns or rows of an image [px].
pub const MOST_SIDE_PX: u32 = 16_384;
/// Most pixels of an image.
pub const MOST_PIXELS: usize = 1 << 24;
/// Most Gaussians of a set.
pub const MOST_GAUSSIANS: usize = 1 << 22;
/// Most pairs of a Gaussian and a tile that it touches, over an image.
pub const MOST_INTERSECTIONS: usize = 1 << 24;
/// Largest absolute value of a position, a scale [m], a colour, or a focal length [px].
pub const MOST_VALUE: f32 = 1e6;
