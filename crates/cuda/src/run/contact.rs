//! Arrays of contact between nodes: candidates of each node, and states that blocks exchange.

use bendtwin_engine::{Error, Model, constants::MAX_PARTNERS};

use crate::{
    device::{
        args::InstanceArgs,
        memory::{Buffer, end_of},
        queue::Queue,
    },
    plan::resident::has_contact,
};

/// Contact's arrays of simulations that run concurrently.
pub(crate) struct Contact {
    partners: Buffer<u32>,
    counts: Buffer<u32>,
    scratch: Buffer<u32>,
    x: Buffer<[f32; 4]>,
    v: Buffer<[f32; 4]>,
    start: Buffer<[f32; 4]>,
    /// First node of each in these.
    starts: Vec<usize>,
}

impl Contact {
    /// Contact of simulations with the given numbers of nodes.
    pub(crate) fn new(queue: &Queue, nodes: impl Iterator<Item = usize>) -> Result<Self, Error> {
        let mut starts = vec![0];
        for nodes in nodes {
            starts.push(end_of(&starts) + nodes);
        }
        let (n, stream) = (end_of(&starts), &queue.stream);
        Ok(Self {
            partners: Buffer::empty(stream, n * MAX_PARTNERS)?,
            counts: Buffer::empty(stream, n)?,
            scratch: Buffer::empty(stream, n)?,
            x: Buffer::empty(stream, n)?,
            v: Buffer::empty(stream, n)?,
            start: Buffer::empty(stream, n)?,
            starts,
        })
    }

    /// Gives an instance the arrays of one of the simulations.
    pub(crate) fn place(&self, index: usize, args: &mut InstanceArgs) {
        let at = self.starts[index];
        args.contact.partners = self.partners.at(at * MAX_PARTNERS);
        args.contact.partner_counts = self.counts.at(at);
        args.contact.partner_scratch = self.scratch.at(at);
        args.contact.x = self.x.at(at);
        args.contact.v = self.v.at(at);
        args.contact.start = self.start.at(at);
        args.contact.max_partners = MAX_PARTNERS as u32;
    }
}

/// Nodes that contact's arrays need for a model.
pub(crate) fn contact_nodes(model: &Model) -> usize {
    if has_contact(model) { model.graph.node_count() } else { 0 }
}
