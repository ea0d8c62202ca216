//! Why a board is not seen, and what to do: what else is in the images is tried, from another
//! dictionary to a mirrored image.

use bendtwin_capture::raw::Recording;
use bendtwin_core::{
    CancelToken, Finding, Severity,
    settings::ingest::{BoardPattern, BoardSettings},
};

use super::{
    GUIDE,
    corners::Gray,
    decode::decode,
    dictionary::Dictionary,
    join::Apart,
    label::{MIN_MARKERS, Parts},
    layout::Board,
    named,
    spec::text,
    views::{Views, spread},
};
use crate::{Error, error::check};

/// Frames of a camera in which other boards are looked for.
const FRAMES: usize = 4;
/// Markers of another dictionary that have to be there before it is named.
const MIN_OTHERS: usize = 4;

/// The finding about cameras that do not see the board.
pub(super) fn not_seen(
    recording: &Recording,
    board: &Board,
    views: &Views,
    unseen: &[usize],
    cancel: &CancelToken,
) -> Result<Finding, Error> {
    let usable = recording.usable();
    let mut guess = None;
    for camera in unseen {
        let mut frames = usable.source.frames(*camera)?;
        for frame in spread(recording.frame_count, FRAMES) {
            check(cancel)?;
            let Some(color) = frames.color(frame)? else { continue };
            let gray = Gray::of(&color);
            guess = other(&gray, board)?;
            if guess.is_some() {
                break;
            }
        }
        if guess.is_some() {
            break;
        }
    }
    let seen: Vec<String> = (0..recording.cameras.len())
        .map(|c| format!("{} in {}", named(recording, c), views.count(c)))
        .collect();
    let what = format!(
        "the board is not seen by all cameras: of {} frames {}",
        views.frames.len(),
        seen.join(", ")
    );
    let (what, advice) = match guess {
        Some((found, advice)) => (format!("{what}; {found}"), advice),
        None => (
            what,
            "lay the board flat, sharp and lit where all cameras see it, and check its description"
                .to_owned(),
        ),
    };
    let finding = Finding {
        advice: format!("{advice} ({GUIDE})"),
        ..Finding::new(Severity::Error, "BOARD_NOT_SEEN", what)
    };
    Ok(finding.cameras(unseen.iter().copied()))
}

/// The finding about cameras that saw the board, but not together with the others.
pub(super) fn apart(recording: &Recording, apart: &Apart) -> Finding {
    let cameras: Vec<String> = apart.cameras.iter().map(|c| named(recording, *c)).collect();
    let cameras = cameras.join(", ");
    let (code, message) = if apart.at_other_times {
        (
            "BOARD_APART",
            format!(
                "{cameras} never see the board where the other cameras see it: lay it down for a second where all see it, \
                 or in places that each two cameras share ({GUIDE})"
            ),
        )
    } else {
        (
            "BOARD_FEW_CORNERS",
            format!(
                "{cameras} see too few corners of the board for a pose: move the board nearer or turn it towards them \
                 ({GUIDE})"
            ),
        )
    };
    Finding::from_sentence(Severity::Error, code, message).cameras(apart.cameras.iter().copied())
}

/// What else an image shows, and the advice that follows from it.
fn other(gray: &Gray, board: &Board) -> Result<Option<(String, String)>, Error> {
    let parts = Parts::of(gray.clone())?;
    let stated = &board.settings;
    for (found, settings) in variants(stated) {
        if let Ok(variant) = Board::new(&settings)
            && parts.find(&variant).markers >= MIN_MARKERS.max(3)
        {
            return Ok(Some((found, format!("give it as `--board {}`", text(&settings)))));
        }
    }
    if Parts::of(gray.mirrored())?.find(board).markers >= MIN_MARKERS {
        let found = "its images are mirrored".to_owned();
        return Ok(Some((found, "turn mirroring off where they are recorded".to_owned())));
    }
    Ok(another_dictionary(&parts, board))
}

/// Boards that are easily meant by the same words.
fn variants(stated: &BoardSettings) -> Vec<(String, BoardSettings)> {
    let mut variants = Vec::new();
    let charuco = stated.pattern == BoardPattern::Charuco;
    if charuco {
        let legacy = BoardSettings { legacy: !stated.legacy, ..stated.clone() };
        let which = if stated.legacy { "since" } else { "before" };
        variants.push((format!("it is laid out as OpenCV did {which} version 4.6"), legacy));
    }
    let turned = BoardSettings { columns: stated.rows, rows: stated.columns, ..stated.clone() };
    variants.push(("its columns and rows are exchanged".to_owned(), turned));
    for columns in (2..=24).filter(|columns| *columns != stated.columns) {
        // Rows do not matter to the numbers of markers, but there have to be enough of them.
        let found = format!("its markers are those of a board of {columns} columns");
        let kind = |rows: u32| BoardSettings { columns, rows, ..stated.clone() };
        let fits = |rows: &u32| Board::new(&kind(*rows)).is_ok();
        if let Some(rows) = (2..=24).rev().find(fits) {
            let settings = kind(rows);
            variants.push((found, settings));
        }
    }
    variants
}

/// Markers of a dictionary that was not named.
fn another_dictionary(parts: &Parts, board: &Board) -> Option<(String, String)> {
    let mut best: Option<(usize, Dictionary, usize)> = None;
    // The largest of a kind comes last, and has the codes of the others.
    for dictionary in Dictionary::all() {
        for (dark, share) in [(false, board.marker_share()), (false, 0.75), (true, 1.0)] {
            let (count, largest) = parts.exact(&dictionary, dark, share);
            // The smallest dictionary that has all that were read.
            if best.as_ref().is_none_or(|(most, _, _)| count > *most) {
                best = Some((count, dictionary.clone(), largest));
            }
        }
    }
    let (count, dictionary, _) = best.filter(|(count, _, _)| *count >= MIN_OTHERS)?;
    if dictionary.name() == board.dictionary.name() {
        let found = format!("{count} markers of this dictionary are there, in another arrangement");
        return Some((found, "check the board's columns and rows".to_owned()));
    }
    let found = format!("markers of {} are there", dictionary.name());
    let settings =
        BoardSettings { dictionary: dictionary.name().to_owned(), ..board.settings.clone() };
    Some((found, format!("give it as `--board {}`", text(&settings))))
}

impl Parts {
    /// Number of different markers of a dictionary that are read without a wrong module, and the
    /// largest id.
    fn exact(&self, dictionary: &Dictionary, dark: bool, share: f64) -> (usize, usize) {
        let decoded = decode(&self.image, &self.cells, dark, share, dictionary, dictionary.len());
        let ids: std::collections::BTreeSet<usize> =
            decoded.iter().filter(|d| d.found.wrong == 0).map(|d| d.found.id).collect();
        (ids.len(), ids.last().copied().unwrap_or_default())
    }
}
