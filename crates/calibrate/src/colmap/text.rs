//! The text form of a model: a line for each camera and point, two for each image; lines with `#` are
//! comments.

use super::model::{ModelCamera, ModelImage, ModelPoint, kind_named, parameter_count};

fn text(bytes: &[u8]) -> Result<&str, String> {
    std::str::from_utf8(bytes).map_err(|_| "it is no text".to_owned())
}

fn number<T: std::str::FromStr>(part: Option<&str>, line: usize) -> Result<T, String> {
    part.and_then(|part| part.parse().ok()).ok_or_else(|| format!("line {line} lacks a number"))
}

fn finite<const N: usize>(
    parts: &mut dyn Iterator<Item = &str>,
    line: usize,
) -> Result<[f64; N], String> {
    let mut numbers = [0.0_f64; N];
    for slot in &mut numbers {
        *slot = number(parts.next(), line)?;
        if !slot.is_finite() {
            return Err(format!("line {line} has a number that is not finite"));
        }
    }
    Ok(numbers)
}

/// Lines that are no comments, numbered from 1.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines()
        .enumerate()
        .map(|(n, line)| (n + 1, line))
        .filter(|(_, line)| !line.starts_with('#'))
}

pub(super) fn cameras(bytes: &[u8]) -> Result<Vec<ModelCamera>, String> {
    let mut cameras = Vec::new();
    for (line, content) in lines(text(bytes)?).filter(|(_, line)| !line.trim().is_empty()) {
        let mut parts = content.split_ascii_whitespace();
        let id = number(parts.next(), line)?;
        let kind = kind_named(parts.next().unwrap_or_default())?;
        let size = [number(parts.next(), line)?, number(parts.next(), line)?];
        let mut parameters = Vec::new();
        for _ in 0..parameter_count(kind)? {
            parameters.extend(finite::<1>(&mut parts, line)?);
        }
        cameras.push(ModelCamera { id, kind, size, parameters });
    }
    Ok(cameras)
}

pub(super) fn images(bytes: &[u8]) -> Result<Vec<ModelImage>, String> {
    let mut images = Vec::new();
    let mut lines = lines(text(bytes)?);
    while let Some((line, content)) = lines.next() {
        if content.trim().is_empty() {
            continue;
        }
        let mut parts = content.split_ascii_whitespace();
        number::<u64>(parts.next(), line)?;
        let (rotation, translation) = (finite(&mut parts, line)?, finite(&mut parts, line)?);
        let camera = number(parts.next(), line)?;
        let name = parts.collect::<Vec<_>>().join(" ");
        // The line of points may be empty.
        let seen = lines.next().map_or("", |(_, content)| content);
        let mut points = Vec::new();
        for id in seen.split_ascii_whitespace().skip(2).step_by(3) {
            let id: i64 = number(Some(id), line + 1)?;
            points.extend(u64::try_from(id));
        }
        images.push(ModelImage { rotation, translation, camera, name, points });
    }
    Ok(images)
}

pub(super) fn points(bytes: &[u8]) -> Result<Vec<ModelPoint>, String> {
    let mut points = Vec::new();
    for (line, content) in lines(text(bytes)?).filter(|(_, line)| !line.trim().is_empty()) {
        let mut parts = content.split_ascii_whitespace();
        let id = number(parts.next(), line)?;
        points.push(ModelPoint { id, at: finite(&mut parts, line)? });
    }
    points.sort_by_key(|point| point.id);
    Ok(points)
}
