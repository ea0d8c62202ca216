//! Numbers in the names of images: which image belongs to which frame, for any spelling of names
//! and any first number.

use std::{collections::BTreeMap, ops::Range, sync::Arc};

use bendtwin_core::Finding;

use super::stored::Names;
use crate::{
    Error, Limits,
    files::{Files, at_most, other, shortened},
};

/// Extensions of colour images, the preferred first.
pub(super) const COLOR: &[&str] = &["png", "jpg", "jpeg"];
/// Extensions of depth images, the preferred first: a PNG beside an array is a picture of it.
pub(super) const DEPTH: &[&str] = &["npy", "png"];
/// Bytes of memory that a name takes beside its letters.
const NAME_BYTES: usize = 64;

/// Images of one kind by the numbers in their names.
#[derive(Clone, Debug, Default)]
pub(super) struct Images {
    /// Folder or pattern, for messages.
    at: String,
    by_number: BTreeMap<u64, String>,
}

/// Relation of numbers to frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Numbering {
    /// Number of frame 0.
    pub(super) first: u64,
    /// Number of frames T.
    pub(super) frame_count: usize,
}

impl Numbering {
    /// The finding that says that images are not numbered from 0.
    pub(super) fn note(self) -> Option<Finding> {
        let first = self.first;
        let message =
            format!("images are numbered from {first}, so that number {first} is frame 0");
        (first > 0).then(|| Finding::info("FRAMES_NUMBERED", message))
    }
}

impl Images {
    /// The images in a folder whose names have one of these extensions and a number.
    pub(super) fn in_folder(
        files: &mut Files<'_>,
        folder: &str,
        extensions: &[&str],
    ) -> Result<Self, Error> {
        let names = files.list(folder).files;
        Self::among(files, folder, &names, extensions)
    }

    /// The images among these names of a folder, that have one of these extensions and a number.
    pub(super) fn among(
        files: &mut Files<'_>,
        folder: &str,
        names: &[String],
        extensions: &[&str],
    ) -> Result<Self, Error> {
        let mut images = Self { at: folder.to_owned(), by_number: BTreeMap::new() };
        for extension in extensions {
            let mut of_this: BTreeMap<u64, &String> = BTreeMap::new();
            for name in names {
                let Some((stem, ending)) = name.rsplit_once('.') else { continue };
                if !ending.eq_ignore_ascii_case(extension) {
                    continue;
                }
                let Some(number) = number(stem) else { continue };
                if let Some(other) = of_this.insert(number, name) {
                    return Err(Error::FrameNumbers(format!(
                        "`{folder}` has two images of number {number}, `{other}` and `{name}`: \
                         keep one, and put images of different kinds into different folders"
                    )));
                }
            }
            for (number, name) in of_this {
                images.by_number.entry(number).or_insert_with(|| format!("{folder}/{name}"));
            }
        }
        images.charge(files)?;
        Ok(images)
    }

    /// The images whose names are `before`, a number, `after`. `None` if the number is that of a
    /// folder: such names are formed, not found.
    pub(super) fn of_pattern(
        files: &mut Files<'_>,
        before: &str,
        after: &str,
    ) -> Result<Option<Self>, Error> {
        if after.contains('/') {
            return Ok(None);
        }
        let (folder, prefix) = before.rsplit_once('/').unwrap_or(("", before));
        let mut images =
            Self { at: format!("{before}{{frame}}{after}"), by_number: BTreeMap::new() };
        for name in files.list(folder).files {
            let digits = name.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(after));
            let is_number = |d: &&str| !d.is_empty() && d.bytes().all(|b| b.is_ascii_digit());
            let Some(number) = digits.filter(is_number).and_then(|d| d.parse().ok()) else {
                continue;
            };
            let full = if folder.is_empty() { name } else { format!("{folder}/{name}") };
            if let Some(other) = images.by_number.insert(number, full.clone()) {
                return Err(Error::FrameNumbers(format!(
                    "`{other}` and `{full}` have the same number: keep one"
                )));
            }
        }
        images.charge(files)?;
        Ok(Some(images))
    }

    /// Charges the names: a description may ask for those of one folder many times.
    fn charge(&self, files: &mut Files<'_>) -> Result<(), Error> {
        let bytes: usize = self.by_number.values().map(|name| NAME_BYTES + name.len()).sum();
        files.budget.take(bytes as u64, "the names of images")
    }

    /// The finding for masks of a camera that are described, and not there.
    pub(super) fn note_missing(&self, files: &Files<'_>, camera: usize) -> Option<Finding> {
        if !self.is_empty() {
            return None;
        }
        let folder = self.at.rsplit_once('/').map_or("", |(folder, _)| folder);
        let message = format!("there are no masks `{}`, but {}", self.at, files.describe(folder));
        let advice = "correct the pattern, or leave it out".to_owned();
        let finding = Finding { advice, ..Finding::warning("MASKS_NOT_FOUND", message) };
        Some(finding.cameras([camera]))
    }

    /// Names in the order of their numbers.
    pub(super) fn in_order(&self) -> impl ExactSizeIterator<Item = &str> {
        self.by_number.values().map(String::as_str)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.by_number.is_empty()
    }

    /// `true` if there is an image of this number.
    pub(super) fn has(&self, number: u64) -> bool {
        self.by_number.contains_key(&number)
    }

    /// Frames from its first image to its last.
    pub(super) fn span(&self, numbering: Numbering) -> Option<Range<usize>> {
        let (first, last) = self.range()?;
        let frame = |number: u64| usize::try_from(number.checked_sub(numbering.first)?).ok();
        Some(frame(first)?..frame(last)?.saturating_add(1).min(numbering.frame_count))
    }

    /// First and last number.
    fn range(&self) -> Option<(u64, u64)> {
        Some((*self.by_number.first_key_value()?.0, *self.by_number.last_key_value()?.0))
    }

    fn has_gaps(&self) -> bool {
        self.range().is_some_and(|(first, last)| last - first >= self.by_number.len() as u64)
    }

    /// The names by frames.
    pub(super) fn names(self, numbering: Numbering) -> Names {
        let Numbering { first, frame_count } = numbering;
        let frame = |number: u64| {
            let frame = usize::try_from(number.checked_sub(first)?).ok()?;
            (frame < frame_count).then_some(frame)
        };
        let by_frame =
            self.by_number.into_iter().filter_map(|(number, name)| Some((frame(number)?, name)));
        Names::Found(Arc::new(by_frame.collect()))
    }

    /// `` `color/0` from 1 to 100 ``.
    fn numbered(&self) -> String {
        let (first, last) = self.range().unwrap_or_default();
        format!("`{}` from {first} to {last}", self.at)
    }

    /// `true` if its numbers are those of frames.
    fn is_within(&self, numbering: Numbering) -> bool {
        let end = numbering.first.saturating_add(numbering.frame_count as u64);
        self.range().is_none_or(|(first, last)| first >= numbering.first && last < end)
    }

    /// Refuses masks whose numbers are not those of a recording's frames.
    pub(super) fn expect_frames(&self, numbering: Numbering) -> Result<(), Error> {
        if self.is_within(numbering) {
            return Ok(());
        }
        Err(Error::FrameNumbers(format!(
            "masks are numbered beyond the recording, {}, which has {} frames: number masks by its frames",
            self.numbered(),
            numbering.frame_count
        )))
    }

    /// Refuses masks whose numbers are not those of the images.
    pub(super) fn expect_within(&self, numbering: Numbering, images: &Self) -> Result<(), Error> {
        if self.is_within(numbering) {
            return Ok(());
        }
        Err(Error::FrameNumbers(format!(
            "masks and images are numbered differently, {} and {}: give images of one moment the same number",
            self.numbered(),
            images.numbered(),
        )))
    }
}

/// The frame's number in a file's name: the digits at its end, or the only ones that it has.
pub(super) fn number(stem: &str) -> Option<u64> {
    // Times in seconds are no numbers of frames.
    if stem.contains('.') {
        return None;
    }
    let mut runs = stem.split(|c: char| !c.is_ascii_digit()).filter(|run| !run.is_empty());
    let run = if stem.ends_with(|c: char| c.is_ascii_digit()) {
        runs.next_back()
    } else {
        runs.next().filter(|_| runs.next().is_none())
    };
    run?.parse().ok()
}

/// Numbers of frames of images whose numbering agrees. A declared number of frames takes
/// precedence; `declared` is that number with the place where it stands.
pub(super) fn align(
    all: &[&Images],
    declared: Option<(&str, usize)>,
    limits: &Limits,
) -> Result<Numbering, Error> {
    let ranges = || all.iter().filter_map(|images| images.range());
    let (Some(low), Some(high)) = (ranges().map(|r| r.0).min(), ranges().map(|r| r.1).max()) else {
        return Ok(Numbering { first: 0, frame_count: declared.map_or(0, |(_, count)| count) });
    };
    let span = usize::try_from(high - low).unwrap_or(usize::MAX).saturating_add(1);
    let Some((at, count)) = declared else {
        let most = all.iter().map(|images| images.by_number.len()).max().unwrap_or(0);
        let shifted = all.iter().any(|a| a.range().is_some_and(|r| r.0 != low) && !a.has_gaps());
        if span > 2 * most + 10 || (span > most && shifted && all.iter().all(|a| !a.has_gaps())) {
            return Err(unlike(all, "the frames"));
        }
        at_most("frames of a recording", span, limits.recording_frames)?;
        return Ok(Numbering { first: low, frame_count: span });
    };
    let first = first_number(low, high, count);
    if first > 0 && span > count {
        return Err(unlike(all, &format!("{count} frames ({at})")));
    }
    Ok(Numbering { first, frame_count: count })
}

/// Numbers of images from the smallest to the largest, of cameras that count on their own.
pub(super) fn span(all: &[&Images], limits: &Limits) -> Result<Numbering, Error> {
    let ranges = || all.iter().filter_map(|images| images.range());
    let first = ranges().map(|r| r.0).min().unwrap_or(0);
    let last = ranges().map(|r| r.1).max().unwrap_or(0);
    let span = usize::try_from(last - first).unwrap_or(usize::MAX).saturating_add(1);
    at_most("frames of a recording", span, limits.recording_frames)?;
    Ok(Numbering { first, frame_count: span })
}

/// Refuses a number of frames that is not that of the images.
pub(super) fn expect_all(all: &[&Images], at: &str, count: usize) -> Result<(), Error> {
    let ranges = || all.iter().filter_map(|images| images.range());
    let (Some(low), Some(high)) = (ranges().map(|r| r.0).min(), ranges().map(|r| r.1).max()) else {
        return Ok(());
    };
    let first = first_number(low, high, count);
    let found = (high - first).saturating_add(1);
    if found == count as u64 {
        return Ok(());
    }
    if ranges().any(|range| range != (low, high)) && found > count as u64 {
        return Err(unlike(all, &format!("{count} frames ({at})")));
    }
    Err(Error::FrameNumbers(format!(
        "{at} is {count}, but the images are numbered from {first} to {high}, which is {found} frames: \
         correct it, or add the images that are missing"
    )))
}

/// Number of frame 0 among numbers from `low` to `high`. The first frames of a recording may be
/// missing, as others may.
fn first_number(low: u64, high: u64, count: usize) -> u64 {
    if high < count as u64 { 0 } else { low }
}

/// Refuses fewer images than there should be frames: the last of all cameras were not recorded, or
/// the count is wrong.
pub(super) fn expect_end(all: &[&Images], at: &str, count: usize) -> Result<(), Error> {
    let last = all.iter().filter_map(|images| images.range()).map(|r| r.1).max();
    match last {
        Some(last) if last < (count as u64).saturating_sub(1) => expect_all(all, at, count),
        _ => Ok(()),
    }
}

fn unlike(all: &[&Images], frames: &str) -> Error {
    let mut named: Vec<String> = Vec::new();
    for images in all.iter().filter(|images| !images.is_empty()) {
        let (range, others) = (images.range(), images.by_number.len());
        let is_new = !all
            .iter()
            .take_while(|i| !std::ptr::eq(**i, *images))
            .any(|earlier| earlier.range() == range && earlier.by_number.len() == others);
        if is_new {
            named.push(format!("{} ({others} images)", images.numbered()));
        }
    }
    Error::FrameNumbers(format!(
        "the numbers in the names of images do not give {frames}, {}: number images by their frame, and those of one \
         moment alike",
        shortened(&named, named.len())
    ))
}

/// The error for a camera without images of a kind, which were looked for as `wanted` in `folder`.
pub(super) fn missing(
    files: &Files<'_>,
    camera: &str,
    what: &'static str,
    wanted: String,
    folder: &str,
) -> Error {
    let beside = folder.rsplit_once('/').map_or("", |(above, _)| above);
    let inside = files.list(folder).files.into_iter().map(|name| format!("{folder}/{name}"));
    let last = folder.rsplit('/').next().unwrap_or(folder);
    let alike = files
        .list(beside)
        .files
        .into_iter()
        .filter(|name| name.rsplit_once('.').is_some_and(|(stem, _)| stem == last));
    let mut beside = alike.map(|name| format!("{beside}/{name}")).chain(inside);
    if let Some(video) = beside.find(|name| other::is_video(name)) {
        return other::video(video.trim_start_matches('/'), &format!("{folder}/%d.png"));
    }
    Error::ImagesMissing { camera: camera.to_owned(), what, wanted, there: files.describe(folder) }
}

#[cfg(test)]
mod tests;
