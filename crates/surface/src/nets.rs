//! Surface nets: a mesh through the cells of a grid in which a function changes its sign, with a vertex for
//! each such cell and a quadrilateral across each edge that it cuts (Gibson 1998, "Constrained elastic surface
//! nets").
//!
//! A cell that the surface passes twice would have one vertex for both sheets, and edges of four triangles.
//! [`separate`] fills such cells first, so every edge has two triangles, and the mesh is closed.

use std::collections::HashMap;

use bendtwin_core::Point;

use crate::{grid::Grid, wrap::Wrapped};

/// Rounds of filling cells; each fills at least one of them, and few are ever needed.
const MOST_ROUNDS: usize = 64;

/// Fills samples until no cell has its inner samples, or its outer ones, in two parts.
pub(crate) fn separate(grid: &Grid, value: &mut [f32]) {
    let fill = 1e-3 * grid.cell_m as f32;
    for _ in 0..MOST_ROUNDS {
        let mut is_changed = false;
        for cell in cells(grid) {
            let corners = corners(grid, cell);
            let inside = corners.map(|i| value[i] > 0.0);
            if is_simple(inside) {
                continue;
            }
            is_changed = true;
            // Outer corners between inner ones join them.
            let outer = (0..8).filter(|k| !inside[*k]);
            let joined = |k: &usize| (0..3).filter(|a| inside[k ^ (1 << a)]).count();
            if let Some(most) = outer.max_by_key(joined) {
                value[corners[most]] = fill;
            }
        }
        if !is_changed {
            break;
        }
    }
}

/// The mesh of the places where a function passes 0; inside it is positive. It must be negative at the border of
/// the grid.
pub(crate) fn mesh(grid: &Grid, value: &[f32]) -> Wrapped {
    let mut vertices = Vec::new();
    let mut vertex_of: HashMap<usize, u32> = HashMap::new();
    for cell in cells(grid) {
        let corners = corners(grid, cell);
        let of = corners.map(|i| value[i]);
        let is_inside = |k: usize| of[k] > 0.0;
        let (mut sum, mut count) = ([0.0_f64; 3], 0.0);
        for k in 0..8 {
            for a in (0..3).filter(|a| k & (1 << a) == 0) {
                let other = k | (1 << a);
                if is_inside(k) == is_inside(other) {
                    continue;
                }
                let along = f64::from(of[k] / (of[k] - of[other]));
                for (b, sum) in sum.iter_mut().enumerate() {
                    let step = f64::from(u8::from(k & (1 << b) != 0));
                    *sum += if a == b { along } else { step };
                }
                count += 1.0;
            }
        }
        if count > 0.0 {
            vertex_of.insert(grid.index(cell), vertices.len() as u32);
            let steps = std::array::from_fn(|a| cell[a] as f64 + sum[a] / count);
            vertices.push(grid.place(steps).map(|x| x as f32));
        }
    }
    Wrapped { triangles: triangles(grid, value, &vertices, &vertex_of), vertices }
}

/// Two triangles across each edge of the grid at whose ends the function has different signs.
fn triangles(
    grid: &Grid,
    value: &[f32],
    vertices: &[Point],
    vertex_of: &HashMap<usize, u32>,
) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(2 * vertices.len());
    for index in 0..grid.len() {
        let steps = grid.steps(index);
        for a in 0..3 {
            let [b, c] = [(a + 1) % 3, (a + 2) % 3];
            if steps[a] + 1 >= grid.size[a] || steps[b] == 0 || steps[c] == 0 {
                continue;
            }
            let mut end = steps;
            end[a] += 1;
            let is_inside = value[index] > 0.0;
            if is_inside == (value[grid.index(end)] > 0.0) {
                continue;
            }
            let cell = |back: [usize; 2]| {
                let mut at = steps;
                at[b] -= back[0];
                at[c] -= back[1];
                vertex_of.get(&grid.index(at)).copied()
            };
            let around = [[0, 0], [1, 0], [1, 1], [0, 1]].map(cell);
            let [Some(p), Some(q), Some(r), Some(s)] = around else { continue };
            // Counter-clockwise seen from outside.
            let [p, q, r, s] = if is_inside { [p, q, r, s] } else { [p, s, r, q] };
            // Along the shorter diagonal.
            let square = |i: u32, j: u32| -> f32 {
                let [p, q] = [vertices[i as usize], vertices[j as usize]];
                p.iter().zip(q).map(|(p, q)| (p - q) * (p - q)).sum()
            };
            triangles.extend(match square(p, r) <= square(q, s) {
                true => [[p, q, r], [p, r, s]],
                false => [[q, r, s], [q, s, p]],
            });
        }
    }
    triangles
}

/// Lowest corners of all cells, as steps.
fn cells(grid: &Grid) -> impl Iterator<Item = [usize; 3]> + use<> {
    let [nx, ny, nz] = grid.size.map(|n| n.saturating_sub(1));
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// Samples at the corners of a cell; bit a of a corner's number is its step along axis a.
fn corners(grid: &Grid, cell: [usize; 3]) -> [usize; 8] {
    std::array::from_fn(|k| grid.index(std::array::from_fn(|a| cell[a] + (k >> a & 1))))
}

/// True if the inner corners of a cell are joined by its edges, and the outer ones as well.
fn is_simple(inside: [bool; 8]) -> bool {
    let parts = |of: bool| {
        let all = (0..8).filter(|k| inside[*k] == of).fold(0_u8, |set, k| set | 1 << k);
        if all == 0 {
            return 0;
        }
        let mut reached = 1_u8 << all.trailing_zeros();
        loop {
            let spread = |k: usize| (0..3).fold(0_u8, |set, a| set | 1 << (k ^ (1 << a)));
            let next = (0..8)
                .filter(|k| reached & (1 << k) != 0)
                .fold(reached, |set, k| set | (spread(k) & all));
            if next == reached {
                return if reached == all { 1 } else { 2 };
            }
            reached = next;
        }
    };
    // A face with inner corners across each other, joined around the cell, is cut twice, too.
    let crossed = |a: usize| {
        let [b, c] = [1 << ((a + 1) % 3), 1 << ((a + 2) % 3)];
        [0, 1 << a].iter().any(|&k: &usize| {
            inside[k] == inside[k | b | c]
                && inside[k | b] == inside[k | c]
                && inside[k] != inside[k | b]
        })
    };
    parts(true) < 2 && parts(false) < 2 && !(0..3).any(crossed)
}
