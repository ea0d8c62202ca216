//! Metrics by owner, of the largest owners alone: names of owners are free text and there may be any
//! number of them. They are written here and not by the recorder, which would keep the series of an
//! owner that is no longer among the largest.

use std::{cmp::Reverse, collections::BTreeMap, fmt::Write as _};

use bendtwin_store::OwnerUsage;

use super::catalog;

/// Owners that each metric has separate series of.
const SERIES: usize = 50;
/// Label of all others together, and of an owner who is called so.
const OTHER: &str = "other";
/// Longest label [characters].
const LONGEST: usize = 64;

/// The metrics as text.
pub(super) fn render(usage: &[OwnerUsage]) -> String {
    let mut text = String::new();
    let stored = |owner: &OwnerUsage| owner.stored.total();
    let name = "bendtwin_owner_stored_bytes";
    head(&mut text, name);
    for (owner, bytes) in largest(usage, stored, |owner| [stored(owner)]) {
        let [bytes] = bytes;
        // A string takes everything.
        let _ = writeln!(text, "{name}{{owner=\"{owner}\"}} {bytes}");
    }
    let jobs = |owner: &OwnerUsage| [owner.queued_jobs, owner.running_jobs];
    let name = "bendtwin_owner_jobs";
    head(&mut text, name);
    for (owner, counts) in largest(usage, |owner| jobs(owner).iter().sum(), jobs) {
        for (state, count) in ["queued", "running"].into_iter().zip(counts) {
            let _ = writeln!(text, "{name}{{owner=\"{owner}\",state=\"{state}\"}} {count}");
        }
    }
    text
}

/// The lines before the values of a metric.
fn head(text: &mut String, name: &str) {
    // A string takes everything.
    let _ = writeln!(text, "# HELP {name} {}\n# TYPE {name} gauge", catalog::help(name));
}

/// Values of the owners with the largest keys, by label, and of all others together.
fn largest<const N: usize>(
    usage: &[OwnerUsage],
    key: impl Fn(&OwnerUsage) -> u64,
    values: impl Fn(&OwnerUsage) -> [u64; N],
) -> BTreeMap<String, [u64; N]> {
    let mut owners: Vec<&OwnerUsage> = usage.iter().collect();
    owners.sort_by_key(|owner| Reverse(key(owner)));
    let mut sums: BTreeMap<String, [u64; N]> = BTreeMap::from([(OTHER.to_owned(), [0; N])]);
    for (place, owner) in owners.into_iter().enumerate() {
        let label = if place < SERIES { label(&owner.owner) } else { OTHER.to_owned() };
        let sum = sums.entry(label).or_insert([0; N]);
        for (sum, value) in sum.iter_mut().zip(values(owner)) {
            *sum = sum.saturating_add(value);
        }
    }
    sums
}

/// The label of an owner: without control characters and what would need an escape, and not long.
/// Owners of the same label are added up.
fn label(owner: &str) -> String {
    let safe = |c: char| if c.is_control() || c == '"' || c == '\\' { '_' } else { c };
    let label: String = owner.chars().take(LONGEST).map(safe).collect();
    if label.is_empty() { "unknown".to_owned() } else { label }
}

#[cfg(test)]
mod tests {
    use bendtwin_store::StoredBytes;

    use super::*;

    fn owner(name: &str, twins: u64, queued_jobs: u64) -> OwnerUsage {
        let stored = StoredBytes { twins, ..StoredBytes::default() };
        OwnerUsage { owner: name.to_owned(), stored, queued_jobs, ..OwnerUsage::default() }
    }

    #[test]
    fn the_largest_owners_have_series_and_the_rest_has_one() {
        let usage: Vec<_> = (0..200).map(|n| owner(&format!("owner {n:03}"), n, 200 - n)).collect();
        let text = render(&usage);
        let of = |name: &str| text.lines().filter(|line| line.starts_with(name)).count();
        assert_eq!(of("bendtwin_owner_stored_bytes{"), SERIES + 1);
        assert_eq!(of("bendtwin_owner_jobs{"), 2 * (SERIES + 1));
        let rest: u64 = (0..150).sum();
        for line in [
            "bendtwin_owner_stored_bytes{owner=\"owner 199\"} 199".to_owned(),
            format!("bendtwin_owner_stored_bytes{{owner=\"other\"}} {rest}"),
            "bendtwin_owner_jobs{owner=\"owner 000\",state=\"queued\"} 200".to_owned(),
        ] {
            assert!(text.lines().any(|found| found == line), "{line}");
        }
    }

    #[test]
    fn names_of_owners_are_safe_as_labels() {
        let hostile = "a\"} 1\nbendtwin_up{b=\"\\";
        let long = "x".repeat(300);
        let usage =
            [owner(hostile, 1, 0), owner(&long, 2, 0), owner("other", 3, 0), owner("", 4, 0)];
        let text = render(&usage);
        let stored: Vec<&str> =
            text.lines().filter(|line| line.starts_with("bendtwin_owner_stored_bytes{")).collect();
        assert_eq!(
            stored,
            [
                "bendtwin_owner_stored_bytes{owner=\"a_} 1_bendtwin_up{b=__\"} 1",
                "bendtwin_owner_stored_bytes{owner=\"other\"} 3",
                "bendtwin_owner_stored_bytes{owner=\"unknown\"} 4",
                &format!("bendtwin_owner_stored_bytes{{owner=\"{}\"}} 2", "x".repeat(LONGEST)),
            ]
        );
        assert!(
            text.lines().all(|line| line.starts_with('#') || line.starts_with("bendtwin_owner"))
        );
    }
}
