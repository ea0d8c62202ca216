//! Settings of fits that came after the first version. A worker of an older version does not know
//! them, and would fail a fit that has one for good: such a fit waits for a newer worker.

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
