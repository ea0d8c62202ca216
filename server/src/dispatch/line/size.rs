//! Sizes of rollouts, and the slots and places that each may take.

/// Longest time that a worker should need for a small and for a medium rollout [s].
const SMALL_S: f64 = 0.5;
const MEDIUM_S: f64 = 10.0;

/// The size of a rollout, by the time that a worker should need for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Size {
    /// Up to half a second.
    Small,
    /// Up to ten seconds.
    Medium,
    /// Everything else.
    Large,
}

impl Size {
    pub(crate) const ALL: [Self; 3] = [Self::Small, Self::Medium, Self::Large];

    pub(super) fn of(seconds: f64) -> Self {
        if seconds <= SMALL_S {
            Self::Small
        } else if seconds <= MEDIUM_S {
            Self::Medium
        } else {
            Self::Large
        }
    }

    /// Name in metrics.
    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::Small => "small",
            Self::Medium => "medium",
            Self::Large => "large",
        }
    }
}

/// Numbers of rollouts that a worker takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Under way.
    pub(super) slots: usize,
    /// Waiting.
    pub(super) places: usize,
}

impl Bounds {
    /// True if one more of this size may be under way, of an owner with `own` of them: large ones
    /// take a quarter of the slots at most, medium and large ones five eighths together, and one at
    /// least. An owner leaves one of each of these slots to others, where there are several, so that
    /// nobody waits until a rollout of another owner ends.
    pub(super) fn has_slot(&self, size: Size, under_way: [usize; 3], own: [usize; 3]) -> bool {
        let [small, medium, large] = under_way;
        let [own_small, own_medium, own_large] = own;
        let of_owner = |most: usize| if self.slots < 4 { most } else { (most - 1).max(1) };
        let has = |most: usize, all: usize, own: usize| all < most && own < of_owner(most);
        let is_free = has(self.slots, small + medium + large, own_small + own_medium + own_large);
        let has_heavy = has((self.slots * 5 / 8).max(1), medium + large, own_medium + own_large);
        let has_large = has((self.slots / 4).max(1), large, own_large);
        match size {
            Size::Small => is_free,
            Size::Medium => is_free && has_heavy,
            Size::Large => is_free && has_heavy && has_large,
        }
    }

    /// True if one more of this size may wait, of an owner and of a client with this many in the line
    /// already. Large ones take half of the places at most, medium and large ones three quarters
    /// together. A client may have three times as many as it leaves free, so it never takes them
    /// all, and the clients of an owner together 15 times as many.
    pub(super) fn has_place(
        &self,
        size: Size,
        waiting: [usize; 3],
        (of_owner, of_client): (usize, usize),
    ) -> bool {
        let [small, medium, large] = waiting;
        let most = |places: usize| places.max(1).min(self.places);
        let free = self.places.saturating_sub(small + medium + large);
        let heavy = most(self.places * 3 / 4).saturating_sub(medium + large);
        let room = match size {
            Size::Small => free,
            Size::Medium => free.min(heavy),
            Size::Large => free.min(heavy).min(most(self.places / 2).saturating_sub(large)),
        };
        room > 0 && of_client <= 3 * room && of_owner <= 15 * room
    }
}
