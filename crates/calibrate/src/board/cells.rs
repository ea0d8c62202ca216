//! Cells of a board in an image: dark or light quadrilaterals whose four corners are saddle points
//! that are joined by edges, and light ones beside dark ones at the rim of a chessboard, where only two
//! corners are.

use super::{corners::Saddle, homography::Homography};

/// Most neighbours of a corner that are asked in a direction.
const NEIGHBOURS: usize = 24;
/// Largest angle between an edge's direction at a corner and its other end [rad]: inner modules of a
/// tag lie at 8 degrees or more.
const STRAIGHT: f64 = 0.14;
/// An end at this angle counts as twice as far away [rad].
const BENT: f64 = 0.08;
/// Longest side of a cell [px].
const LONGEST: f64 = 1_000.0;

/// A quadrilateral between saddle points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Indices of the corners, clockwise as people see the image; `None` where there is no saddle
    /// point.
    pub(crate) corners: [Option<usize>; 4],
    /// Places of the corners [px].
    pub(crate) at: [[f64; 2]; 4],
    /// `true` if it is dark inside along its edges.
    pub(crate) dark: bool,
}

/// All cells between saddle points.
pub(crate) fn cells(saddles: &[Saddle]) -> Vec<Cell> {
    let links = links(saddles);
    let mut cells = Vec::new();
    for (first, start) in (0..saddles.len()).flat_map(|i| (0..4).map(move |q| (i, q))) {
        let mut corners = [first; 4];
        let (mut at, mut edge) = (first, start);
        let mut closed = false;
        for step in 0..4 {
            let Some((to, back)) = links[at][edge] else { break };
            // The inside lies after the edge that leads on, so before the one that leads back.
            (at, edge) = (to, (back + 3) % 4);
            match corners.get_mut(step + 1) {
                Some(corner) => *corner = at,
                None => closed = at == first && edge == start,
            }
        }
        // Each cell is met from all of its corners: the lowest counts.
        let lowest = corners.iter().all(|corner| *corner >= first);
        let distinct = (0..4).all(|i| (0..i).all(|j| corners[i] != corners[j]));
        if closed && lowest && distinct {
            let at = corners.map(|corner| saddles[corner].at);
            cells.push(Cell { corners: corners.map(Some), at, dark: start % 2 == 0 });
        }
    }
    cells.extend(rim(&cells));
    cells
}

/// The light cells beside dark ones that have no four saddle points, where the plane of the dark one
/// has them.
fn rim(cells: &[Cell]) -> Vec<Cell> {
    let sides: std::collections::HashSet<[Option<usize>; 2]> = cells
        .iter()
        .filter(|cell| !cell.dark)
        .flat_map(|cell| (0..4).map(|k| [cell.corners[k], cell.corners[(k + 1) % 4]]))
        .collect();
    let unit = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut found = Vec::new();
    for cell in cells.iter().filter(|cell| cell.dark) {
        for k in 0..4 {
            let side = [k, (k + 1) % 4];
            // The neighbour goes along the side the other way.
            let [a, b] = side.map(|corner| cell.corners[corner]);
            if sides.contains(&[b, a]) {
                continue;
            }
            // The side becomes the first of the unit square, and the neighbour lies above it.
            let turned: [[f64; 2]; 4] = std::array::from_fn(|i| cell.at[(k + i) % 4]);
            let beyond = Homography::of(&unit, &turned)
                .and_then(|plane| Some([plane.apply([0.0, -1.0])?, plane.apply([1.0, -1.0])?]));
            let Some([left, right]) = beyond else { continue };
            found.push(Cell {
                corners: [b, a, None, None],
                at: [turned[1], turned[0], left, right],
                dark: false,
            });
        }
    }
    found
}

/// For each corner and each of its edges the corner at the other end, and that corner's edge.
fn links(saddles: &[Saddle]) -> Vec<[Option<(usize, usize)>; 4]> {
    let towards: Vec<[Option<(usize, usize)>; 4]> =
        (0..saddles.len()).map(|i| ends(saddles, i)).collect();
    let mutual = |i: usize, edge: usize| {
        let (to, back) = towards[i][edge]?;
        (towards[to][back] == Some((i, edge))).then_some((to, back))
    };
    (0..saddles.len()).map(|i| std::array::from_fn(|edge| mutual(i, edge))).collect()
}

/// The nearest corner along each edge of a corner.
fn ends(saddles: &[Saddle], index: usize) -> [Option<(usize, usize)>; 4] {
    let from = &saddles[index];
    let mut near: Vec<(f64, usize)> = saddles
        .iter()
        .enumerate()
        .filter(|(other, _)| *other != index)
        .map(|(other, saddle)| {
            let [dx, dy] = [saddle.at[0] - from.at[0], saddle.at[1] - from.at[1]];
            (dx.hypot(dy), other)
        })
        .filter(|(distance, _)| *distance > 2.0 && *distance < LONGEST)
        .collect();
    let count = NEIGHBOURS.min(near.len());
    if count > 0 {
        near.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0));
    }
    let mut ends = [None; 4];
    for (edge, end) in ends.iter_mut().enumerate() {
        let mut best = f64::INFINITY;
        for &(distance, other) in &near[..count] {
            let to = &saddles[other];
            let angle = (to.at[1] - from.at[1]).atan2(to.at[0] - from.at[0]);
            let bend = turn(angle - from.edges[edge]).abs();
            if bend > STRAIGHT {
                continue;
            }
            // Seen from the other end, dark lies on the other side.
            let back = (0..4)
                .filter(|back| back % 2 != edge % 2)
                .map(|back| (turn(angle + std::f64::consts::PI - to.edges[back]).abs(), back))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((back_bend, back)) = back.filter(|(bend, _)| *bend < STRAIGHT) else {
                continue;
            };
            let cost = distance * (1.0 + (bend.max(back_bend) / BENT).powi(2));
            if cost < best {
                (best, *end) = (cost, Some((other, back)));
            }
        }
    }
    ends
}

/// An angle in -π..=π.
fn turn(angle: f64) -> f64 {
    let full = std::f64::consts::TAU;
    angle - full * (angle / full).round()
}
