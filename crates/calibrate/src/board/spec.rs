//! A board in one line, as people type it: `charuco:7x5:30mm:22mm:DICT_5X5_100`.

use bendtwin_core::settings::ingest::{
    BoardPattern, BoardSettings, CalibrationSettings, IngestSettings,
};

/// The forms of a board's description.
pub const FORMS: &str = "charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY[:legacy], as charuco:7x5:30mm:22mm:DICT_5X5_100, or \
                         apriltag:COLUMNSxROWS:TAG:GAP[:DICTIONARY], as apriltag:6x6:22mm:6.6mm, where GAP may be a share of \
                         the tag (Kalibr's tagSpacing)";

/// Reads a board's description.
///
/// # Errors
/// The fault, with what to write instead.
pub fn parse(text: &str) -> Result<BoardSettings, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let (pattern, rest) = parts.split_first().ok_or(FORMS)?;
    let board = match (pattern.to_ascii_lowercase().as_str(), rest) {
        ("charuco", [size, square, marker, dictionary, end @ ..]) => {
            let legacy = match end {
                [] => false,
                [word] if word.eq_ignore_ascii_case("legacy") => true,
                _ => return Err(format!("`{}` follows the dictionary: {FORMS}", end.join(":"))),
            };
            let [columns, rows] = counts(size)?;
            BoardSettings {
                pattern: BoardPattern::Charuco,
                columns,
                rows,
                square_m: length(square)?,
                marker_m: length(marker)?,
                dictionary: (*dictionary).to_owned(),
                legacy,
            }
        }
        ("apriltag" | "aprilgrid", [size, tag, gap, end @ ..]) if end.len() < 2 => {
            let [columns, rows] = counts(size)?;
            let marker_m = length(tag)?;
            let gap = match gap.parse::<f64>() {
                Ok(share) if share > 0.0 && share < 1.0 => share * marker_m,
                _ => length(gap)?,
            };
            BoardSettings {
                pattern: BoardPattern::AprilGrid,
                columns,
                rows,
                square_m: marker_m + gap,
                marker_m,
                dictionary: end.first().unwrap_or(&"tag36h11").to_string(),
                legacy: false,
            }
        }
        _ => return Err(format!("a board is {FORMS}")),
    };
    let settings = IngestSettings {
        calibration: CalibrationSettings { board: Some(board.clone()), ..Default::default() },
        ..IngestSettings::default()
    };
    settings.validate().map_err(|faults| faults.join("; "))?;
    super::Board::new(&board).map_err(|error| error.to_string())?;
    Ok(board)
}

/// The description of a board.
pub fn text(board: &BoardSettings) -> String {
    let mm = |metres: f64| format!("{}mm", (metres * 1e6).round() / 1e3);
    let (pattern, sizes) = match board.pattern {
        BoardPattern::Charuco => ("charuco", [mm(board.square_m), mm(board.marker_m)]),
        BoardPattern::AprilGrid => {
            ("apriltag", [mm(board.marker_m), mm(board.square_m - board.marker_m)])
        }
    };
    let legacy = if board.legacy { ":legacy" } else { "" };
    let [first, second] = sizes;
    format!(
        "{pattern}:{}x{}:{first}:{second}:{}{legacy}",
        board.columns, board.rows, board.dictionary
    )
}

fn counts(text: &str) -> Result<[u32; 2], String> {
    let counts = text.split_once(['x', 'X']).and_then(|(columns, rows)| {
        Some([columns.trim().parse().ok()?, rows.trim().parse().ok()?])
    });
    counts.ok_or_else(|| format!("`{text}` is no number of columns and rows, such as 7x5"))
}

/// A length with its unit [m].
fn length(text: &str) -> Result<f64, String> {
    let text = text.trim();
    // `mm` before `m`.
    for (unit, metres) in [("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254), ("m", 1.0)] {
        if let Some(number) = text.strip_suffix(unit)
            && let Ok(number) = number.trim().parse::<f64>()
        {
            return Ok(number * metres);
        }
    }
    Err(format!("`{text}` has no unit: write a length such as 30mm, 3cm or 0.03m"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boards_are_read_as_they_are_written() {
        for spec in ["charuco:7x5:30mm:22mm:DICT_5X5_100", "apriltag:6x6:22mm:6.6mm:tag36h11"] {
            assert_eq!(text(&parse(spec).unwrap()), spec);
        }
        let legacy = parse("ChArUco:8x6:3cm:0.022m:DICT_5X5_100:legacy").unwrap();
        assert_eq!(text(&legacy), "charuco:8x6:30mm:22mm:DICT_5X5_100:legacy");
        let share = parse("apriltag:6x6:20mm:0.3").unwrap();
        assert!((share.square_m - 0.026).abs() < 1e-12);
        assert_eq!(share.dictionary, "tag36h11");
    }

    #[test]
    fn faults_say_what_to_write() {
        for (spec, fault) in [
            ("charuco:7x5:30:22:DICT_5X5_100", "`30` has no unit"),
            ("charuco:7x5:30m:22m:DICT_5X5_100", "must lie in"),
            ("charuco:7:30mm:22mm:DICT_5X5_100", "such as 7x5"),
            ("charuco:7x5:22mm:30mm:DICT_5X5_100", "less than square_m"),
            ("charuco:7x5:30mm:22mm:DICT_9X9_100", "no dictionary `DICT_9X9_100`"),
            ("charuco:20x20:30mm:22mm:DICT_4X4_50", "the board has 200 markers"),
            ("chessboard:7x5:30mm", "a board is charuco"),
            ("", "a board is charuco"),
        ] {
            let error = parse(spec).unwrap_err();
            assert!(error.contains(fault), "{spec}: {error}");
        }
    }
}
