//! Light on surfaces, and colours as light.

use std::sync::LazyLock;

use bendtwin_core::{
    Point,
    geometry::{Vector, add, cross, dot, sub, unit, wide},
};

/// A distant light and an even one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector towards the distant light, in the world.
    pub direction: [f32; 3],
    /// Share of the even light, 0..1.
    pub ambient: f32,
    /// Factor of all light.
    pub brightness: f32,
}

impl Light {
    /// Light on a surface with a unit normal: brightness (ambient + (1 - ambient) max(0, n · direction)).
    pub(crate) fn on(&self, normal: [f32; 3]) -> f32 {
        let facing = dot(normal, self.direction).max(0.0);
        self.brightness * (self.ambient + (1.0 - self.ambient) * facing)
    }
}

/// Steps of [`encoded`]: so fine that encoding a decoded byte gives the same byte.
const STEPS: usize = 1 << 14;

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let value = byte as f64 / 255.0;
        let light =
            if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
        light as f32
    })
});

static ENCODED: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let encoded = |light: f64| match light {
        x if x <= 0.003_130_8 => 12.92 * x,
        x => 1.055 * x.powf(1.0 / 2.4) - 0.055,
    };
    let byte = |k: usize| (255.0 * encoded(k as f64 / (STEPS - 1) as f64)).round() as u8;
    (0..STEPS).map(byte).collect()
});

/// The light of sRGB bytes, each channel 0..1.
pub(crate) fn linear(color: [u8; 3]) -> [f32; 3] {
    color.map(|byte| LINEAR[usize::from(byte)])
}

/// The sRGB byte of a light.
pub(crate) fn encoded(light: f32) -> u8 {
    // The conversion makes 0 of what is not a number.
    ENCODED[(light.clamp(0.0, 1.0) * (STEPS - 1) as f32 + 0.5) as usize]
}

/// Unit normals of vertices, the mean of their triangles by area, shape [V, 3].
pub(crate) fn normals(positions: &[Point], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut normals = vec![[0.0; 3]; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| wide(positions[i as usize]));
        let area = cross(sub(b, a), sub(c, a));
        for i in triangle {
            normals[*i as usize] = add(normals[*i as usize], area);
        }
    }
    let narrow = |normal: Vector| unit(normal).unwrap_or([0.0, 0.0, 1.0]).map(|x| x as f32);
    normals.into_iter().map(narrow).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_being_light() {
        for byte in 0..=255 {
            assert_eq!(encoded(linear([byte; 3])[0]), byte);
        }
        assert_eq!([encoded(f32::NAN), encoded(-1.0), encoded(7.0)], [0, 0, 255]);
    }

    #[test]
    fn light_falls_with_the_angle_down_to_the_even_share() {
        let light = Light { direction: [0.0, 0.0, 1.0], ambient: 0.25, brightness: 2.0 };
        let on = [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.0, -1.0]].map(|n| light.on(n));
        assert_eq!(on, [2.0, 2.0 * (0.25 + 0.75 * 0.8), 0.5]);
    }
}
