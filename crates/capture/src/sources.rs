//! Sources: what a reader took as what, and what it left out.

use serde::{Deserialize, Serialize};

/// Most parts that are listed; more would hide what matters.
const MOST: usize = 200;

/// What was taken as what in a capture, and what was left out.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Sources {
    /// What was taken, camera by camera.
    pub taken: Vec<Taken>,
    /// What was found and not taken, with the reason.
    pub left_out: Vec<LeftOut>,
}

/// A file, folder or topic that was taken as a part of the capture.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Taken {
    /// The part: `colour`, `depth`, `object masks`, `hand masks`, `tracks`, `pose`, `lens`, `gripper`,
    /// `mesh`, ...
    pub part: String,
    /// The camera's name; absent if it concerns all.
    pub camera: Option<String>,
    /// The file, folder or topic.
    pub from: String,
    /// Form of its content as it was understood: `16UC1, 1 is 0.001 m`, for example; empty if there is
    /// one form alone.
    pub form: String,
}

/// A file, folder or topic that was not taken.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftOut {
    /// The file, folder or topic.
    pub from: String,
    /// The reason, as a clause: `it is a confidence map`.
    pub because: String,
}

impl Sources {
    /// Adds a part that was taken for a camera, or for all.
    pub fn take(
        &mut self,
        part: &str,
        camera: Option<&str>,
        from: impl Into<String>,
        form: impl Into<String>,
    ) {
        if self.taken.len() < MOST {
            self.taken.push(Taken {
                part: part.to_owned(),
                camera: camera.map(str::to_owned),
                from: from.into(),
                form: form.into(),
            });
        }
    }

    /// Adds what was not taken.
    pub fn leave_out(&mut self, from: impl Into<String>, because: impl Into<String>) {
        if self.left_out.len() < MOST {
            self.left_out.push(LeftOut { from: from.into(), because: because.into() });
        }
    }

    /// Adds those of another recording of the same capture, whose cameras have other names.
    pub fn extend(&mut self, other: Self) {
        let room = |list: usize| MOST.saturating_sub(list);
        self.taken.extend(other.taken.into_iter().take(room(self.taken.len())));
        self.left_out.extend(other.left_out.into_iter().take(room(self.left_out.len())));
    }

    /// `true` if nothing is listed.
    pub fn is_empty(&self) -> bool {
        self.taken.is_empty() && self.left_out.is_empty()
    }

    /// A line for each entry.
    pub fn lines(&self) -> impl Iterator<Item = String> {
        let taken = self.taken.iter().map(|taken| {
            let camera = taken.camera.as_ref().map_or(String::new(), |name| format!(" of {name}"));
            let form =
                if taken.form.is_empty() { String::new() } else { format!(" ({})", taken.form) };
            format!("{}{camera}: {}{form}", taken.part, taken.from)
        });
        let left_out = self.left_out.iter();
        taken.chain(left_out.map(|left| format!("left out: {}: {}", left.from, left.because)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_is_a_line() {
        let mut sources = Sources::default();
        assert!(sources.is_empty());
        sources.take("depth", Some("left"), "/left/depth", "16UC1, 1 is 0.001 m");
        sources.take("mesh", None, "object.glb", "");
        sources.leave_out("/left/confidence", "it is a confidence map");
        let lines: Vec<String> = sources.lines().collect();
        assert_eq!(
            lines,
            [
                "depth of left: /left/depth (16UC1, 1 is 0.001 m)",
                "mesh: object.glb",
                "left out: /left/confidence: it is a confidence map",
            ]
        );
    }
}
