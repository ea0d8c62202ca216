//! Visible things: the body, a hand with its forearm, a table. All in one list of triangles.

use bendtwin_core::Point;

use crate::{
    film::{Actor, Dyes},
    hand::{FOREARM_M, Hand, THICKNESS_M},
    pose::{add, scale, sub, unit},
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
    Clutter,
}

/// All things, body first, then hands, then the table and what stands on it.
#[derive(Clone, Debug)]
pub(super) struct Props {
    pub(super) rest: Vec<Point>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// First vertex of each hand, and of the table.
    hands: Vec<usize>,
    table: usize,
    /// First triangle of the hands, of the table and of what stands on it.
    starts: [usize; 3],
}

pub(super) fn assemble(body: Prop, actors: &[Actor], clutter: bool) -> Props {
    let mut props = Props {
        rest: body.rest,
        triangles: body.triangles,
        hands: Vec::new(),
        table: 0,
        starts: [0; 3],
    };
    props.starts[0] = props.triangles.len();
    for actor in actors {
        props.hands.push(props.rest.len());
        props.add(hand_prop(&actor.hand));
    }
    (props.table, props.starts[1]) = (props.rest.len(), props.triangles.len());
    props.add(table());
    props.starts[2] = props.triangles.len();
    if clutter {
        props.add(block());
    }
    props
}

impl Props {
    fn add(&mut self, prop: Prop) {
        let first = self.rest.len() as u32;
        self.rest.extend(prop.rest);
        self.triangles.extend(prop.triangles.into_iter().map(|t| t.map(|v| v + first)));
    }

    pub(super) fn thing(&self, triangle: u32) -> Thing {
        let [hand, table, clutter] = self.starts;
        match triangle as usize {
            t if t < hand => Thing::Body,
            t if t < table => Thing::Hand,
            t if t < clutter => Thing::Table,
            _ => Thing::Clutter,
        }
    }

    /// Vertices in a frame: the body where it is, the hands carried, the rest in its place.
    pub(super) fn posed(
        &self,
        body: &[Point],
        actors: &[Actor],
        frame: usize,
    ) -> Option<Vec<Point>> {
        let mut posed = body.to_vec();
        let ends = self.hands.iter().skip(1).copied().chain([self.table]);
        for ((start, end), actor) in self.hands.iter().zip(ends).zip(actors) {
            let pose = actor.poses.get(frame)?;
            let carried = self.rest[*start..end].iter();
            posed.extend(carried.map(|p| pose.carry(actor.hand.grasp, *p)));
        }
        posed.extend(&self.rest[self.table..]);
        Some(posed)
    }

    /// The colour at a place of a thing at rest, 0..=1; patches have about the size given [m].
    pub(super) fn color(thing: Thing, rest: Point, patch_m: f32, dyes: &Dyes) -> Point {
        let dyed = |seed: u64, patches: f32, (base, contrast): (Point, f32)| {
            dye(seed, rest, patches * patch_m, base, contrast)
        };
        match thing {
            Thing::Body => dyed(11, 1.0, dyes.body),
            Thing::Hand => dyed(23, 1.5, dyes.hand),
            Thing::Table => dyed(37, 4.0, dyes.table),
            Thing::Clutter => dyed(41, 2.0, ([0.3, 0.5, 0.35], 0.2)),
        }
    }
}

/// A block on the table, away from where hands work.
fn block() -> Prop {
    let (low, high): (Point, Point) = ([0.22, 0.28, -0.001], [0.32, 0.36, 0.09]);
    let corner = |k: u32| std::array::from_fn(|a| if (k >> a) & 1 == 1 { high[a] } else { low[a] });
    let sides =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Prop { rest: (0..8).map(corner).collect(), triangles: triangles.collect() }
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
