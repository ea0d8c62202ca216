//! A closed mesh around points.

use bendtwin_core::{
    DisjointSets, Point,
    geometry::{Vector, add, cross, dot, scaled, sub, unit, wide},
};
use bendtwin_near::PointTree;
use nalgebra::{SMatrix, SVector};

use crate::{grid::Grid, nets};

/// A mesh that is closed: every edge has two triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wrapped {
    /// Positions [m], shape [V, 3].
    pub vertices: Vec<Point>,
    /// Corners, counter-clockwise seen from outside, shape [F, 3].
    pub triangles: Vec<[u32; 3]>,
}

/// Fewest points that have a surface.
const LEAST_POINTS: usize = 8;
/// Most points that are looked at, evenly taken: each marks the samples around it.
const MOST_POINTS: usize = 30_000;
/// Neighbour whose distance is a point's spacing, and the share of points whose spacing is less than that of all.
const SPACING_NEIGHBOUR: usize = 5;
const SPACING_SHARE: f64 = 0.8;
/// Spacing, over that of most points, beyond which a point is a stray.
const STRAY: f64 = 10.0;
/// Radii of the balls, over the spacing, of which the least that encloses the inside is taken.
const RADII: [f64; 4] = [1.0, 1.4, 2.0, 2.8];
/// Place in [`RADII`] of the radius where nothing is known of the inside.
const USUAL: usize = 1;
/// Share of the points inside that must be enclosed.
const ENCLOSED: f64 = 0.95;
/// Cells of a grid over the spacing, and the most samples.
const CELL: f64 = 0.4;
const MOST_SAMPLES: usize = 2_000_000;
/// Most vertices: more are not seen, and each has weights of nodes.
const MOST_VERTICES: usize = 4000;
/// Half the thickness of parts that are thinner than a cell, in cells.
const THIN: f64 = 0.7;
/// Parts with fewer vertices than this share of the largest are left out.
const LEAST_PART: f64 = 0.05;
/// Rounds of smoothing, and the steps of each: forth, and back so that the volume stays (Taubin 1995).
const SMOOTHING_ROUNDS: usize = 6;
const SMOOTHING: [f64; 2] = [0.5, -0.53];
/// Distance of the points that a vertex approaches, their number, and their height above it, all but the number
/// over the spacing.
const FIT_REACH: f64 = 2.5;
const FIT_POINTS: usize = 24;
const MOST_HEIGHT: f64 = 1.0;
/// Weight of no slope and no curvature, in points.
const RIDGE: f64 = 0.02;

/// A closed mesh around the points of a surface. `inside` has points that are known to lie inside. `None` if
/// there are too few points, or if they lie in one place.
pub fn wrap(surface: &[Point], inside: &[Point]) -> Option<Wrapped> {
    let [surface, inside] = [surface, inside].map(usable);
    if surface.len() < LEAST_POINTS {
        return None;
    }
    let spacings = spacings(&surface);
    let spacing_m = usual(&spacings)?;
    // A grid that reaches to strays would be too coarse for the rest.
    let is_near = |spacing: &f64| *spacing <= STRAY * spacing_m;
    let near = surface.iter().zip(&spacings).filter(|(_, spacing)| is_near(spacing));
    let surface: Vec<Point> = near.map(|(p, _)| *p).collect();
    let mut cell_m = CELL * spacing_m;
    loop {
        let radii_m = |cell_m: f64| RADII.map(|radius| (radius * spacing_m).max(1.5 * cell_m));
        let margin_m = |cell_m: f64| radii_m(cell_m)[RADII.len() - 1] + 3.0 * cell_m;
        let grid = Grid::around(&surface, margin_m, cell_m, MOST_SAMPLES)?;
        let radii_m = radii_m(grid.cell_m);
        let mesh = wrap_in_grid(&grid, &surface, &inside, spacing_m, radii_m)?;
        if mesh.vertices.len() <= MOST_VERTICES {
            return Some(mesh);
        }
        cell_m = grid.cell_m * (mesh.vertices.len() as f64 / MOST_VERTICES as f64).sqrt() * 1.05;
    }
}

/// At most [`MOST_POINTS`] of the points that are finite.
fn usable(points: &[Point]) -> Vec<Point> {
    let every = points.len().div_ceil(MOST_POINTS).max(1);
    let finite = |p: &&Point| p.iter().all(|x| x.is_finite());
    points.iter().filter(finite).step_by(every).copied().collect()
}

/// Distance of each point from its neighbours [m].
fn spacings(points: &[Point]) -> Vec<f64> {
    let tree = PointTree::new(points.iter().copied());
    let neighbour = |p: &Point| {
        let near = tree.within(*p, f64::INFINITY, SPACING_NEIGHBOUR);
        near.last().map_or(f64::INFINITY, |last| last.square.sqrt())
    };
    points.iter().map(neighbour).collect()
}

/// The spacing that most points do not exceed [m]; `None` if they lie in one place.
fn usual(spacings: &[f64]) -> Option<f64> {
    let mut sorted = spacings.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = (SPACING_SHARE * sorted.len() as f64) as usize;
    sorted.get(at).copied().filter(|spacing_m| *spacing_m > 0.0 && spacing_m.is_finite())
}

/// The mesh on a grid that reaches three cells beyond balls of the largest radius.
fn wrap_in_grid(
    grid: &Grid,
    surface: &[Point],
    inside: &[Point],
    spacing_m: f64,
    radii: [f64; 4],
) -> Option<Wrapped> {
    let reach_m = radii[RADII.len() - 1] + 2.0 * grid.cell_m;
    let mut to_points = distances(grid, surface, reach_m);
    let (mut radius_m, mut outside) = (radii[USUAL], Vec::new());
    let mut is_enclosed = inside.is_empty();
    if is_enclosed {
        outside = flood(grid, &to_points, radius_m);
    }
    for radius in radii {
        if is_enclosed {
            break;
        }
        (radius_m, outside) = (radius, flood(grid, &to_points, radius));
        let enclosed = inside.iter().filter_map(|p| grid.nearest(*p)).filter(|i| !outside[*i]);
        is_enclosed = enclosed.count() as f64 >= ENCLOSED * inside.len() as f64;
    }
    if !is_enclosed {
        // The surface has large gaps: what lies inside fills them.
        let all: Vec<Point> = surface.iter().chain(inside).copied().collect();
        to_points = distances(grid, &all, reach_m);
        let apart_m = usual(&spacings(inside)).unwrap_or_default();
        radius_m = apart_m.clamp(radii[USUAL], radii[RADII.len() - 1]);
        outside = flood(grid, &to_points, radius_m);
    }
    let depth = depths(grid, &to_points, &outside, radius_m);
    let thickening = thickening(grid, &depth, radius_m);
    let mut value: Vec<f32> =
        depth.iter().zip(&thickening).map(|(d, more)| d - radius_m as f32 + more).collect();
    nets::separate(grid, &mut value);
    let mut mesh = nets::mesh(grid, &value);
    mesh.drop_small_parts();
    mesh.smooth();
    let is_thin = |p: &Point| grid.nearest(*p).is_none_or(|i| thickening[i] > 0.0);
    mesh.approach(surface, spacing_m, is_thin);
    (!mesh.triangles.is_empty()).then_some(mesh)
}

/// Distance of each sample from the nearest point [m], up to `reach_m`.
fn distances(grid: &Grid, points: &[Point], reach_m: f64) -> Vec<f32> {
    let mut distance = vec![reach_m as f32; grid.len()];
    let reach = reach_m / grid.cell_m;
    for p in points {
        let at = grid.steps_to(*p);
        let range = |a: usize| {
            let first = (at[a] - reach).ceil().max(0.0) as usize;
            let last = (at[a] + reach).floor().max(0.0) as usize;
            first..=last.min(grid.size[a] - 1)
        };
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let offset = [x as f64 - at[0], y as f64 - at[1], z as f64 - at[2]];
                    let d = offset.iter().map(|o| o * o).sum::<f64>().sqrt() * grid.cell_m;
                    let own = &mut distance[grid.index([x, y, z])];
                    *own = own.min(d as f32);
                }
            }
        }
    }
    distance
}

/// Samples that are joined with the border of the grid outside of all balls.
fn flood(grid: &Grid, to_points: &[f32], radius_m: f64) -> Vec<bool> {
    let radius = radius_m as f32;
    let mut outside = vec![false; grid.len()];
    // The grid reaches beyond all balls, so its border is joined.
    let mut left = vec![0];
    outside[0] = true;
    while let Some(index) = left.pop() {
        for next in grid.neighbours(index) {
            if !outside[next] && to_points[next] > radius {
                outside[next] = true;
                left.push(next);
            }
        }
    }
    outside
}

/// Distance of each sample from the outside [m]; outside, minus that from the balls.
fn depths(grid: &Grid, to_points: &[f32], outside: &[bool], radius_m: f64) -> Vec<f32> {
    let radius = radius_m as f32;
    let mut depth: Vec<f32> = to_points
        .iter()
        .enumerate()
        .map(|(index, d)| {
            let is_known = outside[index] || grid.neighbours(index).any(|next| outside[next]);
            if is_known { radius - d } else { f32::INFINITY }
        })
        .collect();
    // Fast sweeping (Zhao 2005) in each of eight directions.
    for direction in 0..8 {
        let [nx, ny, nz] = grid.size;
        let turned = |at: usize, n: usize, bit: usize| {
            if direction >> bit & 1 == 0 { at } else { n - 1 - at }
        };
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let steps = [turned(x, nx, 0), turned(y, ny, 1), turned(z, nz, 2)];
                    let index = grid.index(steps);
                    if !outside[index] {
                        let next = updated(grid, &depth, index, steps);
                        depth[index] = depth[index].min(next);
                    }
                }
            }
        }
    }
    depth
}

/// The depth of a sample by those of its neighbours: that of a plane through the least along each axis.
fn updated(grid: &Grid, depth: &[f32], index: usize, steps: [usize; 3]) -> f32 {
    let strides = [1, grid.size[0], grid.size[0] * grid.size[1]];
    let mut least: [f32; 3] = std::array::from_fn(|a| {
        let below = if steps[a] > 0 { depth[index - strides[a]] } else { f32::INFINITY };
        let is_last = steps[a] + 1 == grid.size[a];
        below.min(if is_last { f32::INFINITY } else { depth[index + strides[a]] })
    });
    least.sort_by(f32::total_cmp);
    let [a, b, c] = least;
    let h = grid.cell_m as f32;
    let one = a + h;
    if one <= b {
        return one;
    }
    let two = (a + b + (2.0 * h * h - (a - b).powi(2)).sqrt()) / 2.0;
    if two <= c {
        return two;
    }
    let sum = a + b + c;
    let squares = a * a + b * b + c * c;
    (sum + (sum * sum - 3.0 * (squares - h * h)).max(0.0).sqrt()) / 3.0
}

/// What is added to each sample's depth where the object is thinner than cells can show [m].
fn thickening(grid: &Grid, depth: &[f32], radius_m: f64) -> Vec<f32> {
    let (cell, radius) = (grid.cell_m as f32, radius_m as f32);
    let thin = |deepest: f32| ((radius + 1.5 * cell - deepest) / (0.75 * cell)).clamp(0.0, 1.0);
    deepest_nearby(grid, depth).into_iter().map(|d| thin(d) * THIN as f32 * cell).collect()
}

/// The largest depth within two samples along each axis.
fn deepest_nearby(grid: &Grid, depth: &[f32]) -> Vec<f32> {
    let mut deepest = depth.to_vec();
    let strides = [1, grid.size[0], grid.size[0] * grid.size[1]];
    for (a, stride) in strides.into_iter().enumerate() {
        let before = deepest.clone();
        for (index, deepest) in deepest.iter_mut().enumerate() {
            let step = grid.steps(index)[a];
            let first = index - step.min(2) * stride;
            let last = index + (grid.size[a] - 1 - step).min(2) * stride;
            let along = (first..=last).step_by(stride).map(|i| before[i]);
            *deepest = along.fold(*deepest, f32::max);
        }
    }
    deepest
}

impl Wrapped {
    /// Leaves out parts that are small beside the largest: points that lie apart by error.
    fn drop_small_parts(&mut self) {
        let mut sets = DisjointSets::new(self.vertices.len());
        for [a, b] in self.edges() {
            sets.union(a, b);
        }
        let parts = sets.names();
        let mut sizes = vec![0_usize; parts.len()];
        parts.iter().for_each(|part| sizes[*part as usize] += 1);
        let largest = sizes.iter().copied().max().unwrap_or_default();
        let least = LEAST_PART * largest as f64;
        let is_kept = |vertex: usize| sizes[parts[vertex] as usize] as f64 >= least;
        let mut numbers = Vec::with_capacity(parts.len());
        let mut next = 0_u32;
        for vertex in 0..parts.len() {
            numbers.push(next);
            next += u32::from(is_kept(vertex));
        }
        self.triangles.retain(|t| is_kept(t[0] as usize));
        self.triangles.iter_mut().flatten().for_each(|i| *i = numbers[*i as usize]);
        let mut vertex = 0;
        self.vertices.retain(|_| {
            vertex += 1;
            is_kept(vertex - 1)
        });
    }

    /// The edges of all triangles; of a closed mesh each is there once in each direction.
    fn edges(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
    }

    /// Smooths the steps of the grid.
    fn smooth(&mut self) {
        let mut degree = vec![0_u32; self.vertices.len()];
        self.edges().for_each(|[a, _]| degree[a as usize] += 1);
        let mut places: Vec<[f64; 3]> = self.vertices.iter().map(|v| v.map(f64::from)).collect();
        for _ in 0..SMOOTHING_ROUNDS {
            for step in SMOOTHING {
                let mut sums = vec![[0.0; 3]; places.len()];
                for [a, b] in self.edges() {
                    let (sum, of) = (&mut sums[a as usize], places[b as usize]);
                    *sum = std::array::from_fn(|k| sum[k] + of[k]);
                }
                for ((place, sum), degree) in places.iter_mut().zip(&sums).zip(&degree) {
                    let degree = f64::from((*degree).max(1));
                    *place =
                        std::array::from_fn(|k| place[k] + step * (sum[k] / degree - place[k]));
                }
            }
        }
        self.vertices = places.iter().map(|p| p.map(|x| x as f32)).collect();
    }

    /// Moves vertices along their normals onto the points: between points the balls leave dents.
    fn approach(&mut self, surface: &[Point], spacing_m: f64, is_thin: impl Fn(&Point) -> bool) {
        let tree = PointTree::new(surface.iter().copied());
        let mut normals = vec![[0.0; 3]; self.vertices.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|i| wide(self.vertices[i as usize]));
            let area = cross(sub(b, a), sub(c, a));
            triangle.iter().for_each(|i| normals[*i as usize] = add(normals[*i as usize], area));
        }
        for (vertex, normal) in self.vertices.iter_mut().zip(normals) {
            // Both sides of a sheet would come to one place.
            let Some(normal) = unit(normal).filter(|_| !is_thin(vertex)) else { continue };
            let near = tree.within(*vertex, FIT_REACH * spacing_m, FIT_POINTS);
            let near: Vec<Vector> = near.iter().map(|n| wide(surface[n.number as usize])).collect();
            let height_m = fitted_height(wide(*vertex), normal, &near, spacing_m);
            let height_m = height_m.clamp(-spacing_m / 2.0, spacing_m / 2.0);
            *vertex = add(wide(*vertex), scaled(normal, height_m)).map(|x| x as f32);
        }
    }
}

/// Height of a quadratic surface through points above a vertex, along its normal [m]; 0 without enough points.
fn fitted_height(vertex: Vector, normal: Vector, near: &[Vector], spacing_m: f64) -> f64 {
    let axis = if normal[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let Some(across) = unit(cross(normal, axis)) else { return 0.0 };
    let other = cross(normal, across);
    let mut system = SMatrix::<f64, 6, 6>::zeros();
    let mut right = SVector::<f64, 6>::zeros();
    let mut count = 0;
    for p in near {
        let offset = scaled(sub(*p, vertex), 1.0 / spacing_m);
        let [u, v, height] = [dot(offset, across), dot(offset, other), dot(offset, normal)];
        // Points beyond are of another side.
        if height.abs() > MOST_HEIGHT {
            continue;
        }
        let weight = (-(u * u + v * v)).exp();
        let row = SVector::from([1.0, u, v, u * u, u * v, v * v]);
        system += row * row.transpose() * weight;
        right += row * (weight * height);
        count += 1;
    }
    if count < 6 {
        return 0.0;
    }
    // Slopes and curvatures that few points show count as small.
    for k in 1..6 {
        system[(k, k)] += RIDGE;
    }
    let solved = system.cholesky().map(|factors| factors.solve(&right)[0]);
    solved.filter(|height| height.is_finite()).map_or(0.0, |height| height * spacing_m)
}
