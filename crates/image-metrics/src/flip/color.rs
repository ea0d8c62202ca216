//! Colour spaces of FLIP.
//!
//! sRGB becomes linear, then CIE XYZ by the primaries of BT.709, then either the opponent space in
//! which contrast sensitivity is known, or CIE L*a*b* with the Hunt effect: colours of dark pixels
//! differ less.

use crate::planes::Plane;

/// Linear RGB to XYZ, BT.709 primaries, D65.
const TO_XYZ: [[f64; 3]; 3] = [
    [0.412_390_799_265_96, 0.357_584_339_383_88, 0.180_480_788_401_83],
    [0.212_639_005_871_51, 0.715_168_678_767_76, 0.072_192_315_360_73],
    [0.019_330_818_715_59, 0.119_194_779_794_63, 0.950_532_152_249_66],
];
/// Inverse of the matrix above.
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_969_941_904_52, -1.537_383_177_570_09, -0.498_610_760_293_00],
    [-0.969_243_636_280_88, 1.875_967_501_507_72, 0.041_555_057_407_18],
    [0.055_630_079_696_99, -0.203_976_958_888_98, 1.056_971_514_242_88],
];

/// Colour in CIE L*a*b*, a and b scaled by the Hunt effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lab {
    pub(super) lightness: f32,
    pub(super) a: f32,
    pub(super) b: f32,
}

/// An image in linearised L*a*b*: with X, Y, Z relative to white,
/// Y' = 116 Y - 16, Cx = 500 (X - Y), Cz = 200 (Y - Z).
pub(super) struct Opponent {
    pub(super) achromatic: Plane,
    pub(super) red_green: Plane,
    pub(super) blue_yellow: Plane,
}

impl Opponent {
    /// Image of the three channels of sRGB.
    pub(super) fn of(srgb: &[Plane; 3]) -> Self {
        let (width, height) = (srgb[0].width, srgb[0].height);
        let colors: Vec<[f64; 3]> = (0..width * height)
            .map(|p| {
                let [x, y, z] = relative_xyz(
                    srgb.each_ref().map(|plane| linear(f64::from(plane.values[p].clamp(0.0, 1.0)))),
                );
                [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
            })
            .collect();
        let plane = |c: usize| Plane::from_fn(width, height, |p| colors[p][c] as f32);
        Self { achromatic: plane(0), red_green: plane(1), blue_yellow: plane(2) }
    }

    /// The colours that can be displayed nearest to these.
    pub(super) fn colors(&self) -> Vec<Lab> {
        let pixel = |p: usize| {
            let y = (f64::from(self.achromatic.values[p]) + 16.0) / 116.0;
            let x = y + f64::from(self.red_green.values[p]) / 500.0;
            let z = y - f64::from(self.blue_yellow.values[p]) / 200.0;
            let white = white();
            let rgb = product(&FROM_XYZ, [x * white[0], y * white[1], z * white[2]]);
            hunt_lab_of_linear(rgb.map(|v| v.clamp(0.0, 1.0)))
        };
        (0..self.achromatic.values.len()).map(pixel).collect()
    }
}

/// L*a*b* of linear RGB, with a and b times 0.01 L*.
pub(super) fn hunt_lab_of_linear(rgb: [f64; 3]) -> Lab {
    let [x, y, z] = relative_xyz(rgb).map(|t| {
        let delta = 6.0 / 29.0;
        if t > delta * delta * delta { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 }
    });
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    Lab {
        lightness: lightness as f32,
        a: (hunt * 500.0 * (x - y)) as f32,
        b: (hunt * 200.0 * (y - z)) as f32,
    }
}

/// Linear value of one of sRGB, both 0 to 1 (IEC 61966-2-1).
pub fn linear(value: f64) -> f64 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// X, Y, Z divided by those of white.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let (xyz, white) = (product(&TO_XYZ, rgb), white());
    std::array::from_fn(|i| xyz[i] / white[i])
}

fn white() -> [f64; 3] {
    product(&TO_XYZ, [1.0; 3])
}

fn product(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}
