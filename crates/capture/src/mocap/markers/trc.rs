//! TRC files: three lines of settings, two lines that name the columns, then a line for each frame.
//!
//! <https://opensimconfluence.atlassian.net/wiki/spaces/OpenSim/pages/53089972>

use std::collections::BTreeMap;

use super::{Mark, Markers, charge_cells, damaged, reserve};
use crate::{Error, Limits, limits::Budget};

pub(super) fn read(
    at: &str,
    text: &str,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<Markers, Error> {
    let mut lines = text.lines();
    let mut line = || lines.next().unwrap_or_default().trim_end_matches('\r');
    let (_, keys, values, names) = (line(), line(), line(), line());
    charge_cells(at, keys, b'\t', budget)?;
    charge_cells(at, names, b'\t', budget)?;
    let settings: BTreeMap<String, &str> = keys
        .split('\t')
        .map(|key| key.trim().to_ascii_lowercase())
        .zip(values.split('\t').map(str::trim))
        .collect();
    if !names.trim_start().to_ascii_lowercase().starts_with("frame#") {
        return Err(damaged(at, "its fourth line does not begin with `Frame#`"));
    }
    // A marker's name stands above the first of its three columns.
    let columns: Vec<(usize, Mark)> = names
        .split('\t')
        .enumerate()
        .skip(2)
        .filter(|(_, name)| !name.trim().is_empty())
        .map(|(column, name)| (column, Mark::labelled(name)))
        .collect();
    let is_row =
        |line: &&str| line.trim_start().starts_with(|c: char| c.is_ascii_digit() || c == '-');
    // One more than there may be is refused here.
    let rows: Vec<&str> = lines.filter(is_row).take(limits.frames.saturating_add(1)).collect();
    let mut points = reserve(at, rows.len(), columns.len(), limits, budget)?;
    let width = columns.last().map_or(0, |(column, _)| column + 3);
    for row in &rows {
        let cells: Vec<&str> = row.split('\t').map(str::trim).take(width).collect();
        let number = |column: usize| -> f64 {
            cells.get(column).and_then(|cell| cell.parse().ok()).unwrap_or(f64::NAN)
        };
        for (column, _) in &columns {
            let p = [0, 1, 2].map(|axis| number(column + axis));
            let is_known = p.iter().all(|x| x.is_finite());
            points.push(if is_known { p.map(|x| x as f32) } else { [f32::NAN; 3] });
        }
    }
    let setting = |key: &str| settings.get(key).copied();
    let announced = setting("numframes").and_then(|count| count.parse::<usize>().ok());
    if announced.is_some_and(|count| count > rows.len()) {
        let (count, rows) = (announced.unwrap_or(0), rows.len());
        return Err(damaged(at, format!("it announces {count} frames and has {rows}")));
    }
    Ok(Markers {
        fps: setting("datarate").and_then(|fps| fps.parse().ok()).unwrap_or(f64::NAN),
        units: setting("units").unwrap_or_default().to_owned(),
        up_axis: None,
        usual_axes: ["+y", "+z"],
        marks: columns.into_iter().map(|(_, mark)| mark).collect(),
        points,
        left_out: Vec::new(),
    })
}
