//! The metadata record `bendtwin`: what messages cannot say.

use std::collections::BTreeMap;

use crate::raw::decode::unit_fault;

/// Keys of the record; those of a topic's unit have its name after them.
const KEYS: &str =
    "world_frame, up_axis, ground_height_m, train_frame_count, depth_unit_m, depth_unit_m:TOPIC";

/// Metres that each 1 of depth may be.
const UNITS: std::ops::RangeInclusive<f64> = 1e-9..=1.0;

/// What the record declares.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Settings {
    pub(super) world_frame: Option<String>,
    pub(super) up_axis: Option<String>,
    pub(super) ground_height_m: Option<f32>,
    pub(super) train_frame_count: Option<usize>,
    /// Metres of each 1 of depth, of all topics.
    depth_unit_m: Option<f64>,
    /// Likewise of single topics.
    topic_units: BTreeMap<String, f64>,
}

impl Settings {
    /// Reads the record; the error says what is wrong with it.
    pub(super) fn parse(record: &BTreeMap<String, String>) -> Result<Self, String> {
        let mut settings = Self::default();
        for (key, value) in record {
            let wrong = || format!("`{key}` of its metadata record `bendtwin` is `{value}`");
            match key.as_str() {
                "world_frame" => settings.world_frame = Some(value.clone()),
                "up_axis" => settings.up_axis = Some(value.clone()),
                "ground_height_m" => {
                    let height = value.parse::<f32>().ok().filter(|h| h.is_finite());
                    settings.ground_height_m = Some(height.ok_or_else(wrong)?);
                }
                "train_frame_count" => {
                    settings.train_frame_count = Some(value.parse().map_err(|_| wrong())?);
                }
                _ => {
                    let topic = match key.strip_prefix("depth_unit_m") {
                        Some("") => None,
                        Some(rest) if rest.starts_with(':') => Some(rest[1..].to_owned()),
                        _ => {
                            return Err(format!(
                                "its metadata record `bendtwin` has the unknown key `{key}`: known are {KEYS}"
                            ));
                        }
                    };
                    let unit = value.parse::<f64>().map_err(|_| {
                        wrong() + ": metres of each 1 of depth, 0.001 for millimetres"
                    })?;
                    if !UNITS.contains(&unit) {
                        let fault = unit_fault(key, unit);
                        return Err(format!("its metadata record `bendtwin`: {fault}"));
                    }
                    match topic {
                        None => settings.depth_unit_m = Some(unit),
                        Some(topic) => drop(settings.topic_units.insert(topic, unit)),
                    }
                }
            }
        }
        Ok(settings)
    }

    /// Metres of each 1 of a topic's depth, if that is declared.
    pub(super) fn unit_m(&self, topic: &str) -> Option<f64> {
        self.topic_units.get(topic).copied().or(self.depth_unit_m)
    }

    /// Topics whose units are declared.
    pub(super) fn topics(&self) -> impl Iterator<Item = &str> {
        self.topic_units.keys().map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(pairs: &[(&str, &str)]) -> Result<Settings, String> {
        let pairs = pairs.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned()));
        Settings::parse(&pairs.collect())
    }

    #[test]
    fn units_are_those_of_a_topic_or_of_all() {
        let settings =
            parse(&[("depth_unit_m", "0.0001"), ("depth_unit_m:/a/depth", "0.00025")]).unwrap();
        assert_eq!(settings.unit_m("/a/depth"), Some(0.00025));
        assert_eq!(settings.unit_m("/b/depth"), Some(0.0001));
        assert_eq!(parse(&[]).unwrap().unit_m("/a/depth"), None);
    }

    #[test]
    fn unknown_keys_are_refused_with_the_known_ones() {
        for key in ["depth_scale", "depth_unit_mm", "fps", ""] {
            let fault = parse(&[(key, "1")]).unwrap_err();
            assert!(fault.contains(KEYS) && fault.contains(&format!("`{key}`")), "{fault}");
        }
        for (key, value) in [
            ("depth_unit_m", "0"),
            ("depth_unit_m", "mm"),
            ("depth_unit_m:/a", "NaN"),
            ("ground_height_m", "inf"),
            ("train_frame_count", "-1"),
        ] {
            assert!(parse(&[(key, value)]).unwrap_err().contains(value), "{key}");
        }
        let fault = parse(&[("depth_unit_m:/a", "1000")]).unwrap_err();
        assert!(fault.contains("`depth_unit_m:/a` is 1000") && fault.contains("give 0.001"));
    }
}
