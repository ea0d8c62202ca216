//! Positions of a robot's joints over time.

use std::collections::BTreeMap;

use super::messages;
use crate::raw::clock::samples::nearby;

/// Time between two samples of a joint that are kept [ns]: controllers report a thousand a second.
const SPACING_NS: i64 = 4_000_000;
/// Samples that are kept; later ones are passed over.
const MAX_SAMPLES: usize = 4_000_000;
/// Joints of a recording; others are passed over.
const MAX_JOINTS: usize = 4096;
/// Bytes of a joint's name; others are passed over.
const MAX_NAME: usize = 256;

/// Positions of joints by their names.
#[derive(Debug, Default)]
pub(super) struct Joints {
    /// Samples by joint and topic, as joints of two arms may have the same names; in the order of time after
    /// [`Joints::sort`].
    samples: BTreeMap<String, BTreeMap<String, Vec<Sample>>>,
    joint_count: usize,
    sample_count: usize,
}

/// Position of a joint at a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    ns: i64,
    position: f64,
}

impl Joints {
    /// Adds the positions of a message that was recorded at `log_ns`. Joints without a position are
    /// passed over: some controllers report efforts alone.
    pub(super) fn add(&mut self, topic: &str, message: messages::Joints, log_ns: i64) {
        let ns = if message.stamp_ns == 0 { log_ns } else { message.stamp_ns };
        for (name, position) in message.names.iter().zip(message.positions) {
            if position.is_finite() && name.len() <= MAX_NAME {
                self.add_one(topic, name, Sample { ns, position });
            }
        }
    }

    fn add_one(&mut self, topic: &str, name: &str, sample: Sample) {
        let known = self.samples.get_mut(name).and_then(|topics| topics.get_mut(topic));
        let samples = match known {
            Some(samples) => samples,
            None if self.joint_count < MAX_JOINTS => {
                self.joint_count += 1;
                let topics = self.samples.entry(name.to_owned()).or_default();
                topics.entry(topic.to_owned()).or_default()
            }
            None => return,
        };
        let since = samples.last().map(|last| sample.ns.saturating_sub(last.ns));
        let is_near = since.is_some_and(|since| (0..SPACING_NS).contains(&since));
        if !is_near && self.sample_count < MAX_SAMPLES {
            self.sample_count += 1;
            samples.push(sample);
        }
    }

    pub(super) fn sort(&mut self) {
        for samples in self.samples.values_mut().flat_map(BTreeMap::values_mut) {
            samples.sort_by_key(|sample| sample.ns);
        }
    }

    /// Names of the joints.
    pub(super) fn names(&self) -> impl Iterator<Item = &String> {
        self.samples.keys()
    }

    /// Samples of a joint by their topics.
    pub(super) fn of(&self, name: &str) -> Option<&BTreeMap<String, Vec<Sample>>> {
        self.samples.get(name)
    }
}

/// Position at a time, from samples in the order of time; NaN if it is unknown.
pub(super) fn position(samples: &[Sample], ns: i64) -> f64 {
    nearby(samples, |sample| sample.ns, ns).map_or(f64::NAN, |found| {
        let [a, b] = [found.before, found.after].map(|i| samples[i].position);
        a + found.share * (b - a)
    })
}
