//! Words for motion that is not plausible.

use bendtwin_client::Implausible;

/// Most instances that are named.
const SHOWN: usize = 5;

/// Lines that warn of motion that no real object would make; empty without such motion.
pub(super) fn warnings(found: &[Implausible]) -> String {
    let mut text: String = found.iter().take(SHOWN).map(line).collect();
    if found.len() > SHOWN {
        text += &format!("\n... and {} more implausible ones", found.len() - SHOWN);
    }
    text
}

fn line(found: &Implausible) -> String {
    let Implausible { found: most, limit, .. } = *found;
    let what = match found.reason.as_str() {
        "START_GAP" => format!(
            "its actions begin {:.0} mm away from the control points of the initial state (limit {:.0} mm): \
             begin there",
            1e3 * most,
            1e3 * limit
        ),
        "CONTROL_SPEED" => format!(
            "a control point moves at {most:.1} m/s (limit {limit:.1} m/s): use more frames"
        ),
        "STRAIN" => format!(
            "a spring is strained by {:.0} % (limit {:.0} %): the object would tear or slip out of the hand",
            100.0 * most,
            100.0 * limit
        ),
        "CONTROL_IN_OBSTACLE" => format!(
            "a control point is {:.0} mm inside the ground or a collider (limit {:.0} mm): keep above it",
            1e3 * most,
            1e3 * limit
        ),
        "GRASP_FORCE" => format!(
            "grasp {} pulls or pushes with {most:.1} N (limit {limit:.1} N): grasp elsewhere or move slower",
            found.grasp.unwrap_or_default()
        ),
        other => format!("{other}: {most} (limit {limit})"),
    };
    let frame = if found.frame > 0 { format!(" in frame {}", found.frame) } else { String::new() };
    format!("\nnot plausible: instance {}{frame}: {what}", found.instance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_is_said_in_words() {
        let found = |reason: &str| Implausible {
            instance: 3,
            reason: reason.to_owned(),
            found: 0.02,
            limit: 0.005,
            frame: 7,
            grasp: (reason == "GRASP_FORCE").then_some(1),
        };
        for reason in bendtwin_contract::rollout::ImplausibleReason::ALL {
            let text = warnings(&[found(reason.as_str())]);
            assert!(!text.contains(reason.as_str()), "{text}");
            assert!(text.contains("instance 3 in frame 7"), "{text}");
        }
        assert_eq!(warnings(&vec![found("STRAIN"); 9]).lines().count(), 1 + SHOWN + 1);
        assert_eq!(warnings(&[]), "");
    }
}
