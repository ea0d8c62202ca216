//! Turns triangles so that all of a connected piece face the same way, outwards where the piece
//! encloses anything. Winding numbers count triangles by the way they face, and many meshes are not
//! consistent.

use std::collections::HashMap;

use crate::{Mesh, Vec3};

/// The corners of all triangles, turned.
pub(crate) fn oriented(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let mut triangles: Vec<[Vec3; 3]> = mesh.corners().collect();
    let welded = weld(&triangles);
    let neighbours = neighbours(&welded);
    let mut piece_of: Vec<Option<bool>> = vec![None; triangles.len()];
    for seed in 0..triangles.len() {
        if piece_of[seed].is_some() {
            continue;
        }
        // Across every edge that two triangles share: both must run along it in opposite
        // directions.
        let mut piece = vec![seed];
        piece_of[seed] = Some(false);
        let mut next = 0;
        while let Some(&t) = piece.get(next) {
            next += 1;
            let turned = piece_of[t].unwrap_or(false);
            for &(other, same_way) in &neighbours[t] {
                if piece_of[other].is_none() {
                    piece_of[other] = Some(turned ^ same_way);
                    piece.push(other);
                }
            }
        }
        for &t in &piece {
            if piece_of[t] == Some(true) {
                triangles[t].swap(1, 2);
            }
        }
        if volume(&piece, &triangles) < 0.0 {
            for &t in &piece {
                triangles[t].swap(1, 2);
            }
        }
    }
    triangles
}

/// Gives corners at the same place the same index: formats split vertices where normals or textures
/// have seams.
fn weld(triangles: &[[Vec3; 3]]) -> Vec<[u32; 3]> {
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::with_capacity(triangles.len() / 2);
    let mut number = |v: &Vec3| {
        let next = numbers.len() as u32;
        // 0 and -0 are the same place.
        *numbers.entry([v.x, v.y, v.z].map(|x| (x + 0.0).to_bits())).or_insert(next)
    };
    triangles.iter().map(|[a, b, c]| [number(a), number(b), number(c)]).collect()
}

/// The triangles across the edges of each triangle, and whether both run along the edge in the same
/// direction. Edges of more than two triangles join nothing: they do not show which triangles
/// belong together.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<Vec<(usize, bool)>> {
    let mut edges: Vec<([u32; 2], usize, bool)> = Vec::with_capacity(triangles.len() * 3);
    for (t, &[a, b, c]) in triangles.iter().enumerate() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from != to {
                edges.push(([from.min(to), from.max(to)], t, from < to));
            }
        }
    }
    edges.sort_unstable();
    let mut out = vec![Vec::new(); triangles.len()];
    for shared in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, t, forward), (_, other, other_forward)] = *shared {
            out[t].push((other, forward == other_forward));
            out[other].push((t, forward == other_forward));
        }
    }
    out
}

/// Six times the volume between a piece and its middle; negative if it faces inwards.
fn volume(piece: &[usize], triangles: &[[Vec3; 3]]) -> f64 {
    let sum: Vec3 = piece.iter().map(|t| triangles[*t].iter().sum::<Vec3>()).sum();
    let middle = sum / (3.0 * piece.len().max(1) as f64);
    let six_fold = |t: &usize| {
        let [a, b, c] = triangles[*t].map(|v| v - middle);
        a.dot(&b.cross(&c))
    };
    piece.iter().map(six_fold).sum()
}
