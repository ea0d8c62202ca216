//! USD as text, alone or in a package: points of the twin, and springs as curves or a coloured surface; motion
//! as time samples.
//!
//! Metres and z up are said in the file. One time code is a frame of the twin's frame rate, so that
//! programs play it at its speed. Springs are written at rest only: they would double the size of a
//! motion that its points already have.

use std::{
    fmt::Write as _,
    io::{self, Seek, Write},
};

use bendtwin_core::{Point, geometry::bounds};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use crate::{Error, PointSet, Scene, scene::linear};

/// Width of a drawn point and of a spring [m].
const POINT_M: f32 = 0.004;
const SPRING_M: f32 = 0.001;

/// Writes a package: a ZIP archive with the text as its only file, stored, whose content begins at a multiple of 64
/// bytes.
pub(crate) fn write_package(scene: &Scene<'_>, out: &mut (impl Write + Seek)) -> Result<(), Error> {
    let mut archive = ZipWriter::new(out);
    let stored = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .with_alignment(64);
    archive.start_file("twin.usda", stored)?;
    write(scene, &mut archive)?;
    archive.finish()?;
    Ok(())
}

/// Writes the file.
pub(crate) fn write(scene: &Scene<'_>, out: &mut impl Write) -> Result<(), Error> {
    let fps = scene.twin().timing.fps;
    let codes: Vec<f64> = scene.times_s().iter().map(|t| (t * fps * 1e6).round() / 1e6).collect();
    let ends = [codes[0], codes[codes.len() - 1]];
    writeln!(out, "#usda 1.0\n(")?;
    writeln!(out, "    customLayerData = {{ string creator = {:?} }}", bendtwin_core::BUILD)?;
    writeln!(out, "    defaultPrim = \"Twin\"\n    metersPerUnit = 1\n    upAxis = \"Z\"")?;
    if scene.motion().is_some() {
        writeln!(out, "    startTimeCode = {}\n    endTimeCode = {}", ends[0], ends[1])?;
    }
    writeln!(out, "    timeCodesPerSecond = {fps}\n    framesPerSecond = {fps}\n)\n")?;
    writeln!(out, "def Xform \"Twin\" (kind = \"component\")\n{{")?;
    writeln!(out, "    custom string bendtwin:name = {}", quoted(scene.name()))?;
    if scene.triangles().is_empty() {
        points(scene, &codes, out)?;
    } else {
        mesh(scene, &codes, out)?;
    }
    if scene.motion().is_none() && !scene.lines().is_empty() {
        springs(scene, out)?;
    }
    if !scene.controls_at(0).is_empty() {
        writeln!(out, "\n    def Points \"Controls\"\n    {{")?;
        moving(scene, &codes, out, |frame| scene.controls_at(frame).into())?;
        constant_width(out, 2.0 * POINT_M)?;
        writeln!(out, "    }}")?;
    }
    writeln!(out, "}}")?;
    Ok(())
}

fn points(scene: &Scene<'_>, codes: &[f64], out: &mut impl Write) -> Result<(), Error> {
    let is_nodes = matches!(scene.points(), PointSet::Nodes);
    writeln!(out, "\n    def Points \"{}\"\n    {{", if is_nodes { "Nodes" } else { "Skin" })?;
    moving(scene, codes, out, |frame| scene.points_at(frame))?;
    constant_width(out, POINT_M)?;
    if is_nodes {
        let graph = &scene.twin().graph;
        let kinds: Vec<u8> = graph.kinds.iter().map(|k| *k as u8).collect();
        primvar(out, "int[]", "kind", "vertex", &list(&kinds))?;
        primvar(out, "int[]", "object", "vertex", &list(&graph.object_ids))?;
        primvar(out, "float[]", "mass", "vertex", &list(&graph.masses))?;
    }
    writeln!(out, "    }}")?;
    Ok(())
}

fn mesh(scene: &Scene<'_>, codes: &[f64], out: &mut impl Write) -> Result<(), Error> {
    writeln!(out, "\n    def Mesh \"Surface\"\n    {{")?;
    moving(scene, codes, out, |frame| scene.points_at(frame))?;
    let triangles = scene.triangles();
    writeln!(out, "        int[] faceVertexCounts = {}", list(&vec![3; triangles.len()]))?;
    writeln!(out, "        int[] faceVertexIndices = {}", list(triangles.as_flattened()))?;
    if !scene.colors().is_empty() {
        let light = |color: &[u8; 3]| linear(*color).map(|x| x as f32);
        let colors: Vec<Point> = scene.colors().iter().map(light).collect();
        primvar(out, "color3f[]", "displayColor", "vertex", &tuples(&colors))?;
    }
    writeln!(out, "        uniform token subdivisionScheme = \"none\"\n    }}")?;
    Ok(())
}

/// Springs between nodes at rest, a curve of two points each.
fn springs(scene: &Scene<'_>, out: &mut impl Write) -> Result<(), Error> {
    let (graph, params) = (&scene.twin().graph, &scene.twin().params);
    let n = graph.node_count();
    let inner: Vec<usize> =
        (0..graph.springs.len()).filter(|s| (graph.springs[*s][1] as usize) < n).collect();
    let of = |values: &[f32]| -> Vec<f32> { inner.iter().map(|s| values[*s]).collect() };
    let ends: Vec<Point> =
        scene.lines().as_flattened().iter().map(|i| graph.rest_positions[*i as usize]).collect();
    writeln!(out, "\n    def BasisCurves \"Springs\"\n    {{")?;
    writeln!(out, "        uniform token type = \"linear\"")?;
    writeln!(out, "        int[] curveVertexCounts = {}", list(&vec![2; inner.len()]))?;
    writeln!(out, "        point3f[] points = {}", tuples(&ends))?;
    extent(out, &ends)?;
    constant_width(out, SPRING_M)?;
    primvar(out, "float[]", "restLength", "uniform", &list(&of(&params.rest_lengths_m)))?;
    primvar(out, "float[]", "stiffness", "uniform", &list(&of(&params.spring_stiffness)))?;
    primvar(out, "float[]", "dashpot", "uniform", &list(&of(&params.spring_dashpot)))?;
    writeln!(out, "    }}")?;
    Ok(())
}

/// `points` and their `extent`, once at rest or with a time sample for each frame.
fn moving<'a>(
    scene: &Scene<'a>,
    codes: &[f64],
    out: &mut impl Write,
    at: impl Fn(usize) -> std::borrow::Cow<'a, [Point]>,
) -> Result<(), Error> {
    if scene.motion().is_none() {
        writeln!(out, "        point3f[] points = {}", tuples(&at(0)))?;
        return Ok(extent(out, &at(0))?);
    }
    writeln!(out, "        point3f[] points.timeSamples = {{")?;
    for (frame, code) in codes.iter().enumerate() {
        writeln!(out, "            {code}: {},", tuples(&at(frame)))?;
    }
    writeln!(out, "        }}\n        float3[] extent.timeSamples = {{")?;
    for (frame, code) in codes.iter().enumerate() {
        writeln!(out, "            {code}: {},", tuples(&bounds(&at(frame)).unwrap_or_default()))?;
    }
    writeln!(out, "        }}")?;
    Ok(())
}

fn extent(out: &mut impl Write, points: &[Point]) -> io::Result<()> {
    writeln!(out, "        float3[] extent = {}", tuples(&bounds(points).unwrap_or_default()))
}

fn constant_width(out: &mut impl Write, width_m: f32) -> io::Result<()> {
    writeln!(out, "        float[] widths = [{width_m}] (interpolation = \"constant\")")
}

fn primvar(
    out: &mut impl Write,
    kind: &str,
    name: &str,
    interpolation: &str,
    values: &str,
) -> io::Result<()> {
    writeln!(out, "        {kind} primvars:{name} = {values} (interpolation = \"{interpolation}\")")
}

fn list<T: std::fmt::Display>(values: &[T]) -> String {
    let mut text = String::from("[");
    for (i, value) in values.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(text, "{}{value}", if i > 0 { ", " } else { "" });
    }
    text + "]"
}

fn tuples(points: &[Point]) -> String {
    let mut text = String::from("[");
    for (i, [x, y, z]) in points.iter().enumerate() {
        let _ = write!(text, "{}({x}, {y}, {z})", if i > 0 { ", " } else { "" });
    }
    text + "]"
}

/// A string as USD writes it; what could end it or the line is left out.
fn quoted(text: &str) -> String {
    let plain: String =
        text.chars().filter(|c| !c.is_control() && !matches!(c, '"' | '\\')).collect();
    format!("\"{plain}\"")
}

#[cfg(test)]
mod tests;
