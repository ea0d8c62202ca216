//! From markers to a capture: points of the object, control points, and what was taken as what.

use std::collections::BTreeMap;

use bendtwin_core::{
    Capture, Environment, Finding, Plane, Point, Sequence,
    capture::{HeldPoint, Object},
};

use super::{
    Description, Kind, Markers, chain, description_of, frame,
    gaps::Path,
    names::{Index, Role, nothing_moves_it, roles},
};
use crate::{Error, Limits, Remarks, files::at_most, frame::Frame};

/// Share of the frames that are for fitting; the rest says how well the twin predicts.
const TRAIN_SHARE: f64 = 0.7;
/// Share of frames in which a control point has to be seen.
const LEAST_SEEN: f64 = 0.8;
/// Depth below the ground up to which calibration is inexact [m].
const GROUND_TOLERANCE_M: f32 = 0.02;
/// Speed below which a recording begins at rest [m/s].
const REST_M_S: f32 = 0.03;
/// Marks that a line of the sources names.
const NAMED: usize = 6;

pub(super) fn assemble(
    title: &str,
    at: &str,
    kind: Kind,
    markers: Markers,
    description: &Description,
    limits: &Limits,
) -> Result<(Capture, Remarks), Error> {
    let mut remarks = Remarks::default();
    let roles = roles(&markers.marks, description)?;
    let frames = markers.frame_count();
    let (turn, axis) = upright(&markers)?;
    let count = markers.marks.len();
    let path = |mark: usize| {
        let mut points: Vec<Point> =
            markers.points.iter().skip(mark).step_by(count.max(1)).copied().collect();
        turn.apply(&mut points);
        Path::of(points.into_iter())
    };
    let mut object: Vec<(usize, Path)> = Vec::new();
    let mut hands: Vec<(usize, Path)> = Vec::new();
    for (mark, role) in roles.iter().enumerate() {
        let name = || markers.marks[mark].full();
        let path = match role {
            Role::None(why) => {
                remarks.sources.leave_out(name(), *why);
                continue;
            }
            _ => path(mark),
        };
        let seen = path.seen_count();
        if seen == 0 {
            remarks.sources.leave_out(name(), "it is never seen");
        } else if *role == Role::Hand && (seen as f64) < LEAST_SEEN * frames as f64 {
            let share = 100.0 * (frames - seen) as f64 / frames as f64;
            let why = format!("it is hidden in {share:.0} % of the frames, and moves the object");
            remarks.sources.leave_out(name(), why);
        } else if *role == Role::Hand {
            hands.push((mark, path));
        } else {
            object.push((mark, path));
        }
    }
    for (what, why) in &markers.left_out {
        remarks.sources.leave_out(what.clone(), why.clone());
    }
    if object.is_empty() {
        let (total, hands) = (markers.marks.len(), hands.len());
        let fault = format!(
            "none of its {total} markers is a point of the object, {hands} are of a hand: label the markers of the object"
        );
        return Err(Error::Document { at: at.to_owned(), fault });
    }
    let held: Vec<usize> =
        (0..object.len()).filter(|i| roles[object[*i].0] == Role::Held).collect();
    at_most("control points", hands.len() + held.len(), limits.controls)?;

    let paths: Vec<&Path> = object.iter().map(|(_, path)| path).collect();
    let declared = declared_edges(&markers, description, &object);
    let edges = if declared.is_empty() { chain::edges(&paths) } else { declared };
    let list = |marks: &mut dyn Iterator<Item = usize>| {
        let names: Vec<String> = marks.map(|mark| markers.marks[mark].full()).collect();
        let shown = names.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", ");
        let more = if names.len() > NAMED { ", ..." } else { "" };
        format!("{} markers ({shown}{more})", names.len())
    };
    let form = format!("{}, {} fps, {}, {axis}", kind.words(), markers.fps, markers.units);
    let sources = &mut remarks.sources;
    sources.take("object", None, list(&mut object.iter().map(|(mark, _)| *mark)), form);
    if !edges.is_empty() {
        let form = if description.edges.is_empty() {
            "a chain, since neighbours keep their distance"
        } else {
            "as declared"
        };
        sources.take("edges", None, format!("{} pairs of markers", edges.len()), form);
    }
    if !hands.is_empty() {
        sources.take(
            "hand",
            None,
            list(&mut hands.iter().map(|(mark, _)| *mark)),
            "control points",
        );
    }
    if !held.is_empty() {
        let form = "points of the object that control points hold";
        sources.take("held", None, list(&mut held.iter().map(|i| object[*i].0)), form);
    }
    if hands.is_empty() && held.is_empty() {
        remarks.findings.push(nothing_moves_it(&description_of(at)));
    }
    let controls: Vec<&Path> =
        hands.iter().map(|(_, path)| path).chain(held.iter().map(|i| paths[*i])).collect();
    let gap = controls.iter().map(|path| path.longest_gap).max().unwrap_or(0);
    if gap > 0 {
        let message = format!(
            "markers that move the object are hidden for up to {gap} frames, in which they are taken to move straight on"
        );
        remarks.findings.push(Finding::info("CONTROLS_FILLED", message));
    }

    let by_frame = |paths: &[&Path]| -> Vec<Point> {
        (0..frames).flat_map(|f| paths.iter().map(move |path| path.points[f])).collect()
    };
    let points = by_frame(&paths);
    let visible: Vec<bool> =
        (0..frames).flat_map(|f| paths.iter().map(move |path| path.seen[f])).collect();
    let n = paths.len();
    let motion_valid =
        (0..visible.len()).map(|cell| cell >= n && visible[cell] && visible[cell - n]).collect();
    let start_frames = if frames > 1 && !begins_at_rest(&paths, markers.fps) { 2 } else { 1 };
    let lowest = points.iter().map(|p| p[2]).fold(f32::INFINITY, f32::min);
    let ground =
        (lowest > -GROUND_TOLERANCE_M).then_some(Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.0 });
    let pins = held.iter().enumerate().map(|(index, point)| HeldPoint {
        point: *point as u32,
        control: (hands.len() + index) as u32,
    });
    let capture = Capture {
        name: title.to_owned(),
        fps: markers.fps,
        environment: Environment { gravity: [0.0, 0.0, -9.81], ground },
        source_to_world: turn.rotation,
        object: Object { point_count: n, edges, pins: pins.collect(), ..Object::default() },
        sequences: vec![Sequence {
            name: "main".to_owned(),
            frame_count: frames,
            train_frame_count: (frames as f64 * TRAIN_SHARE).round() as usize,
            visible,
            motion_valid,
            points,
            controls: by_frame(&controls),
            truth_tracks: Vec::new(),
            start_frames,
        }],
        others: Vec::new(),
    };
    Ok((capture, remarks))
}

/// The frame of the file, and how the axis that points up was found: as the file or its description
/// says, else the usual one, unless points would lie below the ground that the other one has them on.
fn upright(markers: &Markers) -> Result<(Frame, String), Error> {
    let [usual, other] = markers.usual_axes;
    let (axis, how) = match &markers.up_axis {
        Some((axis, how)) => (axis.as_str(), *how),
        None => {
            let lowest = |axis: &str| -> Result<f32, Error> {
                let frame = frame(axis, &markers.units)?;
                let z = |p: &Point| frame.turn(*p)[2] * frame.metres;
                Ok(markers.points.iter().map(z).fold(f32::INFINITY, f32::min))
            };
            if lowest(usual)? < -GROUND_TOLERANCE_M && lowest(other)? >= -GROUND_TOLERANCE_M {
                (other, "since points lie above the ground so")
            } else {
                (usual, "as is usual: the file does not say")
            }
        }
    };
    Ok((frame(axis, &markers.units)?, format!("{axis} up, {how}")))
}

/// Edges between points of the object that the description declares.
fn declared_edges(
    markers: &Markers,
    description: &Description,
    object: &[(usize, Path)],
) -> Vec<[u32; 2]> {
    let index = Index::of(&markers.marks);
    let points: BTreeMap<usize, u32> =
        object.iter().enumerate().map(|(point, (mark, _))| (*mark, point as u32)).collect();
    let point = |label: &String| points.get(index.find(label).first()?).copied();
    let edge = |[a, b]: &[String; 2]| {
        let (a, b) = (point(a)?, point(b)?);
        (a != b).then_some([a, b])
    };
    description.edges.iter().filter_map(edge).collect()
}

/// True if the first frames show no motion beyond noise.
fn begins_at_rest(paths: &[&Path], fps: f64) -> bool {
    const FRAMES: usize = 6;
    let mut speeds: Vec<f32> = paths
        .iter()
        .filter_map(|path| {
            let (first, last) = (path.points.first()?, path.points.get(FRAMES)?);
            let metres = bendtwin_core::geometry::distance(*first, *last);
            Some(metres * fps as f32 / FRAMES as f32)
        })
        .collect();
    bendtwin_core::geometry::median(&mut speeds).is_none_or(|speed| speed < REST_M_S)
}
