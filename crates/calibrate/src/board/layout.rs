//! A printed board: places of its corners and markers.
//!
//! The board's axes are those of a person who reads it: x to the right, y up, z out of the paper, with
//! the origin in the middle.

use bendtwin_core::settings::ingest::{BoardPattern, BoardSettings};

use super::dictionary::Dictionary;
use crate::Error;

/// A board.
#[derive(Clone, Debug)]
pub struct Board {
    /// Description of the board.
    pub settings: BoardSettings,
    /// Dictionary of its markers.
    pub dictionary: Dictionary,
    /// Places of the corners that are measured [m].
    pub corners: Vec<[f64; 2]>,
    /// Markers by id.
    pub markers: Vec<Marker>,
}

/// A marker of a board, in a cell whose corners are measured.
#[derive(Clone, Debug)]
pub struct Marker {
    /// Lower left corner of its black border [m].
    pub origin: [f64; 2],
    /// Corners of the cell around the marker from the upper left clockwise [m].
    pub corners: [[f64; 2]; 4],
    /// Corners of the cell around the marker, a square of a chessboard or the tag itself: indices
    /// into the board's corners from the upper left clockwise; `None` at the rim of a chessboard.
    pub cell: [Option<usize>; 4],
}

impl Marker {
    fn places(&mut self) -> impl Iterator<Item = &mut [f64; 2]> {
        std::iter::once(&mut self.origin).chain(&mut self.corners)
    }
}

impl Board {
    /// The board of a description.
    ///
    /// # Errors
    /// If the dictionary is unknown or too small.
    pub fn new(settings: &BoardSettings) -> Result<Self, Error> {
        let Some(dictionary) = Dictionary::named(&settings.dictionary) else {
            let known = Dictionary::all().map(|d| d.name().to_owned()).collect::<Vec<_>>();
            return Err(Error::Board(format!(
                "there is no dictionary `{}`: it must be one of {}",
                settings.dictionary.chars().take(64).collect::<String>(),
                known.join(", ")
            )));
        };
        let mut board = match settings.pattern {
            BoardPattern::Charuco => Self::charuco(settings, dictionary),
            BoardPattern::AprilGrid => Self::grid(settings, dictionary),
        };
        let [width, height] = board.size_m();
        for at in board.corners.iter_mut().chain(board.markers.iter_mut().flat_map(Marker::places))
        {
            *at = [at[0] - width / 2.0, at[1] - height / 2.0];
        }
        if board.markers.len() > board.dictionary.len() {
            return Err(Error::Board(format!(
                "the board has {} markers, and {} has {}: check columns and rows, or name the larger dictionary",
                board.markers.len(),
                board.dictionary.name(),
                board.dictionary.len()
            )));
        }
        Ok(board)
    }

    /// Markers in the white squares, numbered row by row from the top; corners between four squares.
    fn charuco(settings: &BoardSettings, dictionary: Dictionary) -> Self {
        let (columns, rows) = (settings.columns as usize, settings.rows as usize);
        let side = settings.square_m;
        let inner = |column: usize, line: usize| {
            // Lines between rows, from the top.
            let inside = (1..columns).contains(&column) && (1..rows).contains(&line);
            inside.then(|| (line - 1) * (columns - 1) + column - 1)
        };
        let corners = (1..rows)
            .flat_map(|line| (1..columns).map(move |column| (line, column)))
            .map(|(line, column)| [column as f64 * side, (rows - line) as f64 * side])
            .collect();
        // The square at the upper left is black, unless an older OpenCV drew an even number of rows.
        let odd = usize::from(settings.legacy && rows.is_multiple_of(2));
        let margin = (side - settings.marker_m) / 2.0;
        let markers = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (row, column)))
            .filter(|(row, column)| (row + column + odd) % 2 == 1)
            .map(|(row, column)| Marker {
                origin: [column as f64 * side + margin, (rows - 1 - row) as f64 * side + margin],
                corners: [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(right, down)| {
                    [(column + right) as f64 * side, (rows - row - down) as f64 * side]
                }),
                cell: [
                    inner(column, row),
                    inner(column + 1, row),
                    inner(column + 1, row + 1),
                    inner(column, row + 1),
                ],
            })
            .collect();
        Self { settings: settings.clone(), dictionary, corners, markers }
    }

    /// Tags numbered row by row from the lower left, as Kalibr draws them, with small squares between
    /// their corners.
    fn grid(settings: &BoardSettings, dictionary: Dictionary) -> Self {
        let (columns, rows) = (settings.columns as usize, settings.rows as usize);
        let (pitch, side) = (settings.square_m, settings.marker_m);
        let (mut corners, mut markers) = (Vec::new(), Vec::new());
        for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            let gap = pitch - side;
            let [x, y] = [column as f64 * pitch + gap, row as f64 * pitch + gap];
            let first = corners.len();
            let own = [[x, y + side], [x + side, y + side], [x + side, y], [x, y]];
            corners.extend(own);
            let cell = std::array::from_fn(|k| Some(first + k));
            markers.push(Marker { origin: [x, y], corners: own, cell });
        }
        Self { settings: settings.clone(), dictionary, corners, markers }
    }

    /// Width and height of what is printed [m].
    pub fn size_m(&self) -> [f64; 2] {
        let s = &self.settings;
        let frame = match s.pattern {
            BoardPattern::Charuco => 0.0,
            BoardPattern::AprilGrid => s.square_m - s.marker_m,
        };
        [s.columns, s.rows].map(|n| f64::from(n) * s.square_m + frame)
    }

    /// What is printed as black dots, row by row from above, and their number in a row.
    pub fn printed(&self, dots_per_m: f64) -> (Vec<bool>, usize) {
        let [width, height] = self.size_m();
        let [columns, rows] = [width, height].map(|size| (size * dots_per_m).round() as usize);
        let dot = |n: usize| {
            let (row, column) = (n / columns, n % columns);
            let x = (column as f64 + 0.5) / columns as f64 * width - width / 2.0;
            let y = height / 2.0 - (row as f64 + 0.5) / rows as f64 * height;
            self.is_black([x, y])
        };
        ((0..columns * rows).map(dot).collect(), columns)
    }

    /// Share of a cell's side that its marker with border takes.
    pub(crate) fn marker_share(&self) -> f64 {
        match self.settings.pattern {
            BoardPattern::Charuco => self.settings.marker_m / self.settings.square_m,
            BoardPattern::AprilGrid => 1.0,
        }
    }

    /// `true` if what is printed is black at a place [m]; `None` outside of it, where paper is white.
    /// Borders of tags have two modules, as Kalibr prints them.
    pub fn is_black(&self, at: [f64; 2]) -> bool {
        let s = &self.settings;
        let [width, height] = self.size_m();
        let (x, y) = (at[0] + width / 2.0, at[1] + height / 2.0);
        if x < 0.0 || y < 0.0 || x >= width || y >= height {
            return false;
        }
        let border = match s.pattern {
            BoardPattern::Charuco => 1,
            BoardPattern::AprilGrid => 2,
        };
        let column = ((x / s.square_m) as usize).min(s.columns as usize);
        let up = ((y / s.square_m) as usize).min(s.rows as usize);
        let id = match s.pattern {
            BoardPattern::Charuco => {
                let row = s.rows as usize - 1 - up.min(s.rows as usize - 1);
                let odd = usize::from(s.legacy && s.rows.is_multiple_of(2));
                if (row + column + odd).is_multiple_of(2) {
                    return true;
                }
                // White squares before this one: in whole rows, and in this row.
                let columns = s.columns as usize;
                let of_row = |row: usize, count: usize| (count + (row + odd) % 2) / 2;
                (0..row).map(|row| of_row(row, columns)).sum::<usize>() + of_row(row, column)
            }
            BoardPattern::AprilGrid => {
                let gap = s.square_m - s.marker_m;
                let [in_gap_x, in_gap_y] =
                    [x - column as f64 * s.square_m < gap, y - up as f64 * s.square_m < gap];
                if in_gap_x || in_gap_y {
                    return in_gap_x && in_gap_y;
                }
                up * s.columns as usize + column
            }
        };
        let Some(marker) = self.markers.get(id) else { return false };
        let modules = self.dictionary.side() + 2 * border;
        let module = |at: f64, from: f64| {
            let share = (at - from) / s.marker_m;
            (0.0..1.0).contains(&share).then_some((share * modules as f64) as usize)
        };
        let (Some(across), Some(up)) =
            (module(at[0], marker.origin[0]), module(at[1], marker.origin[1]))
        else {
            return false;
        };
        let inside = border..border + self.dictionary.side();
        let down = modules - 1 - up;
        if !inside.contains(&across) || !inside.contains(&down) {
            return true;
        }
        let (row, column) = (down - border, across - border);
        match s.pattern {
            BoardPattern::Charuco => !self.dictionary.is_white(id, row, column),
            // Kalibr prints tags half a turn from OpenCV's.
            BoardPattern::AprilGrid => {
                let last = self.dictionary.side() - 1;
                !self.dictionary.is_white(id, last - row, last - column)
            }
        }
    }
}
