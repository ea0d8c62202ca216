//! The marker in a cell: its modules are read through the homography of the cell's corners.

use super::{
    cells::Cell,
    corners::Gray,
    dictionary::{Dictionary, Found},
    homography::Homography,
};
use crate::statistics::median;

/// Least difference of brightness between black and white, of 255.
const MIN_CONTRAST: f64 = 20.0;
/// Share of a border's modules that must be black.
const MIN_BORDER: f64 = 0.85;
/// Places to each side at which a module is read, in modules from its middle.
const PLACES: [f64; 3] = [-0.22, 0.0, 0.22];

/// Widths of black borders, in modules: OpenCV's and AprilTag's, and Kalibr's.
const BORDERS: [usize; 2] = [1, 2];

/// Row and column of a module in a cell, given those in the marker and the last of them.
type Place = fn(usize, usize, usize) -> (usize, usize);

/// Modules of a cell as black and white, in the four turns.
pub(crate) struct Read {
    turns: [u64; 4],
}

/// A marker that was recognised in a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decoded {
    /// Index into the cells.
    pub(crate) cell: usize,
    /// The marker. Turn k: the marker's upper left lies at the cell's corner k.
    pub(crate) found: Found,
}

/// Reads the markers of all cells.
pub(crate) fn decode(
    image: &Gray,
    cells: &[Cell],
    dark: bool,
    marker_share: f64,
    dictionary: &Dictionary,
    count: usize,
) -> Vec<Decoded> {
    // A wrong module in four still leaves a marker that is no other; more where codes are far apart.
    let most = match dictionary.side() {
        4 => 0,
        5 => 1,
        _ => 3,
    };
    let borders = if dark { &BORDERS[..] } else { &BORDERS[..1] };
    let mut decoded = Vec::new();
    for (index, cell) in cells.iter().enumerate().filter(|(_, cell)| cell.dark == dark) {
        let found = borders
            .iter()
            .filter_map(|border| read(image, cell.at, marker_share, dictionary.side(), *border))
            .filter_map(|read| dictionary.find(&read.turns, count, most))
            .min_by_key(|found| found.wrong);
        decoded.extend(found.map(|found| Decoded { cell: index, found }));
    }
    decoded
}

/// Reads the modules of a marker in the middle of a cell; `None` if that shows no black border.
pub(crate) fn read(
    image: &Gray,
    corners: [[f64; 2]; 4],
    share: f64,
    side: usize,
    border: usize,
) -> Option<Read> {
    let unit = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let plane = Homography::of(&unit, &corners)?;
    let modules = side + 2 * border;
    let margin = (1.0 - share) / 2.0;
    let place = |module: f64| margin + share * module / modules as f64;
    let mut values = vec![0.0; modules * modules];
    for (number, value) in values.iter_mut().enumerate() {
        let (row, column) = (number / modules, number % modules);
        for (dy, dx) in PLACES.iter().flat_map(|dy| PLACES.iter().map(move |dx| (dy, dx))) {
            let at = [place(column as f64 + 0.5 + dx), place(row as f64 + 0.5 + dy)];
            *value += image.at(plane.apply(at)?)? / 9.0;
        }
    }
    let is_border = |number: &usize| {
        let (row, column) = (number / modules, number % modules);
        let inside = border..border + side;
        !inside.contains(&row) || !inside.contains(&column)
    };
    let rim: Vec<f64> = (0..values.len()).filter(is_border).map(|n| values[n]).collect();
    let black = median(rim.iter().copied())?;
    let white = values.iter().copied().fold(black, f64::max);
    if white - black < MIN_CONTRAST {
        return None;
    }
    let threshold = (white + black) / 2.0;
    let dark = rim.iter().filter(|value| **value < threshold).count();
    if (dark as f64) < MIN_BORDER * rim.len() as f64 {
        return None;
    }
    let is_white =
        |row: usize, column: usize| values[(row + border) * modules + column + border] > threshold;
    let last = side - 1;
    // Row and column in the cell of a module of the marker whose upper left is corner 0, 1, 2, 3.
    let places: [Place; 4] = [
        |row, column, _| (row, column),
        |row, column, last| (column, last - row),
        |row, column, last| (last - row, last - column),
        |row, column, last| (last - column, row),
    ];
    let turns = places.map(|place| {
        let modules = (0..side * side).map(|n| place(n / side, n % side, last));
        modules.fold(0, |code, (row, column)| code << 1 | u64::from(is_white(row, column)))
    });
    Some(Read { turns })
}
