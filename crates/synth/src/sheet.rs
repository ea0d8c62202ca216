//! A printed sheet in front of cameras, a board for calibrating for example: perspective, lens, light
//! from one side, blur and noise.

mod film;

use bendtwin_capture::raw::{Camera, Pose};

pub use self::film::film_sheet;

/// What is printed on a sheet of white paper.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Width and height of the print [m]; half a tenth of its width stays white around it.
    pub size_m: [f64; 2],
    /// Columns of the print.
    pub columns: usize,
    /// `true` where it is black, shape [rows, columns], the first row above.
    pub black: Vec<bool>,
}

/// Options of filming a sheet.
#[derive(Clone, Debug)]
pub struct SheetFilm {
    /// Seed of noise; the same seed gives the same recording.
    pub seed: u64,
    /// The sheet.
    pub sheet: Sheet,
    /// From the sheet to the world in each frame, x to the right, y up, z out of the print, the origin
    /// in its middle; `None` where it is not there.
    pub places: Vec<Option<Pose>>,
    /// The cameras, with the poses that they have.
    pub cameras: Vec<Camera>,
    /// Height of the table, on which the sheet need not lie [m].
    pub table_m: f64,
    /// Deviation of the blur [px].
    pub blur_px: f64,
    /// Deviation of noise, of 255.
    pub noise: f64,
    /// Factor of depth.
    pub depth_scale: f64,
}

impl Sheet {
    /// `true` where the sheet is black; `None` beside it.
    pub fn at(&self, [x, y]: [f64; 2]) -> Option<bool> {
        let [width, height] = self.size_m;
        let margin = 0.05 * width;
        let (across, down) = (x + width / 2.0, height / 2.0 - y);
        let on = |v: f64, size: f64| (-margin..size + margin).contains(&v);
        if !on(across, width) || !on(down, height) {
            return None;
        }
        let rows = self.black.len() / self.columns.max(1);
        let cell = |v: f64, size: f64, count: usize| {
            let index = (v / size * count as f64).floor();
            (index >= 0.0 && index < count as f64).then_some(index as usize)
        };
        let printed = cell(across, width, self.columns).zip(cell(down, height, rows));
        Some(printed.is_some_and(|(column, row)| self.black[row * self.columns + column]))
    }
}

impl SheetFilm {
    /// A sheet that lies still at the origin, filmed by cameras without calibration errors.
    pub fn still(sheet: Sheet, cameras: Vec<Camera>, frames: usize) -> Self {
        Self {
            seed: 1,
            sheet,
            places: vec![Some(Pose::IDENTITY); frames],
            cameras,
            table_m: -0.001,
            blur_px: 0.7,
            noise: 3.0,
            depth_scale: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_is_white_around_its_print_and_nothing_beyond() {
        let sheet = Sheet { size_m: [0.2, 0.1], columns: 2, black: vec![true, false] };
        assert_eq!(sheet.at([-0.05, 0.0]), Some(true));
        assert_eq!(sheet.at([0.05, 0.0]), Some(false));
        assert_eq!(sheet.at([-0.105, 0.0]), Some(false));
        assert_eq!(sheet.at([-0.12, 0.0]), None);
    }
}
