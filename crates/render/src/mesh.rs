//! The surface that nodes carry: made once for a twin, posed for each of its states, and drawn by any camera.

use std::collections::HashSet;

use bendtwin_core::{
    Point, Surface,
    geometry::{dot, scaled},
};
use bendtwin_splat::Camera;

use crate::{
    light::{Light, linear, normals},
    picture::{NEAR_M, View},
    raster::{Corner, Raster},
    solid::{Pose, Solid},
};

/// Colour of what has none (sRGB): a light blue grey.
pub(crate) const PLAIN: [u8; 3] = [142, 170, 191];

/// A surface, or balls at nodes, with what does not depend on the state. V is the number of vertices.
#[derive(Clone, Debug)]
pub struct Mesh {
    surface: Surface,
    faces: Vec<[u32; 3]>,
    /// Light that each vertex gives back, shape [V, 3].
    colors: Vec<[f32; 3]>,
    /// True if every edge has a triangle on each side: then nothing shows the inside.
    is_closed: bool,
    /// Radius of balls at the nodes [m]; 0 without.
    ball_m: f32,
}

/// A surface in a state and its light, in the world.
#[derive(Clone, Debug)]
pub struct Posed<'a> {
    mesh: &'a Mesh,
    positions: Vec<Point>,
    /// Light of each vertex seen from outside, and seen from inside of one that is open.
    outside: Vec<[f32; 3]>,
    inside: Vec<[f32; 3]>,
    /// Places of balls [m].
    balls: Vec<Point>,
    light: Light,
}

/// A corner of a triangle as a camera sees it.
#[derive(Clone, Copy)]
struct Seen {
    /// Place in the axes of the camera [m].
    at: [f32; 3],
    light: [f32; 3],
}

/// A surface projected for a camera.
pub(crate) struct Projected<'a> {
    posed: &'a Posed<'a>,
    view: View,
    /// Places of vertices in the axes of the camera [m].
    seen: Vec<Point>,
    /// Place in the picture [samples] and the inverse depth of each vertex in front of the camera.
    corners: Vec<[f32; 3]>,
    balls: Vec<Solid>,
}

impl Mesh {
    /// A surface; `colors` has the colour of each of its vertices, those of tubes included (sRGB), shape [V, 3], or is
    /// empty.
    pub fn new(surface: Surface, colors: &[[u8; 3]]) -> Self {
        let faces = surface.faces();
        let count = surface.vertex_count();
        let color = |i: usize| linear(colors.get(i).copied().unwrap_or(PLAIN));
        let is_closed = is_closed(&faces);
        Self { colors: (0..count).map(color).collect(), surface, faces, is_closed, ball_m: 0.0 }
    }

    /// Balls of a radius [m] at the nodes, for a twin that has no surface.
    pub fn of_balls(radius_m: f32) -> Self {
        Self { ball_m: radius_m, ..Self::new(Surface::default(), &[]) }
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.faces.len()
    }

    /// Memory of a state of it [bytes].
    pub fn posed_bytes(&self) -> usize {
        // Positions, normals while they are added, two lights, and the projection for a camera.
        self.colors.len() * 96
    }

    /// The surface with nodes at these places [m], shape [N, 3].
    pub fn at(&self, nodes: &[Point], light: &Light) -> Posed<'_> {
        let positions = self.surface.positions(nodes);
        let normals = normals(&positions, &self.faces);
        let lit = |sign: f32| {
            let of = |(color, normal): (&[f32; 3], &[f32; 3])| {
                scaled(*color, light.on(scaled(*normal, sign)))
            };
            self.colors.iter().zip(&normals).map(of).collect()
        };
        Posed {
            outside: lit(1.0),
            inside: if self.is_closed { Vec::new() } else { lit(-1.0) },
            positions,
            balls: if self.ball_m > 0.0 { nodes.to_vec() } else { Vec::new() },
            light: *light,
            mesh: self,
        }
    }
}

/// True if each edge has one triangle that runs along it in each direction.
fn is_closed(faces: &[[u32; 3]]) -> bool {
    let ways = || faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut there = HashSet::with_capacity(3 * faces.len());
    ways().all(|way| there.insert(way)) && ways().all(|[a, b]| there.contains(&[b, a]))
}

impl Posed<'_> {
    /// The surface as a camera sees it.
    pub(crate) fn projected(&self, camera: &Camera) -> Projected<'_> {
        let view = View::of(camera);
        let seen: Vec<Point> = self.positions.iter().map(|p| view.seen(*p)).collect();
        let corners = seen.iter().map(|p| view.placed(*p)).collect();
        let ball = |at: &Point| Solid::Round { from: *at, to: *at, radius_m: self.mesh.ball_m };
        Projected { view, seen, corners, balls: self.balls.iter().map(ball).collect(), posed: self }
    }
}

impl Projected<'_> {
    /// Draws the part in a band.
    pub(crate) fn draw(&self, raster: &mut Raster, label: u8) {
        for ball in &self.balls {
            let color = linear(PLAIN);
            ball.draw(&Pose::default(), color, &self.posed.light, &self.view, raster, label);
        }
        let rows = raster.window().rows.map(|row| row as f32);
        for face in &self.posed.mesh.faces {
            let [a, b, c] = face.map(|i| i as usize);
            let depths = [self.seen[a][2], self.seen[b][2], self.seen[c][2]];
            if depths.iter().all(|z| *z >= NEAR_M) {
                let [p, q, r] = [self.corners[a], self.corners[b], self.corners[c]];
                let is_above = p[1] < rows[0] && q[1] < rows[0] && r[1] < rows[0];
                let is_below = p[1] > rows[1] && q[1] > rows[1] && r[1] > rows[1];
                // Counter-clockwise seen from outside is clockwise in rows that grow downwards: the back.
                let is_back = (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1]) > 0.0;
                if is_above || is_below || is_back && self.posed.mesh.is_closed {
                    continue;
                }
                let light = self.lights(is_back);
                let corner = |[x, y, nearness]: [f32; 3], i: usize| Corner {
                    x,
                    y,
                    nearness,
                    weight: nearness,
                    light: light[i],
                };
                raster.triangle(&[corner(p, a), corner(q, b), corner(r, c)], label);
            } else if depths.iter().any(|z| *z >= NEAR_M) {
                self.draw_clipped([a, b, c], raster, label);
            }
        }
    }

    fn lights(&self, is_back: bool) -> &[[f32; 3]] {
        if is_back { &self.posed.inside } else { &self.posed.outside }
    }

    /// Draws the part of a triangle that is not too near.
    fn draw_clipped(&self, face: [usize; 3], raster: &mut Raster, label: u8) {
        let [a, b, c] = face.map(|i| self.seen[i]);
        // The volume between camera and triangle has the sign of the side that is seen.
        let wide = |p: Point| p.map(f64::from);
        let is_back = dot(wide(a), bendtwin_core::geometry::cross(wide(b), wide(c))) > 0.0;
        if is_back && self.posed.mesh.is_closed {
            return;
        }
        let lights = self.lights(is_back);
        let seen = face.map(|i| Seen { at: self.seen[i], light: lights[i] });
        let mut polygon = [seen[0]; 4];
        let mut count = 0;
        let mut add = |corner: Seen| {
            polygon[count] = corner;
            count += 1;
        };
        for k in 0..3 {
            let (from, to) = (seen[k], seen[(k + 1) % 3]);
            let is_in = [from, to].map(|end| end.at[2] >= NEAR_M);
            if is_in[0] {
                add(from);
            }
            if is_in[0] != is_in[1] {
                let share = (NEAR_M - from.at[2]) / (to.at[2] - from.at[2]);
                let mix =
                    |p: [f32; 3], q: [f32; 3]| [0, 1, 2].map(|i| p[i] + share * (q[i] - p[i]));
                let [x, y, _] = mix(from.at, to.at);
                add(Seen { at: [x, y, NEAR_M], light: mix(from.light, to.light) });
            }
        }
        let corner = |of: &Seen| {
            let [x, y, nearness] = self.view.placed(of.at);
            Corner { x, y, nearness, weight: nearness, light: of.light }
        };
        let corners: Vec<Corner> = polygon[..count].iter().map(corner).collect();
        for k in 2..corners.len() {
            raster.triangle(&[corners[0], corners[k - 1], corners[k]], label);
        }
    }
}
