//! Labels of pixels from the shares of cells: sharper than cells by the pixels' own colours, and filled
//! where no depth was measured.

use crate::{
    backdrop::{Against, Backdrop, same_m},
    cells::NONE,
    colors::bin,
    looks::Looks,
    part::{BACKGROUND, HAND, OBJECT, PARTS, Shares, UNKNOWN, certainty, likeliest, only, shares},
    view::{Lens, View, color_square},
};

/// Weight of a pixel's own colour beside that of its cell.
const OWN_COLOR: f32 = 0.6;
/// Evidence of the colour of a pixel without depth, for and against the backdrop.
const BACKDROP_COLOR: f32 = 1.5;
/// Chance with which a walk ends in a pixel whose evidence is certain: with depth and without.
const HELD: f32 = 0.35;
const HELD_WITHOUT_DEPTH: f32 = 0.08;
const LEAST_HELD: f32 = 0.02;
/// Difference of two colours at which neighbouring pixels hang together by a third, of 255, and their
/// least connection.
const COLOR_EDGE: f32 = 24.0;
const MIN_CONNECTION: f32 = 0.03;
const SWEEPS: usize = 10;
/// Pixels around object and hand that are looked at.
const MARGIN: usize = 10;
/// Shares beyond which pixels among their like are certain.
const CERTAIN: f32 = 0.9;
/// Share of its label below which a pixel is doubtful.
const DOUBTFUL: f32 = 0.7;
/// Parts of a mask with fewer pixels, and with less than this share of the largest, are dropped.
const MIN_SPECK: usize = 12;
const MIN_SPECK_SHARE: f32 = 0.004;

/// Labels of the pixels of a view.
pub(crate) struct Painting {
    /// Parts by their indices, shape [height, width].
    pub(crate) labels: Vec<u8>,
    /// Share of object and hand whose label is doubtful, 0..=1.
    pub(crate) doubt: f32,
}

/// Labels the pixels of a view. `marked` are pixels with the parts that were marked there.
#[expect(clippy::too_many_arguments, reason = "one call, of what a camera knows")]
pub(crate) fn paint(
    lens: &Lens<'_>,
    view: &View,
    backdrop: &Backdrop,
    looks: &Looks,
    of_pixel: &[u32],
    evidence: &[f32],
    of_cell: &[Shares],
    marked: &[(usize, usize)],
) -> Painting {
    let mut all = vec![only(BACKGROUND); lens.len()];
    let mut held = vec![1.0_f32; lens.len()];
    let Some(area) = Area::around(lens, of_pixel, of_cell, marked) else {
        return Painting { labels: vec![BACKGROUND as u8; lens.len()], doubt: 0.0 };
    };
    for at in area.pixels(lens) {
        let color = looks.logs(bin(view.colors[at]));
        let has_depth = view.depths[at] > 0.0;
        let mut logs = color.map(|l| OWN_COLOR * l);
        if of_pixel[at] == NONE {
            logs[BACKGROUND] += if has_depth {
                evidence[at]
            } else {
                match backdrop.compare(at, 0.0, view.colors[at]) {
                    Against::Same | Against::Settled => BACKDROP_COLOR,
                    Against::Unknown if backdrop.color(at).is_some() => -BACKDROP_COLOR,
                    _ => 0.0,
                }
            };
        } else {
            let cell = of_cell[of_pixel[at] as usize];
            (0..PARTS).for_each(|k| logs[k] += 2.0 * (cell[k] + 0.02).ln());
        }
        all[at] = shares(logs);
        let most = if has_depth { HELD } else { HELD_WITHOUT_DEPTH };
        held[at] = LEAST_HELD + most * certainty(&all[at]);
    }
    for (at, part) in marked {
        (all[*at], held[*at]) = (only(*part), 1.0);
    }
    let open = area.uncertain(lens, &all, &held);
    diffuse(lens, view, &mut all, &held, &open);
    let mut labels: Vec<u8> = all.iter().map(|shares| likeliest(shares) as u8).collect();
    drop_specks(lens, &mut labels);
    let shown = labels.iter().zip(&all).filter(|(label, _)| usize::from(**label) != BACKGROUND);
    let (mut count, mut doubtful) = (0_u32, 0_u32);
    for (label, shares) in shown {
        count += 1;
        doubtful += u32::from(shares[usize::from(*label)] < DOUBTFUL);
    }
    Painting { labels, doubt: doubtful as f32 / count.max(1) as f32 }
}

/// Pixels around object and hand.
struct Area {
    columns: std::ops::Range<usize>,
    rows: std::ops::Range<usize>,
}

impl Area {
    fn around(
        lens: &Lens<'_>,
        of_pixel: &[u32],
        of_cell: &[Shares],
        marked: &[(usize, usize)],
    ) -> Option<Self> {
        let shown = of_pixel.iter().enumerate().filter_map(|(at, cell)| {
            let shares = of_cell.get(*cell as usize)?;
            (shares[BACKGROUND] < 0.6).then_some(at)
        });
        let mut area: Option<[usize; 4]> = None;
        for at in shown.chain(marked.iter().map(|(at, _)| *at)) {
            let (x, y) = (at % lens.width, at / lens.width);
            let [left, right, top, bottom] = area.unwrap_or([x, x, y, y]);
            area = Some([left.min(x), right.max(x), top.min(y), bottom.max(y)]);
        }
        let [left, right, top, bottom] = area?;
        Some(Self {
            columns: left.saturating_sub(MARGIN)..(right + MARGIN + 1).min(lens.width),
            rows: top.saturating_sub(MARGIN)..(bottom + MARGIN + 1).min(lens.height),
        })
    }

    fn pixels<'a>(&self, lens: &'a Lens<'_>) -> impl Iterator<Item = usize> + use<'a> {
        let (columns, width) = (self.columns.clone(), lens.width);
        self.rows.clone().flat_map(move |row| columns.clone().map(move |x| row * width + x))
    }

    /// Pixels that may still change: those that are not certain, and those beside others.
    fn uncertain(&self, lens: &Lens<'_>, all: &[Shares], held: &[f32]) -> Vec<u32> {
        let settled: Vec<u8> = all
            .iter()
            .map(|shares| {
                let best = likeliest(shares);
                if shares[best] > CERTAIN { best as u8 } else { PARTS as u8 }
            })
            .collect();
        let is_open = |at: &usize| {
            if held[*at] >= 1.0 {
                return false;
            }
            let (x, y) = (*at % lens.width, *at / lens.width);
            let own = settled[*at];
            if usize::from(own) == PARTS {
                return true;
            }
            let rows = y.saturating_sub(1)..(y + 2).min(lens.height);
            rows.into_iter().any(|row| {
                let from = row * lens.width + x.saturating_sub(1);
                let to = row * lens.width + (x + 2).min(lens.width);
                settled[from..to].iter().any(|other| *other != own)
            })
        };
        self.pixels(lens).filter(is_open).map(|at| at as u32).collect()
    }
}

/// Connection of two neighbouring pixels: less where colour or depth changes.
fn connection(view: &View, a: usize, b: usize) -> f32 {
    let color = (-color_square(view.colors[a], view.colors[b]) / (COLOR_EDGE * COLOR_EDGE)).exp();
    let (z, other) = (view.depths[a], view.depths[b]);
    let depth = if z > 0.0 && other > 0.0 {
        (-((z - other) / (1.5 * same_m(z))).powi(2)).exp()
    } else {
        1.0
    };
    MIN_CONNECTION + (1.0 - MIN_CONNECTION) * color * depth
}

/// The random walk of [`crate::cells::Cells::diffuse`] over the open pixels.
fn diffuse(lens: &Lens<'_>, view: &View, all: &mut [Shares], held: &[f32], open: &[u32]) {
    let (width, height) = (lens.width, lens.height);
    let around = |at: usize| {
        let (x, y) = (at % width, at / width);
        [
            (x > 0).then(|| at - 1),
            (x + 1 < width).then_some(at + 1),
            (y > 0).then(|| at - width),
            (y + 1 < height).then_some(at + width),
        ]
    };
    let links: Vec<[(u32, f32); 4]> = open
        .iter()
        .map(|at| {
            around(*at as usize).map(|other| match other {
                Some(other) => (other as u32, connection(view, *at as usize, other)),
                None => (*at, 0.0),
            })
        })
        .collect();
    let local: Vec<Shares> = open.iter().map(|at| all[*at as usize]).collect();
    for sweep in 0..SWEEPS {
        let mut update = |i: usize| {
            let at = open[i] as usize;
            let (mut sum, mut weight) = ([0.0; PARTS], 0.0);
            for (other, strength) in links[i] {
                let theirs = all[other as usize];
                (0..PARTS).for_each(|k| sum[k] += strength * theirs[k]);
                weight += strength;
            }
            let (stay, go) = (held[at], (1.0 - held[at]) / weight.max(1e-6));
            all[at] = std::array::from_fn(|k| stay * local[i][k] + go * sum[k]);
        };
        if sweep % 2 == 0 {
            (0..open.len()).for_each(&mut update);
        } else {
            (0..open.len()).rev().for_each(&mut update);
        }
    }
}

/// Drops small parts of masks: they become what surrounds them.
fn drop_specks(lens: &Lens<'_>, labels: &mut [u8]) {
    let (width, height) = (lens.width, lens.height);
    let mut seen = vec![false; labels.len()];
    let mut parts: Vec<(u8, Vec<u32>)> = Vec::new();
    for start in 0..labels.len() {
        let label = labels[start];
        if seen[start] || usize::from(label) == BACKGROUND {
            continue;
        }
        seen[start] = true;
        let mut part = vec![start as u32];
        let mut next = 0;
        while let Some(&at) = part.get(next) {
            next += 1;
            let at = at as usize;
            let (x, y) = (at % width, at / width);
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                for column in x.saturating_sub(1)..(x + 2).min(width) {
                    let other = row * width + column;
                    if labels[other] == label && !std::mem::replace(&mut seen[other], true) {
                        part.push(other as u32);
                    }
                }
            }
        }
        parts.push((label, part));
    }
    for label in [OBJECT, HAND] {
        let of_label = || parts.iter().filter(move |(l, _)| usize::from(*l) == label);
        let largest = of_label().map(|(_, part)| part.len()).max().unwrap_or(0);
        let least =
            (MIN_SPECK as f32).min(0.1 * largest as f32).max(MIN_SPECK_SHARE * largest as f32);
        for (_, part) in of_label().filter(|(_, part)| (part.len() as f32) < least) {
            let becomes = surrounding(lens, labels, part, label as u8);
            part.iter().for_each(|at| labels[*at as usize] = becomes);
        }
    }
}

/// The label that most pixels around a part have.
fn surrounding(lens: &Lens<'_>, labels: &[u8], part: &[u32], own: u8) -> u8 {
    let mut counts = UNKNOWN.map(|_| 0_u32);
    for at in part {
        let at = *at as usize;
        let (x, y) = (at % lens.width, at / lens.width);
        for row in y.saturating_sub(1)..(y + 2).min(lens.height) {
            for column in x.saturating_sub(1)..(x + 2).min(lens.width) {
                let label = labels[row * lens.width + column];
                if label != own {
                    counts[usize::from(label)] += 1;
                }
            }
        }
    }
    (0..PARTS).fold(0, |best, k| if counts[k] > counts[best] { k } else { best }) as u8
}
