//! Wavefront OBJ: one state as vertices, with springs as lines or a surface as faces.

use std::io::Write;

use crate::{Error, Scene};

/// Writes the file: metres, z up. Colours follow the coordinates of a vertex, as fractions.
pub(crate) fn write(scene: &Scene<'_>, out: &mut impl Write) -> Result<(), Error> {
    writeln!(out, "# bendtwin: metres, z up")?;
    let name: String = scene.name().chars().filter(|c| !c.is_control()).collect();
    writeln!(out, "o {name}")?;
    let colors = scene.colors();
    for (i, [x, y, z]) in scene.points_at(0).iter().enumerate() {
        match colors.get(i).map(|color| color.map(|c| f32::from(c) / 255.0)) {
            Some([r, g, b]) => writeln!(out, "v {x} {y} {z} {r:.4} {g:.4} {b:.4}")?,
            None => writeln!(out, "v {x} {y} {z}")?,
        }
    }
    // Numbers begin at 1.
    for [a, b] in scene.lines() {
        writeln!(out, "l {} {}", a + 1, b + 1)?;
    }
    for [a, b, c] in scene.triangles() {
        writeln!(out, "f {} {} {}", a + 1, b + 1, c + 1)?;
    }
    Ok(())
}
