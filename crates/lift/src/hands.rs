//! From tracks on hands or grippers to control points: tracks are grouped into hands, each hand's
//! motion is fitted as that of a rigid body, and its control points, which lie where it meets the
//! object, move with it.

mod body;
pub(crate) mod cloud;
mod cluster;
pub(crate) mod contact;
pub(crate) mod gripper;

use bendtwin_core::{Finding, Severity};
use bendtwin_core::{Point, settings::ingest::ControlSettings};
use bendtwin_near::PointTree;

use self::{
    body::Body,
    cluster::clusters,
    contact::{Contact, holding},
};
use crate::{Error, evidence::HandEvidence, tracks::Tracks};

/// Least tracks of a hand: three span a pose, and one more shows whether they agree.
pub(crate) const MIN_TRACKS: usize = 4;
/// Most tracks of hands that are used, the longest ones; more do not make a pose better.
const MAX_TRACKS: usize = 600;

/// Control points of all hands.
pub(crate) struct Controls {
    /// Positions [m], shape [T, C, 3], those of one hand beside each other.
    pub(crate) points: Vec<Point>,
    pub(crate) hands: Vec<HandEvidence>,
    /// Longest gap in which a hand's motion is not known [frames].
    pub(crate) longest_gap: usize,
    pub(crate) findings: Vec<Finding>,
}

/// Control points from the tracks on all hands.
pub(crate) fn controls(
    tracks: &Tracks,
    contact: &Contact,
    settings: &ControlSettings,
) -> Result<Controls, Error> {
    let survival = tracks.survival();
    let mut longest: Vec<usize> = (0..tracks.count).collect();
    longest.sort_by_key(|i| (std::cmp::Reverse(survival[*i]), *i));
    longest.truncate(MAX_TRACKS);
    longest.sort_unstable();
    let tracks = &tracks.select(&longest);

    let mut groups = clusters(tracks, settings);
    let largest = groups.first().map_or(0, Vec::len);
    groups.retain(|g| g.len() >= MIN_TRACKS && 10 * g.len() >= largest);
    let mut findings = Vec::new();
    if groups.len() > settings.max_hands as usize {
        findings.push(warning(
            "TOO_MANY_HANDS",
            format!(
                "the tracks on hands fall into {} groups, the {} largest are used: check the hand's masks, or set \
                 controls.max_hands",
                groups.len(),
                settings.max_hands
            ),
        ));
        groups.truncate(settings.max_hands as usize);
    }
    if groups.is_empty() {
        return Err(Error::NoHandTracks { tracks: largest, needed: MIN_TRACKS });
    }
    let mut columns = Vec::new();
    let (mut hands, mut longest_gap) = (Vec::new(), 0);
    for (hand, group) in groups.iter().enumerate() {
        let wanted = dealt(settings, hand, groups.len());
        let tracks = tracks.select(group);
        let Some(body) = Body::fit(&tracks, settings) else {
            return Err(Error::NoHandTracks { tracks: group.len(), needed: MIN_TRACKS });
        };
        longest_gap = longest_gap.max(body.longest_gap());
        findings.extend(long_gap(hand, body.longest_gap(), settings));
        let mut chosen = body.surviving();
        let surviving = chosen.len();
        if surviving < MIN_TRACKS.min(wanted) {
            findings.push(warning(
                "HAND_BARELY_TRACKED",
                format!(
                    "only {surviving} tracks on hand {hand} are seen in every frame: its control points follow the \
                     motion of all {} tracks on it",
                    group.len()
                ),
            ));
            chosen = body.rigid_tracks();
        }
        let mut starts: Vec<Point> = chosen.iter().map(|i| body.start(*i)).collect();
        // On a rigid hand any place moves as the tracks do.
        if body.is_rigid() {
            let surface = PointTree::new(starts.iter().copied());
            let near = |p: &&Point| surface.any_within(**p, settings.hand_gap_m / 2.0);
            starts.extend(contact.hands.iter().filter(near));
        }
        let (picked, distances_m) = contact.choose(&starts, wanted);
        if !body.is_rigid() {
            findings.push(Finding::from_sentence(
                Severity::Info,
                "HAND_NOT_RIGID",
                format!(
                    "tracks on hand {hand} are {:.1} mm from a rigid motion in the median (limit {:.1}): it opens or \
                     closes, and its control points move each on its own",
                    1e3 * body.residual_m(),
                    1e3 * settings.rigid_m
                ),
            ));
        }
        hands.push(HandEvidence {
            tracks: group.len(),
            surviving,
            controls: picked.len(),
            holding: holding(&distances_m),
            ..body.evidence()
        });
        columns.extend(picked.into_iter().map(|i| match chosen.get(i) {
            Some(track) => body.trajectory(*track),
            None => body.carried(starts[i]),
        }));
    }
    let points = by_frame(&columns, tracks.frames);
    Ok(Controls { points, hands, longest_gap, findings })
}

/// Control points of one hand of `hands`: the first hands get what cannot be dealt out evenly.
fn dealt(settings: &ControlSettings, hand: usize, hands: usize) -> usize {
    let all = settings.count as usize;
    all / hands + usize::from(hand < all % hands)
}

/// Positions frame by frame, shape [T, C, 3], of control points over time, shape [C][T].
fn by_frame(columns: &[Vec<Point>], frames: usize) -> Vec<Point> {
    (0..frames).flat_map(|f| columns.iter().map(move |c| c[f])).collect()
}

/// Finding of a hand that masks show, but that cannot be followed for longer than gaps are filled.
fn long_gap(hand: usize, frames: usize, settings: &ControlSettings) -> Option<Finding> {
    (frames > settings.max_gap_frames as usize).then(|| {
        warning(
            "HAND_BARELY_TRACKED",
            format!(
                "hand {hand} is not recognised in {frames} successive frames although masks show it: its motion there is \
                 filled in from before and after; tracks on the hand would show it"
            ),
        )
    })
}

fn warning(code: &str, message: String) -> Finding {
    Finding::from_sentence(Severity::Warning, code, message)
}

#[cfg(test)]
mod tests;
