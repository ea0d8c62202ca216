//! Projection of a Gaussian, and its adjoint.
//!
//! With the tangents t = (x, y) / z of its mean in the camera's frame, clamped, the linear
//! projection has the rows T_1 = f_x / z (W_1 - t_x W_3) and T_2 likewise; W is the camera's
//! rotation. M = T R S, with rows m_1, m_2, maps a unit ball to the projected ellipse, whose
//! covariance is M M^T + blur. Its determinant before the blur is |m_1 × m_2|², exact also for
//! needles and plates, where differences of products would be rounding.

use bendtwin_core::geometry::{cross, dot, scaled};

use crate::{
    Camera, Gaussians,
    constants::{BLUR_PX2, LEAST_ALPHA, MOST_TANGENT, NEAR_M},
};

/// Margin of the squared distance at which a Gaussian ends.
const REACH_MARGIN: f32 = 1e-4;

/// A 3 x 3 matrix, row-major.
type Matrix = [[f32; 3]; 3];

/// A projected Gaussian, as pixels need it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Splat {
    /// Centre: column and row [px].
    pub(super) center: [f32; 2],
    /// Inverse covariance: A, B, C of A dx² + 2 B dx dy + C dy² [1/px²].
    pub(super) conic: [f32; 3],
    /// Opacity after compensation.
    pub(super) opacity: f32,
    /// Half the height of the ellipse of all with an opacity of [`LEAST_ALPHA`] [px].
    pub(super) reach: f32,
    /// Distance of the point of that ellipse with the largest column from the centre, in rows [px].
    pub(super) lean: f32,
    /// Columns by which the middle of the ellipse moves from a row to the next.
    pub(super) slope: f32,
    /// Half its width in the row of its centre [px].
    pub(super) half_width: f32,
    /// Colour.
    pub(super) color: [f32; 3],
    /// Depth [m].
    pub(super) depth_m: f32,
}

/// d loss / d what pixels need of a Gaussian.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SplatBar {
    pub(super) center: [f32; 2],
    pub(super) conic: [f32; 3],
    pub(super) opacity: f32,
    pub(super) color: [f32; 3],
    pub(super) depth_m: f32,
}

/// d loss / d parameters of a Gaussian.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GaussianBar {
    pub(super) mean_m: [f32; 3],
    pub(super) scale_m: [f32; 3],
    pub(super) rotation: [f32; 4],
    pub(super) opacity: f32,
}

/// Intermediate values of a projection.
struct Projection {
    /// Mean in the camera's frame [m].
    mean: [f32; 3],
    /// Tangents, and whether each is unclamped.
    tangents: [f32; 2],
    is_free: [bool; 2],
    /// Unit quaternion, its matrix R, and the length before.
    unit: [f32; 4],
    rotation: Matrix,
    length: f32,
    /// W_1 - t_x W_3 and W_2 - t_y W_3.
    rows: [[f32; 3]; 2],
    /// T_1 R and T_2 R.
    turned: [[f32; 3]; 2],
    /// m_1 and m_2 [px].
    axes: [[f32; 3]; 2],
    /// m_1 × m_2 and its length [px²].
    normal: [f32; 3],
    area: f32,
    /// Covariance with the blur: xx, xy, yy [px²].
    covariance: [f32; 3],
    /// Determinant of the covariance [px⁴].
    determinant: f32,
}

impl Projection {
    /// `None` in front of the near plane.
    #[inline(always)]
    fn of(gaussians: &Gaussians, index: usize, camera: &Camera) -> Option<Self> {
        let w = &camera.world_to_camera;
        let mean = gaussians.means_m[index];
        let mean = [0, 1, 2].map(|k| dot([w[k][0], w[k][1], w[k][2]], mean) + w[k][3]);
        if mean[2] < NEAR_M {
            return None;
        }
        let ratios = [mean[0] / mean[2], mean[1] / mean[2]];
        let tangents = ratios.map(|t| t.clamp(-MOST_TANGENT, MOST_TANGENT));
        let is_free = [0, 1].map(|k| ratios[k] == tangents[k]);
        let q = gaussians.rotations[index];
        let length = q.iter().map(|x| x * x).sum::<f32>().sqrt();
        let unit = q.map(|x| x / length);
        let rotation = matrix(unit);
        let focal = [camera.fx, camera.fy];
        let rows = [0, 1].map(|r| [0, 1, 2].map(|k| w[r][k] - tangents[r] * w[2][k]));
        let turned = [0, 1].map(|r| {
            let row = scaled(rows[r], focal[r] / mean[2]);
            [0, 1, 2].map(|k| dot(row, [rotation[0][k], rotation[1][k], rotation[2][k]]))
        });
        let scales = gaussians.scales_m[index];
        let axes = turned.map(|g| [g[0] * scales[0], g[1] * scales[1], g[2] * scales[2]]);
        let normal = cross(axes[0], axes[1]);
        let area = dot(normal, normal).sqrt();
        let sharp = [dot(axes[0], axes[0]), dot(axes[0], axes[1]), dot(axes[1], axes[1])];
        let determinant = area * area + BLUR_PX2 * (sharp[0] + sharp[2]) + BLUR_PX2 * BLUR_PX2;
        let covariance = [sharp[0] + BLUR_PX2, sharp[1], sharp[2] + BLUR_PX2];
        Some(Self {
            mean,
            tangents,
            is_free,
            unit,
            rotation,
            length,
            rows,
            turned,
            axes,
            normal,
            area,
            covariance,
            determinant,
        })
    }

    /// Share of the opacity that is left where the blur widens the Gaussian: its area before over
    /// that after.
    fn compensation(&self) -> f32 {
        self.area / self.determinant.sqrt()
    }

    #[inline(always)]
    fn conic(&self) -> [f32; 3] {
        let [xx, xy, yy] = self.covariance;
        [yy / self.determinant, -xy / self.determinant, xx / self.determinant]
    }
}

/// A Gaussian as pixels need it; `None` where no pixel can see it: in front of the near plane, too
/// faint, or so large that numbers overflow.
#[inline(always)]
pub(super) fn project(gaussians: &Gaussians, index: usize, camera: &Camera) -> Option<Splat> {
    let p = Projection::of(gaussians, index, camera)?;
    let opacity = gaussians.opacities[index] * p.compensation();
    if !(opacity >= LEAST_ALPHA && p.determinant.is_finite()) {
        return None;
    }
    let [xx, xy, yy] = p.covariance;
    // alpha falls to its least where d^T S^-1 d = 2 ln(o / least). A little more, so that rounding
    // leaves the decision to the pixels.
    let square = 2.0 * (opacity / LEAST_ALPHA).ln().max(0.0) + REACH_MARGIN;
    Some(Splat {
        center: [
            camera.fx * p.mean[0] / p.mean[2] + camera.cx,
            camera.fy * p.mean[1] / p.mean[2] + camera.cy,
        ],
        conic: p.conic(),
        opacity,
        reach: (square * yy).sqrt(),
        lean: xy * (square / xx).sqrt(),
        slope: xy / yy,
        half_width: (square * p.determinant / yy).sqrt(),
        color: gaussians.colors[index],
        depth_m: p.mean[2],
    })
}

/// Adjoint of [`project`].
pub(super) fn project_adjoint(
    gaussians: &Gaussians,
    index: usize,
    camera: &Camera,
    bar: &SplatBar,
) -> GaussianBar {
    let Some(p) = Projection::of(gaussians, index, camera) else { return GaussianBar::default() };
    let scales = gaussians.scales_m[index];
    let compensation = p.compensation();
    let compensation_bar = bar.opacity * gaussians.opacities[index];

    // Covariance, by the derivative of an inverse: -K Ḡ K.
    let [a, b, c] = p.conic();
    let [ga, gb, gc] = [bar.conic[0], 0.5 * bar.conic[1], bar.conic[2]];
    let left = [[a * ga + b * gb, a * gb + b * gc], [b * ga + c * gb, b * gb + c * gc]];
    let mut xx_bar = -(left[0][0] * a + left[0][1] * b);
    let xy_bar = -2.0 * (left[0][0] * b + left[0][1] * c);
    let mut yy_bar = -(left[1][0] * b + left[1][1] * c);

    // Compensation area / √D, with D = area² + blur (xx + yy) + blur² before the blur.
    let root = p.determinant.sqrt();
    let area_bar = compensation_bar * (1.0 - compensation * compensation) / root;
    let spread = -0.5 * compensation_bar * compensation / p.determinant * BLUR_PX2;
    xx_bar += spread;
    yy_bar += spread;

    let normal = if p.area > 0.0 { scaled(p.normal, area_bar / p.area) } else { [0.0; 3] };
    let [m1, m2] = p.axes;
    let [by_m2, by_m1] = [cross(m2, normal), cross(normal, m1)];
    let axes_bar = [
        [0, 1, 2].map(|k| 2.0 * xx_bar * m1[k] + xy_bar * m2[k] + by_m2[k]),
        [0, 1, 2].map(|k| 2.0 * yy_bar * m2[k] + xy_bar * m1[k] + by_m1[k]),
    ];
    let scale_m =
        [0, 1, 2].map(|k| axes_bar[0][k] * p.turned[0][k] + axes_bar[1][k] * p.turned[1][k]);
    let turned_bar = axes_bar.map(|m| [0, 1, 2].map(|k| m[k] * scales[k]));

    let [x, y, z] = p.mean;
    let focal = [camera.fx, camera.fy];
    let w = &camera.world_to_camera;
    let mut rotation_bar: Matrix = [[0.0; 3]; 3];
    let mut mean_bar = [0.0, 0.0, bar.depth_m];
    for r in 0..2 {
        let f = focal[r] / z;
        let row_bar = [0, 1, 2].map(|i| dot(p.rotation[i], turned_bar[r]));
        for (of_row, x) in rotation_bar.iter_mut().zip(p.rows[r]) {
            (0..3).for_each(|k| of_row[k] += f * x * turned_bar[r][k]);
        }
        mean_bar[2] -= dot(row_bar, p.rows[r]) * f / z;
        let tangent_bar = -f * dot(row_bar, [w[2][0], w[2][1], w[2][2]]);
        if p.is_free[r] {
            mean_bar[r] += tangent_bar / z;
            mean_bar[2] -= tangent_bar * p.tangents[r] / z;
        }
        mean_bar[r] += bar.center[r] * f;
        mean_bar[2] -= bar.center[r] * f * [x, y][r] / z;
    }
    GaussianBar {
        mean_m: [0, 1, 2].map(|k| (0..3).map(|r| w[r][k] * mean_bar[r]).sum()),
        scale_m,
        rotation: quaternion_bar(&p, &rotation_bar),
        opacity: bar.opacity * compensation,
    }
}

/// Matrix of a unit quaternion x, y, z, w.
#[inline(always)]
fn matrix([x, y, z, w]: [f32; 4]) -> Matrix {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Adjoint of [`matrix`], and of the division of the quaternion by its length.
fn quaternion_bar(p: &Projection, bar: &Matrix) -> [f32; 4] {
    let [x, y, z, w] = p.unit;
    let both = |a: usize, b: usize| bar[a][b] + bar[b][a];
    let turn = [bar[2][1] - bar[1][2], bar[0][2] - bar[2][0], bar[1][0] - bar[0][1]];
    let [xx, yy, zz] = [bar[0][0], bar[1][1], bar[2][2]];
    let unit_bar = [
        2.0 * (y * both(0, 1) + z * both(0, 2) + w * turn[0] - 2.0 * x * (yy + zz)),
        2.0 * (x * both(0, 1) + z * both(1, 2) + w * turn[1] - 2.0 * y * (xx + zz)),
        2.0 * (x * both(0, 2) + y * both(1, 2) + w * turn[2] - 2.0 * z * (xx + yy)),
        2.0 * (x * turn[0] + y * turn[1] + z * turn[2]),
    ];
    let along: f32 = (0..4).map(|k| unit_bar[k] * p.unit[k]).sum();
    [0, 1, 2, 3].map(|k| (unit_bar[k] - p.unit[k] * along) / p.length)
}

impl SplatBar {
    /// Adds another tile's share.
    pub(super) fn add(&mut self, other: &Self) {
        (0..2).for_each(|k| self.center[k] += other.center[k]);
        (0..3).for_each(|k| self.conic[k] += other.conic[k]);
        (0..3).for_each(|k| self.color[k] += other.color[k]);
        self.opacity += other.opacity;
        self.depth_m += other.depth_m;
    }
}
