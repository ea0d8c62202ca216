//! Motion of a robot's grippers in the transforms and joints of a recording.

use crate::{
    files::shortened,
    raw::{
        Pose,
        gripper::Motion,
        mcap::{
            index::Index,
            joints::{Sample, position},
            transforms::plain,
        },
    },
};

/// Joints whose positions may be added up.
const MAX_JOINTS: usize = 64;
/// Frames that are looked at for a message that lists some.
const MAX_LISTED: usize = 1000;

/// A robot's motion in a recording's frames.
pub(super) struct Robot<'r> {
    pub(super) index: &'r Index,
    /// The cameras' world.
    pub(super) world: &'r str,
    /// When each frame was taken [T] [ns].
    pub(super) times_ns: &'r [i64],
}

impl Robot<'_> {
    /// Samples of a joint, of a topic if one is named.
    fn samples(&self, name: &str, topic: Option<&str>) -> Result<&[Sample], String> {
        let joints = &self.index.joints;
        let Some(topics) = joints.of(name) else {
            return Err(format!(
                "no JointState has a position of the joint `{name}`; joints with one are {}",
                listed(joints.names().cloned().collect())
            ));
        };
        let known = || listed(topics.keys().cloned().collect());
        match (topic, topics.first_key_value()) {
            (None, Some((_, only))) if topics.len() == 1 => Ok(only),
            (None, _) => Err(format!(
                "several topics have a joint `{name}` ({}): name one (`topic`)",
                known()
            )),
            (Some(topic), _) => topics.get(topic).map(Vec::as_slice).ok_or_else(|| {
                format!("`{topic}` has no joint `{name}`; topics with it are {}", known())
            }),
        }
    }
}

impl Motion for Robot<'_> {
    fn frame(&self, name: &str) -> Result<Vec<Option<Pose>>, String> {
        let (tree, frame) = (&self.index.tree, plain(name));
        if let Some(child) = tree.unsettled(frame) {
            return Err(format!(
                "its frame `{name}` has several ways up, as `{child}` has several parents: record without one of them"
            ));
        }
        let Some(shared) = tree.shared(frame, self.world) else {
            let others = tree.frames().take(MAX_LISTED);
            let others = others.filter(|f| tree.shared(f, self.world).is_some());
            return Err(format!(
                "no transforms join the frame `{name}` and `{}`, where the cameras are: record /tf and /tf_static; joined are {}",
                self.world,
                listed(others.cloned().collect())
            ));
        };
        Ok(tree.relative(frame, self.world, shared, self.times_ns))
    }

    fn joints(&self, names: &[String], topic: Option<&str>) -> Result<Vec<f64>, String> {
        if !(1..=MAX_JOINTS).contains(&names.len()) {
            let count = names.len();
            return Err(format!(
                "it names {count} joints: name those of its fingers, at most {MAX_JOINTS}"
            ));
        }
        let all = names.iter().map(|name| self.samples(name, topic));
        let all = all.collect::<Result<Vec<_>, String>>()?;
        let sum = |ns: &i64| all.iter().map(|samples| position(samples, *ns)).sum();
        Ok(self.times_ns.iter().map(sum).collect())
    }
}

fn listed(names: Vec<String>) -> String {
    if names.is_empty() { "none".to_owned() } else { shortened(&names, names.len()) }
}
