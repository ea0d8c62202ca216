//! Shapes that deform as a hand moves them, in closed form: what the hand does reaches a part of the
//! object the later the farther it is from the grasp.

use std::f64::consts::{PI, TAU};

use bendtwin_core::geometry::{Vector, add, cross, distance, scaled, sub, unit};
use bendtwin_synth::analytic::Primitive;

const UPRIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Kind of object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Rope,
    Cable,
    Ring,
    Cloth,
    Block,
    Toy,
}

impl Shape {
    pub(super) const ALL: [Self; 6] =
        [Self::Rope, Self::Cable, Self::Ring, Self::Cloth, Self::Block, Self::Toy];

    /// Places at rest by which the shape is deformed [m]: it lies on the table.
    fn nodes(self) -> Vec<Vector> {
        let line = |count: usize, length: f64, radius: f64| -> Vec<Vector> {
            (0..count)
                .map(|i| {
                    let s = i as f64 / (count - 1) as f64;
                    [length * (s - 0.5), 0.03 * (PI * 2.2 * s).sin(), radius]
                })
                .collect()
        };
        match self {
            Self::Rope => line(26, 0.42, 0.014),
            Self::Cable => line(40, 0.46, 0.01),
            Self::Ring => (0..26)
                .map(|i| {
                    let (s, c) = (TAU * f64::from(i) / 26.0).sin_cos();
                    [0.09 * c, 0.09 * s, 0.018]
                })
                .collect(),
            Self::Cloth => (0..49)
                .map(|i| {
                    [0.036 * f64::from(i % 7) - 0.108, 0.036 * f64::from(i / 7) - 0.108, 0.012]
                })
                .collect(),
            Self::Block => vec![[0.0, 0.0, 0.04]],
            Self::Toy => vec![
                [0.0, 0.0, 0.045],
                [0.085, 0.0, 0.05],
                [0.035, 0.07, 0.03],
                [0.035, -0.07, 0.03],
                [-0.05, 0.06, 0.03],
                [-0.05, -0.06, 0.03],
            ],
        }
    }

    /// Places where hands hold it, the first of which is the only one if there is one hand.
    pub(super) fn grasps(self) -> [Vector; 2] {
        let nodes = self.nodes();
        let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
        match self {
            Self::Ring => [first, nodes[nodes.len() / 2]],
            Self::Block => [[-0.07, 0.0, 0.04], [0.07, 0.0, 0.04]],
            Self::Toy => [nodes[1], nodes[4]],
            _ => [first, last],
        }
    }

    /// The shape while its nodes are shifted.
    pub(super) fn posed(self, shift: impl Fn(Vector) -> Vector) -> Vec<Primitive> {
        let rest = self.nodes();
        let nodes: Vec<Vector> = rest.iter().map(|p| add(*p, shift(*p))).collect();
        let sphere = |center: &Vector, radius_m| Primitive::Sphere { center: *center, radius_m };
        match self {
            Self::Rope => tube(&nodes, 0.014, false),
            Self::Cable => tube(&nodes, 0.01, false),
            Self::Ring => tube(&nodes, 0.018, true),
            Self::Cloth => cloth(&nodes),
            Self::Block => {
                block(nodes[0], sub(shift([0.07, 0.0, 0.04]), shift([-0.07, 0.0, 0.04])))
            }
            Self::Toy => {
                let belly = Primitive::Ellipsoid {
                    center: nodes[0],
                    rotation: UPRIGHT,
                    half_axes_m: [0.065, 0.05, 0.045],
                };
                let radii = [0.036, 0.027, 0.027, 0.03, 0.03];
                let limbs = nodes[1..].iter().zip(radii).map(|(at, radius)| sphere(at, radius));
                std::iter::once(belly).chain(limbs).collect()
            }
        }
    }
}

/// Spheres so near each other that they look like a tube.
fn tube(nodes: &[Vector], radius_m: f64, is_closed: bool) -> Vec<Primitive> {
    let after = nodes.iter().skip(1).chain(nodes.first().filter(|_| is_closed));
    let ends = nodes.iter().zip(after);
    let between = ends.flat_map(|(a, b)| {
        let steps = (distance(*a, *b) / (0.8 * radius_m)).ceil().max(1.0) as usize;
        (0..steps).map(move |i| add(*a, scaled(sub(*b, *a), i as f64 / steps as f64)))
    });
    let last = nodes.last().copied();
    between.chain(last).map(|center| Primitive::Sphere { center, radius_m }).collect()
}

/// Flat pieces of a grid of seven by seven nodes.
fn cloth(nodes: &[Vector]) -> Vec<Primitive> {
    let at = |row: usize, column: usize| nodes[7 * row + column];
    let piece = |(row, column): (usize, usize)| {
        let along = sub(at(row, column + 1), at(row, column));
        let across = sub(at(row + 1, column), at(row, column));
        let x = unit(along).unwrap_or([1.0, 0.0, 0.0]);
        let z = unit(cross(along, across)).unwrap_or([0.0, 0.0, 1.0]);
        let y = cross(z, x);
        let corners =
            [at(row, column), at(row, column + 1), at(row + 1, column), at(row + 1, column + 1)];
        let center = scaled(corners.iter().fold([0.0; 3], |s, p| add(s, *p)), 0.25);
        Primitive::Rectangle {
            center,
            rotation: std::array::from_fn(|i| [x[i], y[i], z[i]]),
            // They overlap a little, so that nothing shows between them.
            half_sides_m: [0.021, 0.021],
        }
    };
    (0..6).flat_map(|row| (0..6).map(move |column| (row, column))).map(piece).collect()
}

/// The faces of a block whose one end is shifted against the other.
fn block(middle: Vector, bent: Vector) -> Vec<Primitive> {
    let x = unit(add([0.14, 0.0, 0.0], bent)).unwrap_or([1.0, 0.0, 0.0]);
    let y = unit(cross([0.0, 0.0, 1.0], x)).unwrap_or([0.0, 1.0, 0.0]);
    let axes = [x, y, cross(x, y)];
    let half = [0.07, 0.045, 0.04];
    let face = |(axis, side): (usize, f64)| {
        let [u, v] = [axes[(axis + 1) % 3], axes[(axis + 2) % 3]];
        Primitive::Rectangle {
            center: add(middle, scaled(axes[axis], side * half[axis])),
            rotation: std::array::from_fn(|i| [u[i], v[i], axes[axis][i]]),
            half_sides_m: [half[(axis + 1) % 3], half[(axis + 2) % 3]],
        }
    };
    (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]).map(face).collect()
}
