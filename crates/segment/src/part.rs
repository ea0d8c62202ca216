//! The three parts that a pixel may show, and their shares where it is not certain.

use bendtwin_capture::raw::Region;
use bendtwin_core::settings::ingest::Part;

/// Number of parts.
pub(crate) const PARTS: usize = 3;
/// Index of what is neither object nor hand, of the object, and of the hands.
pub(crate) const BACKGROUND: usize = 0;
pub(crate) const OBJECT: usize = 1;
pub(crate) const HAND: usize = 2;

/// Shares of the parts, whose sum is 1; or their logarithms up to a constant.
pub(crate) type Shares = [f32; PARTS];

/// Every part equally likely.
pub(crate) const UNKNOWN: Shares = [1.0 / 3.0; PARTS];

/// Index of a stroke's part.
pub(crate) fn index(part: Part) -> usize {
    match part {
        Part::Background => BACKGROUND,
        Part::Object => OBJECT,
        Part::Hand => HAND,
    }
}

/// Only this part.
pub(crate) fn only(part: usize) -> Shares {
    std::array::from_fn(|k| if k == part { 1.0 } else { 0.0 })
}

/// The likeliest part.
pub(crate) fn likeliest(shares: &Shares) -> usize {
    (1..PARTS).fold(0, |best, k| if shares[k] > shares[best] { k } else { best })
}

/// What a mask shows where a part is.
pub(crate) fn region(part: usize) -> Option<Region> {
    match part {
        OBJECT => Some(Region::Object),
        HAND => Some(Region::Manipulator),
        _ => None,
    }
}

/// Shares from logarithms up to a constant.
pub(crate) fn shares(logs: Shares) -> Shares {
    let most = logs.iter().copied().fold(f32::MIN, f32::max);
    let all = logs.map(|l| (l - most).exp());
    let sum: f32 = all.iter().sum();
    all.map(|x| x / sum)
}

/// How far shares are from telling nothing, 0..=1.
pub(crate) fn certainty(shares: &Shares) -> f32 {
    let most = shares.iter().copied().fold(0.0, f32::max);
    (1.5 * most - 0.5).clamp(0.0, 1.0)
}
