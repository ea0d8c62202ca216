//! Settings of fits introduced after the first version. A worker of an older version does not know
//! them, and would fail such a fit permanently: it waits for a newer worker.

use bendtwin_core::FitSettings;
use semver::Version;
use serde_json::Value;

use crate::app::{Error, Result};

/// The JSON pointer of each, and the version of the program in which it came. All may be left open.
const SINCE: &[(&str, Version)] = &[];

/// Settings as workers get them: equal settings are equal text. With the version of the program that a
/// worker has at least to know all of them.
pub(super) fn for_workers(settings: &FitSettings) -> Result<(String, Option<Version>)> {
    // By way of their text, which has numbers as they were written.
    let written = serde_json::to_string(settings);
    let document = written.and_then(|text| serde_json::from_str(&text));
    let mut document = document.map_err(|e| Error::Internal(e.to_string()))?;
    let version = require(&mut document, SINCE);
    Ok((document.to_string(), version))
}

/// Leaves out the newer settings that are left open, and finds the version that knows the others.
fn require(settings: &mut Value, since: &[(&str, Version)]) -> Option<Version> {
    let mut required = None;
    for (pointer, version) in since {
        let Some((group, name)) = pointer.rsplit_once('/') else { continue };
        let group = settings.pointer_mut(group).and_then(Value::as_object_mut);
        let Some(group) = group else { continue };
        match group.get(name) {
            Some(Value::Null) => drop(group.remove(name)),
            Some(_) => required = required.max(Some(version.clone())),
            None => {}
        }
    }
    required
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Settings of the first release. Before it is out, new settings are added here; afterwards the
    /// file must not change.
    const FIRST_RELEASE: &str = include_str!("since/first_release.txt");

    /// Pointers of all settings that have no settings inside.
    fn leaves(document: &Value, pointer: &str, into: &mut Vec<String>) {
        match document.as_object() {
            Some(group) => group
                .iter()
                .for_each(|(name, value)| leaves(value, &format!("{pointer}/{name}"), into)),
            None => into.push(pointer.to_owned()),
        }
    }

    /// Settings that are neither of the first release nor listed with their versions.
    fn unlisted(document: &Value, since: &[(&str, Version)]) -> Vec<String> {
        let mut found = Vec::new();
        leaves(document, "", &mut found);
        let is_first = |pointer: &String| FIRST_RELEASE.lines().any(|first| first == pointer);
        let is_later = |pointer: &String| since.iter().any(|(later, _)| later == pointer);
        found.retain(|pointer| !is_first(pointer) && !is_later(pointer));
        found.sort();
        found
    }

    #[test]
    fn a_setting_that_came_later_is_listed() {
        let mut settings = serde_json::to_value(FitSettings::default()).unwrap();
        let missing = unlisted(&settings, SINCE);
        assert!(
            missing.is_empty(),
            "{missing:?}: list it in SINCE with the version of the program, as one that may be left \
             open; only before the first release, in since/first_release.txt"
        );
        for (pointer, _) in SINCE {
            let default = settings.pointer(pointer);
            assert_eq!(default, Some(&Value::Null), "{pointer} is to be left open by default");
        }
        // An unlisted setting is found at any depth.
        settings["refine"]["momentum"] = Value::Null;
        settings["layers"] = json!({"count": null});
        assert_eq!(unlisted(&settings, SINCE), ["/layers/count", "/refine/momentum"]);
        let since = [("/refine/momentum", Version::new(0, 3, 0))];
        assert_eq!(unlisted(&settings, &since), ["/layers/count"]);
    }

    #[test]
    fn a_released_setting_stays() {
        let settings = serde_json::to_value(FitSettings::default()).unwrap();
        let gone: Vec<_> =
            FIRST_RELEASE.lines().filter(|first| settings.pointer(first).is_none()).collect();
        assert!(gone.is_empty(), "older clients and stored fits have them: {gone:?}");
    }

    #[test]
    fn a_worker_is_to_know_the_settings_that_are_given() {
        let since = [
            ("/refine/momentum", Version::new(0, 3, 0)),
            ("/refine/warm_up", Version::new(0, 10, 0)),
            ("/layers", Version::new(0, 4, 1)),
        ];
        let required = |mut settings: Value| (require(&mut settings, &since), settings);
        let plain = json!({"seed": 1, "refine": {"passes": 3}});
        assert_eq!(required(plain.clone()), (None, plain.clone()));
        let open = json!({"seed": 1, "refine": {"passes": 3, "momentum": null, "warm_up": null}});
        assert_eq!(required(open), (None, plain));
        let given = json!({"refine": {"warm_up": 2, "momentum": 0.5}, "layers": null});
        let without = json!({"refine": {"warm_up": 2, "momentum": 0.5}});
        assert_eq!(required(given), (Some(Version::new(0, 10, 0)), without));
    }

    #[test]
    fn what_a_worker_reads_is_what_was_set() {
        let settings = FitSettings { seed: 7, ..FitSettings::default() };
        let (text, _) = for_workers(&settings).unwrap();
        assert_eq!(serde_json::from_str::<FitSettings>(&text).unwrap(), settings);
    }
}
