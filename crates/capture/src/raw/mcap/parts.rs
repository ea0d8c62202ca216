//! The files of a recording: one, or several that a recorder split it into, each of which may be
//! compressed as a whole.

use std::collections::BTreeMap;

use super::{index::Index, place::Part, zstd};
use crate::{
    Error, Limits, Sources,
    files::{Files, at_most},
};

/// Endings of MCAP files, the compressed ones as `ros2 bag record --compression-mode file` writes
/// them.
const PLAIN: &str = ".mcap";
const PACKED: [&str; 2] = [".mcap.zstd", ".mcap.zst"];

/// What `ros2 bag record` writes beside its files.
const METADATA: &str = "metadata.yaml";
const MAX_METADATA: u64 = 4 << 20;

/// Files of one recording.
const MAX_PARTS: usize = 4096;

/// Time between two files of one recording in which no image comes [ns].
const MOST_GAP_NS: i64 = 2_000_000_000;

/// `true` if a file is MCAP by its name.
pub(in crate::raw) fn is_named(name: &str) -> bool {
    let lower = name.to_lowercase();
    lower.ends_with(PLAIN) || PACKED.iter().any(|ending| lower.ends_with(ending))
}

/// Files of a recording.
pub(super) struct Parts {
    pub(super) parts: Vec<Part>,
    /// `true` if `metadata.yaml` says that they are one recording.
    pub(super) declared: bool,
}

/// The MCAP files of a folder or archive, in the order of `metadata.yaml` or of their names. What is
/// left out goes into `sources`.
pub(super) fn of_files(files: &mut Files<'_>, sources: &mut Sources) -> Result<Parts, Error> {
    let mut names: Vec<String> = files.list("").files;
    names.retain(|name| is_named(name));
    // Players unpack a file beside the compressed one.
    let plain: Vec<String> = names.iter().filter(|n| !is_packed(n)).map(|n| stem(n)).collect();
    names.retain(|name| {
        let twice = is_packed(name) && plain.contains(&stem(name));
        if twice {
            sources.leave_out(name, "it lies there unpacked, too");
        }
        !twice
    });
    names.sort_by_key(|name| order(name));
    let listed = match files.find_within(METADATA, MAX_METADATA)? {
        Some(text) => listed(&String::from_utf8_lossy(&text)),
        None => Vec::new(),
    };
    let declared = listed.iter().any(|l| names.iter().any(|n| stem(n) == stem(l)));
    if declared {
        let mut taken = Vec::new();
        for wanted in &listed {
            let Some(at) = names.iter().position(|name| stem(name) == stem(wanted)) else {
                return Err(Error::MissingFile(wanted.clone()));
            };
            taken.push(names.remove(at));
        }
        for name in names {
            sources.leave_out(name, format!("{METADATA} does not name it"));
        }
        names = taken;
    }
    at_most("files of a recording", names.len(), MAX_PARTS)?;
    let mut left = files.limits.total_bytes / 2;
    let mut parts = Vec::with_capacity(names.len());
    for name in names {
        let file = files.section(&name)?;
        let before = left;
        parts.push(part(name, file, &files.limits, &mut left)?);
        files.budget.take(before.saturating_sub(left), "files that are unpacked in memory")?;
    }
    Ok(Parts { parts, declared })
}

/// A file, unpacked in memory if it is compressed; `left` is what may still be held so.
pub(super) fn part(
    name: String,
    bytes: crate::files::Section,
    limits: &Limits,
    left: &mut u64,
) -> Result<Part, Error> {
    let mut start = [0; 4];
    let is_packed = bytes.read_exact_at(&mut start, 0).is_ok() && start == zstd::MAGIC;
    let bytes = if is_packed {
        crate::files::Section::of_memory(zstd::unpack_file(&name, &bytes, limits, left)?)
    } else {
        bytes
    };
    Ok(Part { name, bytes })
}

/// Checks that files are one recording, which nobody says: of one topic one file after the other,
/// of different topics all at the same time.
///
/// # Errors
/// If they are several recordings.
pub(super) fn expect_one(parts: &[Part], index: &Index) -> Result<(), Error> {
    let mut whole: BTreeMap<u32, (i64, i64)> = BTreeMap::new();
    let mut is_one = true;
    for topic in &index.topics {
        let mut spans: BTreeMap<u32, (i64, i64)> = BTreeMap::new();
        for image in &topic.images {
            let ns = image.log_ns;
            for spans in [&mut spans, &mut whole] {
                let (first, last) = spans.entry(image.place.part).or_insert((ns, ns));
                (*first, *last) = ((*first).min(ns), (*last).max(ns));
            }
        }
        let mut spans: Vec<(i64, i64)> = spans.into_values().collect();
        spans.sort_unstable();
        is_one &= spans.windows(2).all(|w| {
            let gap = w[1].0.saturating_sub(w[0].1);
            (0..=MOST_GAP_NS).contains(&gap)
        });
    }
    let mut whole: Vec<(i64, i64)> = whole.into_values().collect();
    whole.sort_unstable();
    let mut end = whole.first().map_or(0, |(_, last)| *last);
    for (first, last) in whole {
        is_one &= first.saturating_sub(end) <= MOST_GAP_NS;
        end = end.max(last);
    }
    if is_one {
        return Ok(());
    }
    let names: Vec<&str> = parts.iter().take(5).map(|part| part.name.as_str()).collect();
    Err(Error::Several(format!(
        "{}: files of one recording follow each other or have different topics, and are joined with `mcap merge {} -o \
         recording.mcap`",
        names.join(", "),
        names.join(" ")
    )))
}

fn is_packed(name: &str) -> bool {
    !name.to_lowercase().ends_with(PLAIN)
}

/// A file's name without its ending and without folders, which old bags name in their metadata.
pub(super) fn stem(name: &str) -> String {
    let name = name.rsplit('/').next().unwrap_or(name);
    let at = name.to_lowercase().rfind(PLAIN).filter(|at| name.is_char_boundary(*at));
    let at = at.or_else(|| name.rfind('.').filter(|at| *at > 0));
    name[..at.unwrap_or(name.len())].to_owned()
}

/// Compares the text before the number at the end, then that number.
fn order(name: &str) -> (String, u64, String) {
    let stem = stem(name);
    let text = stem.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned();
    let number = stem[text.len()..].parse().unwrap_or(0);
    (text, number, name.to_owned())
}

/// The files that the metadata of a bag lists.
fn listed(text: &str) -> Vec<String> {
    let mut lines = text.lines().skip_while(|line| line.trim() != "relative_file_paths:");
    lines.next();
    let item = |line: &str| Some(line.trim().strip_prefix('-')?.trim().to_owned());
    let items = lines.map_while(item).take(MAX_PARTS);
    items.map(|name| name.trim_matches(['"', '\'']).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_a_bag_come_in_its_order() {
        let text = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - a_0.mcap\n    - \"b/a_1.mcap\"\n  files:\n    - path: x\n";
        assert_eq!(listed(text), ["a_0.mcap", "b/a_1.mcap"]);
        assert_eq!(stem("b/a_1.mcap"), stem("a_1.mcap.zstd"));
        assert!(listed("a: 1").is_empty());
        let mut names = ["a_10.mcap", "a_9.mcap", "B.MCAP", "a.mcap"];
        names.sort_by_key(|name| order(name));
        assert_eq!(names, ["B.MCAP", "a.mcap", "a_9.mcap", "a_10.mcap"]);
        assert!(is_named("x.MCAP") && is_named("x.mcap.zst") && !is_named("x.mcap.new"));
    }
}
