//! Dictionaries of markers as OpenCV names them, with the codes of their markers.
//!
//! `dictionaries.bin` has the codes of the largest dictionary of each kind, one after another, rows
//! from the top left, the first module in the highest bit, in as few bytes as a code needs. They are
//! those of OpenCV's `cv::aruco::getPredefinedDictionary` (Apache 2.0); smaller dictionaries of a
//! kind are the first codes of the largest.

const CODES: &[u8] = include_bytes!("dictionaries.bin");

/// A kind of markers: name without its number, modules to a side, number of codes, sizes of smaller
/// dictionaries.
struct Kind {
    name: &'static str,
    side: usize,
    count: usize,
    smaller: &'static [usize],
}

const KINDS: [Kind; 10] = [
    Kind { name: "DICT_4X4", side: 4, count: 1000, smaller: &[50, 100, 250, 1000] },
    Kind { name: "DICT_5X5", side: 5, count: 1000, smaller: &[50, 100, 250, 1000] },
    Kind { name: "DICT_6X6", side: 6, count: 1000, smaller: &[50, 100, 250, 1000] },
    Kind { name: "DICT_7X7", side: 7, count: 1000, smaller: &[50, 100, 250, 1000] },
    Kind { name: "DICT_ARUCO_ORIGINAL", side: 5, count: 1024, smaller: &[] },
    Kind { name: "DICT_ARUCO_MIP_36h12", side: 6, count: 250, smaller: &[] },
    Kind { name: "DICT_APRILTAG_16h5", side: 4, count: 30, smaller: &[] },
    Kind { name: "DICT_APRILTAG_25h9", side: 5, count: 35, smaller: &[] },
    Kind { name: "DICT_APRILTAG_36h10", side: 6, count: 2320, smaller: &[] },
    Kind { name: "DICT_APRILTAG_36h11", side: 6, count: 587, smaller: &[] },
];

/// A dictionary of markers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dictionary {
    name: String,
    side: usize,
    codes: Vec<u64>,
}

impl Dictionary {
    /// The dictionary of a name as OpenCV (`DICT_5X5_100`) or AprilTag (`tag36h11`) spells it, in any
    /// case.
    pub fn named(name: &str) -> Option<Self> {
        let wanted = name.trim().to_ascii_uppercase();
        let wanted = match wanted.strip_prefix("TAG") {
            Some(family) => format!("DICT_APRILTAG_{}", family.trim_start_matches('_')),
            None if wanted.starts_with("DICT_") => wanted,
            None => format!("DICT_{wanted}"),
        };
        Self::all().find(|dictionary| dictionary.name.to_ascii_uppercase() == wanted)
    }

    /// All dictionaries.
    pub fn all() -> impl Iterator<Item = Self> {
        let mut at = 0;
        KINDS.iter().flat_map(move |kind| {
            let bytes = (kind.side * kind.side).div_ceil(8);
            let all = CODES.get(at..at + kind.count * bytes).unwrap_or_default();
            at += kind.count * bytes;
            let codes: Vec<u64> = all
                .chunks_exact(bytes)
                .map(|code| code.iter().fold(0, |sum, byte| sum << 8 | u64::from(*byte)))
                .collect();
            let sizes = if kind.smaller.is_empty() { &[kind.count][..] } else { kind.smaller };
            let one = move |size: &usize| {
                let number =
                    if kind.smaller.is_empty() { String::new() } else { format!("_{size}") };
                Self {
                    name: format!("{}{number}", kind.name),
                    side: kind.side,
                    codes: codes[..*size.min(&codes.len())].to_vec(),
                }
            };
            sizes.iter().map(one).collect::<Vec<_>>()
        })
    }

    /// Name as OpenCV spells it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Modules to a side, without the border.
    pub fn side(&self) -> usize {
        self.side
    }

    /// Number of markers.
    pub fn len(&self) -> usize {
        self.codes.len()
    }

    /// `true` if it has no markers, which none is.
    pub fn is_empty(&self) -> bool {
        self.codes.is_empty()
    }

    /// `true` if the module at a row and column of a marker is white.
    pub fn is_white(&self, id: usize, row: usize, column: usize) -> bool {
        let bit = self.side * self.side - 1 - (row * self.side + column);
        self.codes.get(id).is_some_and(|code| code >> bit & 1 == 1)
    }

    /// The marker whose code differs from `code` in the fewest modules, at most `most`, and the
    /// quarter turn at which `turns` has it; only the first `count` markers are asked.
    pub(crate) fn find(&self, turns: &[u64; 4], count: usize, most: u32) -> Option<Found> {
        let mut best: Option<Found> = None;
        for (id, code) in self.codes.iter().enumerate().take(count) {
            for (turn, seen) in turns.iter().enumerate() {
                let wrong = (code ^ seen).count_ones();
                if wrong <= most && best.is_none_or(|b| wrong < b.wrong) {
                    best = Some(Found { id, turn, wrong });
                }
            }
        }
        best
    }
}

/// A marker that was recognised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) id: usize,
    /// Index into the codes that were asked.
    pub(crate) turn: usize,
    /// Modules that differ.
    pub(crate) wrong: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_opencv_and_of_apriltag() {
        for (name, full, side, count) in [
            ("DICT_5X5_100", "DICT_5X5_100", 5, 100),
            ("4x4_50", "DICT_4X4_50", 4, 50),
            ("tag36h11", "DICT_APRILTAG_36h11", 6, 587),
            ("DICT_APRILTAG_36H11", "DICT_APRILTAG_36h11", 6, 587),
            ("dict_aruco_original", "DICT_ARUCO_ORIGINAL", 5, 1024),
        ] {
            let dictionary = Dictionary::named(name).unwrap();
            assert_eq!(
                (dictionary.name(), dictionary.side(), dictionary.len()),
                (full, side, count)
            );
        }
        assert!(Dictionary::named("DICT_8X8_100").is_none());
        assert_eq!(Dictionary::all().count(), 22);
    }

    #[test]
    fn codes_are_those_that_opencv_draws() {
        // Rows of cv2.aruco.generateImageMarker(dictionary, 0, 6) without the border.
        let dictionary = Dictionary::named("DICT_4X4_50").unwrap();
        let row = |row: usize| -> String {
            let module = |column| if dictionary.is_white(0, row, column) { '#' } else { '.' };
            (0..4).map(module).collect()
        };
        assert_eq!([0, 1, 2, 3].map(row), ["#.##", ".#.#", "..##", "..#."]);
    }

    #[test]
    fn codes_of_a_dictionary_differ_in_every_turn() {
        for dictionary in Dictionary::all() {
            let bits = dictionary.side * dictionary.side;
            assert!(dictionary.codes.iter().all(|code| code >> bits == 0), "{}", dictionary.name);
            let mut sorted = dictionary.codes.clone();
            sorted.sort_unstable();
            sorted.dedup();
            assert_eq!(sorted.len(), dictionary.len(), "{}", dictionary.name);
        }
    }
}
