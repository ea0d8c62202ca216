//! Frames with several parents: a driver and a calibration that both place a camera. ROS would jump
//! between them; here the one that leads to the world counts, in any order of the file.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::Tree;

/// Frames above one that are looked at: trees of robots have a hundred.
const MAX_ABOVE: usize = 1000;
/// Parents of a frame of which one is chosen, and frames with several.
const MAX_PARENTS: usize = 16;
const MAX_UNCLEAR: usize = 64;

/// The parent that counts of a frame with several.
#[derive(Debug, PartialEq)]
pub(in crate::raw::mcap) struct Choice {
    pub(in crate::raw::mcap) child: String,
    pub(in crate::raw::mcap) parent: String,
    /// The others.
    pub(in crate::raw::mcap) others: Vec<String>,
    /// Why this one, as a clause.
    pub(in crate::raw::mcap) because: String,
}

/// A frame with parents between which nothing decides.
#[derive(Debug, PartialEq)]
pub(in crate::raw::mcap) struct Unclear {
    pub(in crate::raw::mcap) child: String,
    pub(in crate::raw::mcap) parents: Vec<String>,
}

impl Tree {
    /// Decides which parent counts of every frame at or above one of `cameras` that has several:
    /// the only one below the world; else, of several below it, the one with the shortest way to it,
    /// if it is fixed: a calibration of this frame is more specific than the mount of its device.
    /// The world is the frame `named` or, without one, `world` or what all cameras share.
    pub(in crate::raw::mcap) fn settle_parents(
        &mut self,
        cameras: &[&str],
        named: Option<&str>,
    ) -> Result<Vec<Choice>, Unclear> {
        let above: Vec<BTreeMap<String, usize>> =
            cameras.iter().map(|camera| self.distances(camera)).collect();
        let everything: BTreeSet<&String> = above.iter().flat_map(BTreeMap::keys).collect();
        let unclear: Vec<String> = everything
            .into_iter()
            .filter(|frame| self.edges.get(*frame).is_some_and(|parents| parents.len() > 1))
            .cloned()
            .collect();
        let shared = |frame: &str| above.iter().all(|frames| frames.contains_key(frame));
        let world = named.or_else(|| shared("world").then_some("world"));
        let common: BTreeSet<String> = match (world, above.first()) {
            (Some(world), _) => BTreeSet::from([world.to_owned()]),
            // All of what is above a single camera is shared, which decides nothing.
            (None, Some(first)) if above.len() > 1 => {
                first.keys().filter(|frame| shared(frame)).cloned().collect()
            }
            (None, _) => BTreeSet::new(),
        };
        let mut choices = Vec::new();
        for (nth, child) in unclear.into_iter().enumerate() {
            let parents = self.edges.get(&child).into_iter().flatten().map(|(p, _)| p.clone());
            let parents: Vec<String> = parents.take(MAX_PARENTS + 1).collect();
            // Each parent is followed to the world, so their number is bounded.
            if parents.len() > MAX_PARENTS || nth >= MAX_UNCLEAR {
                return Err(Unclear { child, parents });
            }
            let mut leading: Vec<(usize, &String)> = Vec::new();
            for parent in &parents {
                let distances = self.distances(parent);
                let nearest = common.iter().filter_map(|frame| distances.get(frame)).min();
                leading.extend(nearest.map(|distance| (*distance, parent)));
            }
            leading.sort();
            let is_fixed = |parent: &String| {
                let edge = self.edges.get(&child).and_then(|parents| parents.get(parent));
                edge.is_some_and(|edge| edge.fixed.is_some())
            };
            let goal = world.unwrap_or("what all cameras share");
            let (parent, because) = match leading.as_slice() {
                [(_, only)] => ((*only).clone(), format!("it alone leads to `{goal}`")),
                [(first, nearest), (second, _), ..] if first < second && is_fixed(nearest) => {
                    ((*nearest).clone(), format!("it is the shortest way to `{goal}`"))
                }
                _ => return Err(Unclear { child, parents }),
            };
            let others = parents.into_iter().filter(|p| *p != parent).collect();
            self.chosen.insert(child.clone(), parent.clone());
            choices.push(Choice { child, parent, others, because });
        }
        Ok(choices)
    }

    /// A frame and those above it through any parents, with the number of steps to each; at most
    /// [`MAX_ABOVE`].
    fn distances(&self, frame: &str) -> BTreeMap<String, usize> {
        let mut found = BTreeMap::from([(frame.to_owned(), 0)]);
        let mut queue = VecDeque::from([(frame.to_owned(), 0)]);
        while let Some((frame, steps)) = queue.pop_front() {
            for parent in self.edges.get(&frame).into_iter().flat_map(BTreeMap::keys) {
                if found.len() < MAX_ABOVE && !found.contains_key(parent) {
                    found.insert(parent.clone(), steps + 1);
                    queue.push_back((parent.clone(), steps + 1));
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::{super::super::messages::Transform, *};

    fn tree(edges: &[(&str, &str, bool)]) -> Tree {
        let mut tree = Tree::default();
        for (parent, child, fixed) in edges {
            let transform = Transform {
                parent: (*parent).to_owned(),
                child: (*child).to_owned(),
                ..Transform::default()
            };
            tree.add(transform, *fixed).unwrap();
        }
        tree
    }

    /// The parent that is taken of `optical`, for all orders of the edges.
    fn parent(edges: &[(&str, &str, bool)], cameras: &[&str]) -> Result<String, Unclear> {
        let mut results: Vec<Result<String, Unclear>> = Vec::new();
        for start in 0..edges.len() {
            let mut turned = edges.to_vec();
            turned.rotate_left(start);
            let mut tree = tree(&turned);
            let settled = tree.settle_parents(cameras, None);
            results.push(settled.map(|_| tree.path("optical")[1].to_owned()));
        }
        assert!(results.windows(2).all(|w| w[0] == w[1]), "{results:?}");
        results.remove(0)
    }

    #[test]
    fn the_parent_below_the_world_counts_in_any_order() {
        let driver = [("link", "color", true), ("color", "optical", true)];
        let edges = |more: &[(&'static str, &'static str, bool)]| [&driver[..], more].concat();
        let hand_eye = edges(&[("world", "optical", true)]);
        assert_eq!(parent(&hand_eye, &["optical"]).unwrap(), "world");
        let base = edges(&[("base", "optical", true), ("base", "other", true)]);
        assert_eq!(parent(&base, &["optical", "other"]).unwrap(), "base");
        // Both lead there: the calibration of the frame itself is more specific than the mount.
        let mounted = edges(&[("world", "link", true), ("world", "optical", true)]);
        assert_eq!(parent(&mounted, &["optical"]).unwrap(), "world");
    }

    #[test]
    fn of_very_many_parents_none_is_chosen() {
        let mut many = Tree::default();
        let names: Vec<String> = (0..100_000).map(|i| format!("frame {i}")).collect();
        for parent in &names {
            let [parent, child] = [parent.clone(), "optical".to_owned()];
            many.add(Transform { parent, child, ..Transform::default() }, true).unwrap();
        }
        let unclear = many.settle_parents(&["optical"], None).unwrap_err();
        assert_eq!((unclear.child.as_str(), unclear.parents.len()), ("optical", MAX_PARENTS + 1));
    }

    #[test]
    fn parents_between_which_nothing_decides_are_named() {
        let two = [("left", "optical", true), ("right", "optical", true)];
        let unclear = parent(&two, &["optical"]).unwrap_err();
        assert_eq!(unclear.parents, ["left", "right"]);
        let equal = [&two[..], &[("world", "left", true), ("world", "right", true)]].concat();
        assert!(parent(&equal, &["optical"]).is_err());
        let moving =
            [("world", "optical", false), ("link", "optical", true), ("world", "link", true)];
        assert!(parent(&moving, &["optical"]).is_err());
    }
}
