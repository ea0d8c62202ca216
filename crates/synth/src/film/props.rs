//! Visible things: the body, a hand with its forearm, a table. All in one list of triangles.

use bendtwin_core::Point;

use crate::{
    hand::{FOREARM_M, Hand, THICKNESS_M},
    pose::{Pose, add, scale, sub, unit},
    texture::dye,
};

/// Half the width of the table, and of one of its tiles [m].
const TABLE_M: f32 = 0.9;
const TILES: u32 = 24;
/// The table's middle along x [m].
pub(super) const MIDDLE_M: f32 = 0.15;
/// Height of the table [m]: a little below the ground, so that a body that rests on it is drawn whole.
pub(super) const TABLE_Z_M: f32 = -0.001;
/// Segments around a limb.
const AROUND: u32 = 20;

/// A thing at rest.
#[derive(Clone, Debug, Default)]
pub(super) struct Prop {
    pub(super) rest: Vec<Point>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Thing that a triangle belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Thing {
    Body,
    Hand,
    Table,
}

/// All things, body first, then hand, then table.
#[derive(Clone, Debug)]
pub(super) struct Props {
    pub(super) rest: Vec<Point>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// First vertex and triangle of the hand and of the table.
    starts: [[usize; 2]; 2],
}

pub(super) fn assemble(body: Prop, hand: &Hand) -> Props {
    let mut props = Props { rest: body.rest, triangles: body.triangles, starts: [[0; 2]; 2] };
    for (slot, prop) in [hand_prop(hand), table()].into_iter().enumerate() {
        props.starts[slot] = [props.rest.len(), props.triangles.len()];
        let first = props.rest.len() as u32;
        props.rest.extend(prop.rest);
        props.triangles.extend(prop.triangles.into_iter().map(|t| t.map(|v| v + first)));
    }
    props
}

impl Props {
    pub(super) fn thing(&self, triangle: u32) -> Thing {
        let [hand, table] = self.starts.map(|[_, triangle]| triangle);
        match triangle as usize {
            t if t < hand => Thing::Body,
            t if t < table => Thing::Hand,
            _ => Thing::Table,
        }
    }

    /// Vertices in a frame: the body where it is, the hand carried, the table at rest.
    pub(super) fn posed(&self, body: &[Point], pose: &Pose, pivot: Point) -> Vec<Point> {
        let [hand, table] = self.starts.map(|[vertex, _]| vertex);
        let carried = self.rest[hand..table].iter().map(|p| pose.carry(pivot, *p));
        body.iter().copied().chain(carried).chain(self.rest[table..].iter().copied()).collect()
    }

    /// The colour at a place of a thing at rest, 0..=1; patches have about the size given [m].
    pub(super) fn color(thing: Thing, rest: Point, patch_m: f32) -> Point {
        match thing {
            Thing::Body => dye(11, rest, patch_m, [0.62, 0.42, 0.3], 0.42),
            Thing::Hand => dye(23, rest, 1.5 * patch_m, [0.85, 0.62, 0.5], 0.12),
            Thing::Table => dye(37, rest, 4.0 * patch_m, [0.5, 0.53, 0.56], 0.07),
        }
    }
}

/// An ellipsoid around the grasp and a round forearm.
fn hand_prop(hand: &Hand) -> Prop {
    let mut prop = Prop::default();
    let end = add(hand.grasp, scale(unit(hand.forearm), FOREARM_M));
    // Rings from pole to pole: of the palm, then of the forearm.
    let rings = 12;
    let palm: Vec<Vec<Point>> = (0..=rings)
        .map(|ring| {
            let (s, c) = (std::f32::consts::PI * ring as f32 / rings as f32).sin_cos();
            circle()
                .map(|[x, y]| {
                    let on_sphere = [s * x, s * y, c];
                    std::array::from_fn(|a| hand.grasp[a] + hand.size[a] * on_sphere[a])
                })
                .collect()
        })
        .collect();
    prop.tube(&palm);
    let axis = unit(sub(end, hand.grasp));
    let aside = unit([-axis[1], axis[0], 0.3]);
    let aside = unit(sub(aside, scale(axis, crate::pose::dot(aside, axis))));
    let across = [
        axis[1] * aside[2] - axis[2] * aside[1],
        axis[2] * aside[0] - axis[0] * aside[2],
        axis[0] * aside[1] - axis[1] * aside[0],
    ];
    let arm: Vec<Vec<Point>> = (0..=10)
        .map(|ring| {
            let middle = add(hand.grasp, scale(axis, FOREARM_M * ring as f32 / 10.0));
            let radius = 0.85 * THICKNESS_M;
            let around =
                |[x, y]: [f32; 2]| add(scale(aside, radius * x), scale(across, radius * y));
            circle().map(|at| add(middle, around(at))).collect()
        })
        .collect();
    prop.tube(&arm);
    prop
}

fn circle() -> impl Iterator<Item = [f32; 2]> {
    (0..AROUND).map(|k| {
        let (s, c) = (std::f32::consts::TAU * k as f32 / AROUND as f32).sin_cos();
        [c, s]
    })
}

fn table() -> Prop {
    let mut prop = Prop::default();
    let at = |i: u32| TABLE_M * (2.0 * i as f32 / TILES as f32 - 1.0);
    for row in 0..=TILES {
        prop.rest.extend((0..=TILES).map(|column| [MIDDLE_M + at(column), at(row), TABLE_Z_M]));
    }
    for (row, column) in (0..TILES).flat_map(|r| (0..TILES).map(move |c| (r, c))) {
        let corner = row * (TILES + 1) + column;
        let above = corner + TILES + 1;
        prop.triangles.extend([[corner, corner + 1, above + 1], [corner, above + 1, above]]);
    }
    prop
}

impl Prop {
    /// Joins rings of equally many points.
    fn tube(&mut self, rings: &[Vec<Point>]) {
        let first = self.rest.len() as u32;
        self.rest.extend(rings.iter().flatten());
        for ring in 1..rings.len() as u32 {
            for k in 0..AROUND {
                let below = first + (ring - 1) * AROUND;
                let (a, b) = (below + k, below + (k + 1) % AROUND);
                self.triangles.extend([[a, b, b + AROUND], [a, b + AROUND, a + AROUND]]);
            }
        }
    }
}
