//! Motions that a report asks about, and those that could be recorded next, with their words.

use bendtwin_core::{Twin, identifiability::Region};

use crate::{
    Regions,
    motions::{Act, Hold},
};

/// A motion with its name in reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Candidate {
    pub(crate) name: &'static str,
    pub(crate) hold: Hold,
    pub(crate) act: Act,
    /// True if a report says what the recordings leave open of it.
    pub(crate) is_asked: bool,
}

/// The motions of a twin's report. `open` is the region that the recordings leave most open.
pub(crate) fn candidates(twin: &Twin, regions: &Regions, open: usize) -> Vec<Candidate> {
    let has_hands = twin.graph.control_count() > 0;
    let own = if has_hands { Hold::Own } else { Hold::Region(0) };
    let far = regions.far;
    let of = |name, hold, act, is_asked| Candidate { name, hold, act, is_asked };
    let mut all = vec![
        of("hang", own, Act::Hang, true),
        of("shake", own, Act::Shake, true),
        of("push", own, Act::Push(far), true),
    ];
    if far > 0 {
        all.push(of("far_shake", Hold::Region(far), Act::Shake, false));
        all.push(of("bend", own, Act::Bend(far), false));
        all.push(of("pull", own, Act::Pull(far), false));
    }
    if open != far && open > 0 {
        all.push(of("region_shake", Hold::Region(open), Act::Shake, false));
    }
    all
}

impl Candidate {
    /// Instruction, as a sentence.
    pub(crate) fn action(&self, regions: &Regions, has_hands: bool) -> String {
        let place = |region: usize| place(regions.parts.get(region));
        let hold = match self.hold {
            Hold::Own => "Hold it as in the recording".to_owned(),
            Hold::Region(0) if !has_hands => format!("Hold it {}", place(0)),
            Hold::Region(region) => format!("Hold it {} instead", place(region)),
        };
        match self.act {
            Act::Hang => format!("{hold}, lift it and let it hang still."),
            Act::Shake => format!("{hold}, lift it and shake it."),
            Act::Push(region) => format!("{hold}, and push it {} sideways.", place(region)),
            Act::Bend(region) => {
                format!(
                    "{hold}, take it {} with another hand, and bend it between both.",
                    place(region)
                )
            }
            Act::Pull(region) => {
                format!("{hold}, take it {} with another hand, and pull gently.", place(region))
            }
        }
    }
}

/// A region as a place in a sentence.
fn place(region: Option<&Region>) -> String {
    match region.map(|r| r.name.as_str()) {
        Some("free end") => "at its free end".to_owned(),
        Some(name) if name.starts_with("near") || name.starts_with("between") => name.to_owned(),
        Some(name) => format!("at the place `{name}`"),
        None => "anywhere".to_owned(),
    }
}
