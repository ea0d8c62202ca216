//! CSV files of OptiTrack's Motive: a line of settings, lines that name the columns, then a line for each
//! frame. Y points up.
//!
//! <https://docs.optitrack.com/motive/data-export/data-export-csv>

use std::collections::{BTreeMap, BTreeSet};

use bendtwin_core::geometry::cross;

use super::{Mark, Markers, charge_cells, damaged, reserve};
use crate::{Error, Limits, limits::Budget};

/// Distance from a rigid body's pivot of the points that stand for it if its markers were not exported
/// [m].
const BODY_M: f64 = 0.02;

/// Columns of a thing that a file tracks.
#[derive(Debug)]
struct Thing {
    kind: String,
    name: String,
    position: [Option<usize>; 3],
    /// Columns of the quaternion's x, y, z and w.
    rotation: [Option<usize>; 4],
}

pub(super) fn read(
    at: &str,
    text: &str,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<Markers, Error> {
    let mut lines = text.lines();
    let first = lines.next().unwrap_or_default();
    charge_cells(at, first, b',', budget)?;
    let settings = settings(first);
    let mut header: Vec<Vec<String>> = Vec::new();
    let axes = loop {
        let Some(line) = lines.next() else {
            return Err(damaged(
                at,
                "it has no line that begins with `Frame`: export it with its header",
            ));
        };
        charge_cells(at, line, b',', budget)?;
        let cells = cells(line);
        if cells.first().is_some_and(|cell| cell.eq_ignore_ascii_case("frame")) {
            break cells;
        }
        if header.len() > 12 {
            return Err(damaged(at, "it has no line that begins with `Frame` near its beginning"));
        }
        if cells.iter().any(|cell| !cell.is_empty()) {
            header.push(cells);
        }
    };
    let things = things(&header, &axes);
    let quaternions = settings.get("rotation type").is_none_or(|kind| kind.starts_with("Quat"));
    let units = settings.get("length units").cloned().unwrap_or_default();
    let body_m = BODY_M / super::frame("+y", &units).map_or(1.0, |frame| frame.metres_per_unit());
    let mut left_out = Vec::new();
    let columns = choose(things, quaternions, body_m, &mut left_out);

    // One more than there may be is refused below.
    let rows: Vec<&str> = lines
        .filter(|line| !line.trim_matches([',', ' ', '\r']).is_empty())
        .take(limits.frames.saturating_add(1))
        .collect();
    let marks: Vec<Mark> = columns.iter().map(|(mark, _)| mark.clone()).collect();
    let mut points = reserve(at, rows.len(), marks.len(), limits, budget)?;
    let mut times = [None, None];
    for (index, row) in rows.iter().enumerate() {
        let cells: Vec<&str> = row.split(',').map(str::trim).take(axes.len().max(2)).collect();
        let number = |column: usize| -> Option<f64> { cells.get(column)?.parse().ok() };
        if index == 0 {
            times[0] = number(1);
        }
        if index + 1 == rows.len() {
            times[1] = number(1);
        }
        for (_, place) in &columns {
            let p = place.at(&number).unwrap_or([f64::NAN; 3]);
            points.push(p.map(|x| x as f32));
        }
    }
    let declared = ["export frame rate", "capture frame rate"]
        .iter()
        .find_map(|key| settings.get(*key)?.parse::<f64>().ok())
        .filter(|fps| *fps > 0.0);
    let by_times = match times {
        [Some(first), Some(last)] if last > first => Some((rows.len() - 1) as f64 / (last - first)),
        _ => None,
    };
    Ok(Markers {
        fps: declared.or(by_times).unwrap_or(f64::NAN),
        units,
        up_axis: Some(("+y".to_owned(), "as Motive has it")),
        usual_axes: ["+y", "+z"],
        marks,
        points,
        left_out,
    })
}

/// Pairs of words in the first line.
fn settings(line: &str) -> BTreeMap<String, String> {
    let cells = cells(line);
    let pairs = cells.as_chunks::<2>().0.iter();
    pairs.map(|[key, value]| (key.to_ascii_lowercase(), value.clone())).collect()
}

/// Cells of a line, without quotes.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut is_quoted = false;
    for c in line.chars() {
        match c {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(String::new()),
            '\r' => {}
            _ => {
                if let Some(cell) = cells.last_mut() {
                    cell.push(c);
                }
            }
        }
    }
    cells.iter_mut().for_each(|cell| *cell = cell.trim().to_owned());
    cells
}

/// Things by their columns, in the order of the file. The lines above the axes are named in their second
/// cell; the last of them, which is not, tells positions from rotations.
fn things(header: &[Vec<String>], axes: &[String]) -> Vec<Thing> {
    let labelled = |name: &str| {
        header.iter().find(|row| row.get(1).is_some_and(|cell| cell.eq_ignore_ascii_case(name)))
    };
    // Older versions leave the names of the lines out.
    let kinds = labelled("type").or(header.first());
    let names = labelled("name").or(header.get(1));
    let parts = header.last();
    let cell = |row: Option<&Vec<String>>, column: usize| {
        row.and_then(|row| row.get(column)).cloned().unwrap_or_default()
    };
    let mut things: Vec<Thing> = Vec::new();
    let mut places: BTreeMap<(String, String), usize> = BTreeMap::new();
    for column in 2..axes.len() {
        let (kind, name) = (cell(kinds, column), cell(names, column));
        if name.is_empty() {
            continue;
        }
        let key = (kind.clone(), name.clone());
        let place = *places.entry(key).or_insert_with(|| {
            things.push(Thing { kind, name, position: [None; 3], rotation: [None; 4] });
            things.len() - 1
        });
        let Some(thing) = things.get_mut(place) else { continue };
        let slots: &mut [Option<usize>] = match cell(parts, column).as_str() {
            "Position" => &mut thing.position,
            "Rotation" => &mut thing.rotation,
            // The quality of a marker or the error of a body.
            _ => continue,
        };
        let own = axes.get(column).map(String::as_str);
        let axis = ["X", "Y", "Z", "W"].into_iter().position(|axis| own == Some(axis));
        if let Some(slot) = axis.and_then(|axis| slots.get_mut(axis)) {
            slot.get_or_insert(column);
        }
    }
    things
}

/// Where the position of a mark is found in a line.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// In three columns.
    Columns([usize; 3]),
    /// Beside the pivot of a body, along an axis of it, by its length.
    OnBody { pivot: [usize; 3], rotation: [usize; 4], offset: [f64; 3] },
}

impl Place {
    fn at(&self, number: &impl Fn(usize) -> Option<f64>) -> Option<[f64; 3]> {
        let three = |columns: [usize; 3]| {
            let [x, y, z] = columns.map(number);
            Some([x?, y?, z?])
        };
        match *self {
            Self::Columns(columns) => three(columns),
            Self::OnBody { pivot, rotation, offset } => {
                let p = three(pivot)?;
                let [x, y, z, w] = rotation.map(number);
                let turned = turn([x?, y?, z?, w?], offset);
                Some(std::array::from_fn(|a| p[a] + turned[a]))
            }
        }
    }
}

/// Turns a vector by a quaternion of x, y, z and w.
fn turn([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let axis = [x, y, z];
    let t = cross(axis, v).map(|c| 2.0 * c);
    let u = cross(axis, t);
    std::array::from_fn(|a| v[a] + w * t[a] + u[a])
}

/// The things that are taken as marks. Of a rigid body the markers are taken as it was solved, which are
/// there as long as the body is tracked; without any, points around its pivot.
fn choose(
    things: Vec<Thing>,
    quaternions: bool,
    body_m: f64,
    left_out: &mut Vec<(String, String)>,
) -> Vec<(Mark, Place)> {
    let sets_of = |kind: &str| -> BTreeSet<String> {
        let own = things.iter().filter(|t| t.kind == kind);
        own.map(|t| Mark::labelled(&t.name).set).collect()
    };
    let (seen, solved) = (sets_of("Marker"), sets_of("Rigid Body Marker"));
    let bodies: BTreeSet<&str> =
        things.iter().filter(|t| t.kind == "Rigid Body").map(|t| t.name.as_str()).collect();
    let mut chosen = Vec::new();
    for thing in &things {
        let [Some(x), Some(y), Some(z)] = thing.position else { continue };
        let mark = Mark::labelled(&thing.name);
        match thing.kind.as_str() {
            "Marker" if solved.contains(&mark.set) => {
                let why = "the body's own solution has its place without gaps";
                left_out.push((thing.name.clone(), why.to_owned()));
            }
            "Marker" => {
                let is_rigid = bodies.contains(mark.set.as_str());
                chosen.push((Mark { is_rigid, ..mark }, Place::Columns([x, y, z])));
            }
            "Rigid Body Marker" => {
                chosen.push((Mark { is_rigid: true, ..mark }, Place::Columns([x, y, z])));
            }
            "Rigid Body" if solved.contains(&thing.name) || seen.contains(&thing.name) => {}
            "Rigid Body" => match thing.rotation {
                [Some(a), Some(b), Some(c), Some(d)] if quaternions => {
                    let offsets = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                    for (index, offset) in offsets.into_iter().enumerate() {
                        let label = ["pivot", "x", "y", "z"][index].to_owned();
                        let mark = Mark { label, set: thing.name.clone(), is_rigid: true };
                        let offset = offset.map(|o: f64| o * body_m);
                        let rotation = [a, b, c, d];
                        chosen.push((mark, Place::OnBody { pivot: [x, y, z], rotation, offset }));
                    }
                }
                _ => {
                    let why = "a rigid body without markers is read with quaternions: export its rotation so";
                    left_out.push((thing.name.clone(), why.to_owned()));
                }
            },
            kind => left_out.push((thing.name.clone(), format!("it is a {}", kind.to_lowercase()))),
        }
    }
    chosen
}
