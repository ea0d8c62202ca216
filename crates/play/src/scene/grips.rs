//! The grasps of a play, in a list of fixed length: the state of a session relies on their places.
//! Hands come first. Only an empty place in the list gets other nodes; during a recording, only one
//! unused in the current segment, so that the list stays that of a single request.

use bendtwin_proto::v1::{
    Grasp, Tensor,
    grasp::{Attachment, CaptureHand, Region},
};

/// Places for grasps of nodes, beside one for each gripper.
const PLACES: usize = 8;
/// Most grasps of a request.
const MOST: usize = 32;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hold {
    Open,
    /// Closes after the next frame.
    Reaching,
    Closed,
}

#[derive(Clone, Debug)]
struct Grip {
    gripper: u32,
    /// The node that was pointed at.
    node: u32,
    /// `None` for what a hand of the capture holds.
    nodes: Option<Vec<u32>>,
    springs: bool,
    hold: Hold,
    used: bool,
}

/// The grasps of a play.
#[derive(Clone, Debug)]
pub(super) struct Grips(Vec<Grip>);

impl Grips {
    pub(super) fn new(hands: usize, grippers: usize) -> Self {
        let hand = |gripper| Grip {
            gripper,
            node: 0,
            nodes: None,
            springs: false,
            hold: Hold::Closed,
            used: true,
        };
        let free = || Grip {
            gripper: 0,
            node: 0,
            nodes: Some(vec![0]),
            springs: false,
            hold: Hold::Open,
            used: false,
        };
        let places = PLACES.max(grippers).min(MOST - hands);
        let own = (0..hands as u32).map(hand);
        Self(own.chain(std::iter::repeat_with(free).take(places)).collect())
    }

    /// Lets a gripper reach for a node and others. True if that is more than a recorded segment can have.
    pub(super) fn take(&mut self, gripper: u32, node: u32, nodes: Vec<u32>, springs: bool) -> bool {
        self.release(gripper);
        let is_free = |grip: &Grip| grip.nodes.is_some() && grip.hold == Hold::Open;
        let same = |grip: &Grip| {
            grip.gripper == gripper
                && grip.springs == springs
                && grip.nodes.as_ref() == Some(&nodes)
        };
        let find =
            |wanted: &dyn Fn(&Grip) -> bool| self.0.iter().position(|g| is_free(g) && wanted(g));
        let unused = find(&same).or_else(|| find(&|grip| !grip.used));
        // There are at least as many places as grippers, and this one holds nothing.
        let Some(place) = unused.or_else(|| find(&|_| true)) else { return false };
        self.0[place] =
            Grip { gripper, node, nodes: Some(nodes), springs, hold: Hold::Reaching, used: true };
        unused.is_none()
    }

    pub(super) fn release(&mut self, gripper: u32) {
        self.0.iter_mut().filter(|g| g.gripper == gripper).for_each(|g| g.hold = Hold::Open);
    }

    /// The node that a gripper is about to take.
    pub(super) fn reaches_for(&self, gripper: u32) -> Option<u32> {
        let reaching = |g: &&Grip| g.gripper == gripper && g.hold == Hold::Reaching;
        self.0.iter().find(reaching).map(|grip| grip.node)
    }

    /// True if a gripper holds something.
    pub(super) fn holds(&self, gripper: u32) -> bool {
        self.0.iter().any(|g| g.gripper == gripper && g.hold != Hold::Open)
    }

    /// Closings in the next frame, 1 or 0, shape [E].
    pub(super) fn closed(&self) -> impl Iterator<Item = u32> {
        self.0.iter().map(|grip| u32::from(grip.hold == Hold::Closed))
    }

    /// A frame has passed.
    pub(super) fn passed(&mut self) {
        let reaching = self.0.iter_mut().filter(|grip| grip.hold == Hold::Reaching);
        reaching.for_each(|grip| grip.hold = Hold::Closed);
    }

    pub(super) fn begin_segment(&mut self) {
        self.0.iter_mut().for_each(|grip| grip.used = grip.hold != Hold::Open);
    }

    /// Hands hold as in a list of the same hands; nothing else does.
    pub(super) fn hold_as(&mut self, closed: &[u32]) {
        for (e, grip) in self.0.iter_mut().enumerate() {
            let holds = grip.nodes.is_none() && closed.get(e) == Some(&1);
            grip.hold = if holds { Hold::Closed } else { Hold::Open };
        }
    }

    /// Grasps as a request has them, without the times at which they are closed.
    pub(super) fn wire(&self) -> Vec<Grasp> {
        let wire = |grip: &Grip| {
            let region = match &grip.nodes {
                None => Region::Hand(CaptureHand { hand: grip.gripper }),
                Some(nodes) => Region::Nodes(Tensor::pack(&[nodes.len()], nodes)),
            };
            let attachment = if grip.springs { Attachment::Springs } else { Attachment::Pin };
            Grasp {
                gripper: grip.gripper,
                region: Some(region),
                attachment: attachment.into(),
                ..Grasp::default()
            }
        };
        self.0.iter().map(wire).collect()
    }
}
