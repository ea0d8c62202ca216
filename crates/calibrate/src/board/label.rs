//! Corners of the board in an image: markers that agree with one plane name the corners of their
//! cells, and from these the others are found, neighbour by neighbour.

use bendtwin_core::settings::ingest::BoardPattern;

use super::{
    cells::{Cell, cells},
    corners::{Gray, Saddle, saddles},
    decode::{Decoded, decode},
    homography::Homography,
    layout::Board,
};
use crate::Error;

/// Least markers that have to agree: codes are found by chance in other things.
pub(crate) const MIN_MARKERS: usize = 2;
/// A corner that a plane predicts lies within this share of a cell's side.
const SNAP: f64 = 0.22;
/// Corners by which the place of another one is predicted: lenses bend lines over longer distances.
const NEAREST: usize = 10;

/// A corner of the board and where it appears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    /// Index into the board's corners.
    pub(crate) corner: usize,
    /// Column and row [px].
    pub(crate) at: [f64; 2],
}

/// The board in an image.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sighting {
    /// Corners of the board, ascending by their index.
    pub(crate) seen: Vec<Seen>,
    /// Markers that agree with the board.
    pub(crate) markers: usize,
}

/// Saddle points of an image and the cells between them.
pub(crate) struct Parts {
    pub(super) image: Gray,
    saddles: Vec<Saddle>,
    pub(super) cells: Vec<Cell>,
}

impl Parts {
    pub(crate) fn of(image: Gray) -> Result<Self, Error> {
        let saddles = saddles(&image)?;
        let cells = cells(&saddles);
        Ok(Self { image, saddles, cells })
    }

    /// The board among these parts; empty if it is not there.
    pub(crate) fn find(&self, board: &Board) -> Sighting {
        let dark = board.settings.pattern == BoardPattern::AprilGrid;
        let decoded = decode(
            &self.image,
            &self.cells,
            dark,
            board.marker_share(),
            &board.dictionary,
            board.markers.len(),
        );
        // Programs differ in which corner of a tag is its first.
        let turns = if dark { 0..4 } else { 0..1 };
        let best = turns
            .filter_map(|turn| self.agreeing(board, &decoded, turn))
            .max_by_key(|agreeing| agreeing.len());
        // Where most markers lie otherwise, it is another board.
        let exact = decoded.iter().filter(|d| d.found.wrong == 0).count();
        match best {
            Some(agreeing) if 2 * agreeing.len() > exact => {
                Sighting { seen: self.grown(board, &agreeing), markers: agreeing.len() }
            }
            _ => Sighting::default(),
        }
    }

    /// The largest set of markers that lie on one plane as on the board.
    fn agreeing(&self, board: &Board, decoded: &[Decoded], turn: usize) -> Option<Vec<Placed>> {
        let placed: Vec<Placed> =
            decoded.iter().filter_map(|d| self.placed(board, d, turn)).collect();
        let mut best: Vec<usize> = Vec::new();
        for seed in &placed {
            let Some(plane) = Homography::of(&seed.from, &seed.to) else { continue };
            let mut agrees = self.near(&placed, &plane);
            // Again with the plane of all that agree, which reaches further.
            for _ in 0..3 {
                let (from, to) = points(agrees.iter().map(|i| &placed[*i]));
                let Some(plane) = Homography::of(&from, &to) else { break };
                let wider = self.near(&placed, &plane);
                if wider.len() <= agrees.len() {
                    break;
                }
                agrees = wider;
            }
            if agrees.len() > best.len() {
                best = agrees;
            }
        }
        (best.len() >= MIN_MARKERS).then(|| best.iter().map(|i| placed[*i].clone()).collect())
    }

    /// A marker with the corners of its cell, on the board and in the image.
    fn placed(&self, board: &Board, decoded: &Decoded, turn: usize) -> Option<Placed> {
        let marker = board.markers.get(decoded.found.id)?;
        let cell = self.cells[decoded.cell];
        let first = decoded.found.turn + turn;
        let turned = |k: usize| (first + k) % 4;
        Some(Placed {
            id: decoded.found.id,
            corners: marker.cell,
            saddles: std::array::from_fn(|k| cell.corners[turned(k)]),
            from: marker.corners,
            to: std::array::from_fn(|k| cell.at[turned(k)]),
        })
    }

    /// Markers all of whose corners appear where a plane has them, each id once.
    fn near(&self, placed: &[Placed], plane: &Homography) -> Vec<usize> {
        let mut found: Vec<usize> = Vec::new();
        for (index, p) in placed.iter().enumerate() {
            let tolerance = 0.35 * p.side();
            let fits =
                p.from.iter().zip(&p.to).all(|(from, to)| {
                    plane.apply(*from).is_some_and(|at| apart(at, *to) < tolerance)
                });
            if fits && !found.iter().any(|other| placed[*other].id == p.id) {
                found.push(index);
            }
        }
        found
    }

    /// The corners of markers, and those that are found from them.
    fn grown(&self, board: &Board, agreeing: &[Placed]) -> Vec<Seen> {
        let mut at: Vec<Option<[f64; 2]>> = vec![None; board.corners.len()];
        let mut taken = vec![false; self.saddles.len()];
        for placed in agreeing {
            let pairs = placed.corners.iter().zip(placed.saddles);
            for (corner, saddle) in pairs.filter_map(|(corner, saddle)| (*corner).zip(saddle)) {
                if at[corner].is_none() && !taken[saddle] {
                    (at[corner], taken[saddle]) = (Some(self.saddles[saddle].at), true);
                }
            }
        }
        loop {
            let known: Vec<Known> = board
                .corners
                .iter()
                .zip(&at)
                .filter_map(|(place, at)| Some(Known { place: *place, at: (*at)? }))
                .collect();
            let mut grown = false;
            for (corner, at) in at.iter_mut().enumerate().filter(|(_, at)| at.is_none()) {
                if let Some(saddle) = self.snapped(board, &known, corner, &taken) {
                    (*at, taken[saddle]) = (Some(self.saddles[saddle].at), true);
                    grown = true;
                }
            }
            if !grown {
                break;
            }
        }
        let seen = at.iter().enumerate();
        seen.filter_map(|(corner, at)| Some(Seen { corner, at: (*at)? })).collect()
    }

    /// The saddle point where a corner must appear, given those that are known.
    fn snapped(
        &self,
        board: &Board,
        known: &[Known],
        corner: usize,
        taken: &[bool],
    ) -> Option<usize> {
        let wanted = board.corners[corner];
        // Far from all that is known, a prediction is a guess.
        let reach = 2.3 * board.settings.square_m;
        let near = known.iter().filter(|k| apart(k.place, wanted) < reach).count();
        if near < 2 || known.len() < 4 {
            return None;
        }
        let mut known = known.to_vec();
        known.sort_by(|a, b| apart(a.place, wanted).total_cmp(&apart(b.place, wanted)));
        known.truncate(NEAREST);
        let from: Vec<[f64; 2]> = known.iter().map(|k| k.place).collect();
        let to: Vec<[f64; 2]> = known.iter().map(|k| k.at).collect();
        let plane = Homography::of(&from, &to)?;
        let predicted = plane.apply(wanted)?;
        let beside = plane.apply([wanted[0] + board.settings.marker_m, wanted[1]])?;
        let tolerance = (SNAP * apart(predicted, beside)).max(1.0);
        let (distance, saddle) = self
            .saddles
            .iter()
            .enumerate()
            .filter(|(index, _)| !taken[*index])
            .map(|(index, saddle)| (apart(saddle.at, predicted), index))
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        (distance < tolerance).then_some(saddle)
    }
}

/// A corner that was found, on the board [m] and in the image [px].
#[derive(Clone, Copy, Debug)]
struct Known {
    place: [f64; 2],
    at: [f64; 2],
}

#[derive(Clone, Debug)]
struct Placed {
    id: usize,
    /// Corners of its cell that are measured, and saddle points there; `None` at the rim.
    corners: [Option<usize>; 4],
    saddles: [Option<usize>; 4],
    /// The cell's corners on the board [m].
    from: [[f64; 2]; 4],
    /// The same in the image [px].
    to: [[f64; 2]; 4],
}

impl Placed {
    /// Mean side of the cell [px].
    fn side(&self) -> f64 {
        (0..4).map(|k| apart(self.to[k], self.to[(k + 1) % 4])).sum::<f64>() / 4.0
    }
}

fn points<'a>(placed: impl Iterator<Item = &'a Placed>) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    let (mut from, mut to) = (Vec::new(), Vec::new());
    for p in placed {
        from.extend(p.from);
        to.extend(p.to);
    }
    (from, to)
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
