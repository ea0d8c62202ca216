//! A graph as the blocks of a team see it: each block's nodes and halo by local index, half-springs
//! in rows for its warps, triplets, pins, and the halos that a node's new state goes to.

mod arms;
mod banks;
mod order;
mod reporters;
mod rows;

use bendtwin_core::Graph;
use bendtwin_engine::Error;

use self::{
    reporters::first_ends,
    rows::{Rows, lanes_for},
};
use crate::{
    device::args::{LocalPin, Share, Triplet},
    plan::partition::partition,
};

/// Floats between the sums of a half-spring, and those of a pair of slots: each sum of a warp
/// stands together.
pub(crate) const SUMS_APART: u32 = 32;
pub(crate) const PAIR_SUMS: u32 = 6 * SUMS_APART;
/// No spring: a slot that fills up a row.
pub(crate) const NONE: u32 = u32::MAX;
/// No triplet: a lane without a reference in a slot.
pub(crate) const NO_ARM: u32 = u32::MAX;
/// Marks control points while the number of local nodes is not known yet.
const CONTROL: u32 = 1 << 31;
/// Local indices have 16 bits.
const MAX_LOCAL: usize = 1 << 16;

/// A graph in shares, on the host.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    pub(crate) shares: Vec<Share>,
    pub(crate) nodes: Vec<u32>,
    pub(crate) rows: Vec<u32>,
    /// Spring of each half-spring, [`NONE`] where one only fills up; shape [pairs of slots, 32, 2].
    pub(crate) springs: Vec<u32>,
    /// Local index of the other end.
    pub(crate) others: Vec<u32>,
    /// First of each spring's three sums for its gradient, [`SUMS_APART`] floats apart.
    pub(crate) sum_of: Vec<u32>,
    /// Pairs with sums before each row, by the same index as `rows`.
    pub(crate) sum_rows: Vec<u32>,
    /// All pairs with sums.
    pub(crate) sum_pairs: u32,
    pub(crate) triplets: Vec<Triplet>,
    /// Index in the graph.
    pub(crate) triplet_of: Vec<u32>,
    /// First of each rod's inner nodes among the triplets, behind the graph's, and their end; shape
    /// [R + 1]. Only where one block has all nodes.
    pub(crate) rod_turns: Vec<u32>,
    /// Share of its rod's length at each of these inner nodes.
    pub(crate) rod_shares: Vec<f32>,
    /// First slot of references to triplets of each row, by the same index as `rows`.
    pub(crate) arm_rows: Vec<u32>,
    /// References, [`NO_ARM`] where a lane has none; shape [slots, 32].
    pub(crate) arm_refs: Vec<u32>,
    pub(crate) local_pins: Vec<LocalPin>,
    pub(crate) exports: Vec<u32>,
    pub(crate) export_refs: Vec<u32>,
    pub(crate) control_base: u32,
    pub(crate) controls: u32,
    pub(crate) max_triplets: u32,
    /// Pairs of half-springs of a share's nodes, those that fill up included.
    pub(crate) max_pairs: u32,
    /// And of its nodes and control points.
    pub(crate) max_all_pairs: u32,
    pub(crate) max_rows: u32,
    /// Pairs of slots of a row.
    pub(crate) max_row_pairs: u32,
    /// Pairs that every row has.
    pub(crate) min_row_pairs: u32,
    /// Pairs of slots of a row that have sums.
    pub(crate) max_sum_pairs: u32,
    pub(crate) lanes: u32,
}

/// Half-springs and triplets by endpoint.
pub(crate) struct Incidence {
    starts: Vec<u32>,
    /// (spring, other end, whether this end reports the gradient).
    springs: Vec<(u32, u32, bool)>,
    triplet_starts: Vec<u32>,
    triplets: Vec<u32>,
}

impl Layout {
    /// [`Layout::cut`] for a single cut.
    #[cfg(test)]
    pub(crate) fn new(graph: &Graph, blocks: usize, threads: u32) -> Result<Self, Error> {
        Self::cut(graph, &Incidence::new(graph), blocks, threads)
    }

    /// Cuts a checked graph for a team of `blocks` blocks, each with about `threads` threads.
    pub(crate) fn cut(
        graph: &Graph,
        incidence: &Incidence,
        blocks: usize,
        threads: u32,
    ) -> Result<Self, Error> {
        let mut parts = partition(graph, blocks);
        let largest = parts.iter().map(Vec::len).max().unwrap_or(0);
        let lanes = lanes_for(largest, incidence, threads);
        // Nodes of similar valence share a row, so that few of its slots stay empty; among them
        // neighbours in space, which read the same nodes at the same time.
        let pairs = |i: u32| incidence.springs_of(i).len().div_ceil(2 * lanes as usize);
        for part in &mut parts {
            part.sort_by_key(|&i| (std::cmp::Reverse(pairs(i)), i));
        }
        let mut this = Self {
            lanes,
            controls: graph.control_count() as u32,
            sum_of: vec![NONE; graph.springs.len()],
            ..Self::default()
        };
        let mut owner = vec![0_u32; graph.node_count()];
        for (b, part) in parts.iter().enumerate() {
            part.iter().for_each(|&i| owner[i as usize] = b as u32);
        }
        let mut local = vec![NONE; graph.node_count()];
        let mut halos = Vec::with_capacity(blocks);
        for (b, part) in parts.iter().enumerate() {
            halos.push(this.add_share(graph, incidence, &owner, b as u32, part, &mut local));
        }
        this.min_row_pairs = this.fewest_pairs();
        this.place_controls()?;
        this.add_exports(&parts, &halos, &owner, &mut local);
        Ok(this)
    }

    /// Adds a block's share; returns its halo. `local` is scratch, [`NONE`] everywhere.
    fn add_share(
        &mut self,
        graph: &Graph,
        incidence: &Incidence,
        owner: &[u32],
        block: u32,
        part: &[u32],
        local: &mut [u32],
    ) -> Vec<u32> {
        let n = graph.node_count();
        let mut share = Share {
            own: part.len() as u32,
            nodes: self.nodes.len() as u32,
            row: self.rows.len() as u32,
            triplet: self.triplets.len() as u32,
            pin: self.local_pins.len() as u32,
            slot: self.shares.last().map_or(0, |s| s.slot + s.own),
            ..Share::default()
        };
        let mut triplets = triplets_of(graph, incidence, part);
        let halo = halo_of(graph, incidence, owner, block, part, &triplets);
        for (at, &i) in part.iter().chain(&halo).enumerate() {
            local[i as usize] = at as u32;
        }
        let find =
            |e: u32| if (e as usize) < n { local[e as usize] } else { CONTROL | (e - n as u32) };
        share.local = (part.len() + halo.len()) as u32;
        // The mark of control points is a multiple of the banks.
        let ends: Vec<_> = triplets.iter().map(|&t| graph.triplets[t as usize].map(find)).collect();
        triplets = order::arrange(&ends).into_iter().map(|at| triplets[at]).collect();

        let mut rows = Rows { lanes: self.lanes as usize, layout: self };
        let before = rows.pairs();
        share.rows = rows.add(
            part.len(),
            |i| i as u32,
            |i| {
                let half = incidence.springs_of(part[i]).iter();
                half.map(|&(s, other, owns)| (s, find(other), owns)).collect()
            },
        );
        let pairs = rows.pairs() - before;
        let own = |e: u32| (e as usize) < n && owner[e as usize] == block;
        share.control_rows = rows.add(
            graph.control_count(),
            |c| CONTROL | c as u32,
            |c| {
                let half = incidence.springs_of((n + c) as u32).iter();
                half.filter(|h| own(h.1)).map(|&(s, other, _)| (s, find(other), false)).collect()
            },
        );
        rows.end();
        let all_pairs = rows.pairs() - before;
        self.max_pairs = self.max_pairs.max(pairs);
        self.max_all_pairs = self.max_all_pairs.max(all_pairs);
        self.max_rows = self.max_rows.max(share.rows);

        let mut of_ends: Vec<Vec<u32>> = vec![Vec::new(); part.len() + graph.control_count()];
        for (at, &t) in triplets.iter().enumerate() {
            let ends = graph.triplets[t as usize];
            let owned = reporter(graph, owner, ends) == Some(block);
            let [i, j, k] = ends;
            for (role, end) in [(0, i), (1, k), (2, j)] {
                let reference = arms::reference(at as u32, role);
                if own(end) {
                    of_ends[local[end as usize] as usize].push(reference);
                } else if end as usize >= n && owned {
                    of_ends[part.len() + end as usize - n].push(reference);
                }
            }
            self.triplet_of.push(t);
            self.triplets.push(triplet(ends.map(|e| encode(find(e))), owned));
        }
        share.triplets = triplets.len() as u32;
        // Otherwise a rod's nodes would be in several blocks.
        let is_whole = part.len() == n;
        let mut turns_of = vec![Vec::new(); of_ends.len()];
        let turns =
            if is_whole { self.add_rods(graph, share.triplets, local, &mut turns_of) } else { 0 };
        let (nodes, controls) = of_ends.split_at(part.len());
        self.add_arms(nodes, &turns_of[..part.len()]);
        self.add_arms(controls, &turns_of[part.len()..]);
        self.end_arms();

        for (p, pin) in graph.pins.iter().enumerate() {
            let at = local[pin.node as usize];
            if at != NONE {
                self.local_pins.push(LocalPin { local: at, pin: p as u32 });
                share.pins += 1;
            }
        }
        for &i in part.iter().chain(&halo) {
            local[i as usize] = NONE;
            self.nodes.push(i);
        }
        self.max_triplets = self.max_triplets.max(share.triplets + turns);
        self.shares.push(share);
        halo
    }

    /// Adds every inner node of a rod as a triplet with its neighbours, behind `before` that bend;
    /// returns how many.
    fn add_rods(
        &mut self,
        graph: &Graph,
        before: u32,
        local: &[u32],
        turns_of: &mut [Vec<u32>],
    ) -> u32 {
        let mut at = before;
        self.rod_turns.push(at);
        for rod in &graph.rods {
            let arm = graph.has_arm(rod).then(|| rod.len().saturating_sub(3));
            for (place, ends) in rod.windows(3).map(|w| [w[0], w[1], w[2]]).enumerate() {
                let is_arm = arm == Some(place);
                let ends = ends.map(|e| local[e as usize]);
                for (role, end) in [(0, ends[0]), (1, ends[2]), (2, ends[1])] {
                    turns_of[end as usize].push(arms::reference(at, role));
                }
                // It has no parameters of a triplet: any triplet's will do.
                self.triplet_of.push(0);
                self.triplets.push(triplet(ends.map(encode), is_arm));
                at += 1;
            }
            self.rod_turns.push(at);
            self.rod_shares.extend(graph.rod_shares(rod));
        }
        at - before
    }

    /// Adds the references of endpoints to triplets and to turns of rods, in rows as their
    /// half-springs. Turns come behind: without stiffness they change nothing, not even the order of
    /// sums.
    fn add_arms(&mut self, of_triplets: &[Vec<u32>], of_turns: &[Vec<u32>]) {
        let lanes = self.lanes as usize;
        let a_row = rows::WARP / lanes;
        for (triplets, turns) in of_triplets.chunks(a_row).zip(of_turns.chunks(a_row)) {
            self.end_arms();
            for refs in [triplets, turns] {
                let slots = arms::arrange(lanes, refs.to_vec());
                self.arm_refs.extend(slots.as_flattened());
            }
        }
    }

    fn end_arms(&mut self) {
        self.arm_rows.push((self.arm_refs.len() / rows::WARP) as u32);
    }

    fn fewest_pairs(&self) -> u32 {
        let rows = self.shares.iter().flat_map(|s| s.row..s.row + s.rows);
        let pairs = rows.map(|r| self.rows[r as usize + 1] - self.rows[r as usize]);
        pairs.min().unwrap_or(0)
    }

    /// Places control points behind the largest block's nodes, at the same index in all blocks.
    fn place_controls(&mut self) -> Result<(), Error> {
        self.control_base = self.shares.iter().map(|s| s.local).max().unwrap_or(0);
        let stride = self.stride() as usize;
        if stride >= MAX_LOCAL / 2 {
            return Err(Error::InvalidModel(format!(
                "a block would see {stride} nodes and control points, {} is the most: use a coarser twin",
                MAX_LOCAL / 2
            )));
        }
        let base = self.control_base;
        for other in self.others.iter_mut().filter(|o| **o & CONTROL != 0) {
            *other = base + (*other & !CONTROL);
        }
        for end in self.triplets.iter_mut().flat_map(|t| [&mut t.i, &mut t.j, &mut t.k]) {
            if *end & SHORT_CONTROL != 0 {
                *end = base as u16 + (*end & !SHORT_CONTROL);
            }
        }
        Ok(())
    }

    /// Slot of each node on a tape that this cut writes, by its index in the graph.
    pub(crate) fn tape_slots(&self) -> Vec<u32> {
        let own = |s: &Share| &self.nodes[s.nodes as usize..][..s.own as usize];
        let mut slots = vec![0; self.shares.iter().map(|s| s.own as usize).sum()];
        for (slot, &node) in self.shares.iter().flat_map(own).enumerate() {
            slots[node as usize] = slot as u32;
        }
        slots
    }

    /// Float4s of one array of local states.
    pub(crate) fn stride(&self) -> u32 {
        self.control_base + self.controls
    }

    /// Halos that each node's owner writes it to.
    fn add_exports(
        &mut self,
        parts: &[Vec<u32>],
        halos: &[Vec<u32>],
        owner: &[u32],
        local: &mut [u32],
    ) {
        let mut exported: Vec<Vec<Vec<u32>>> =
            parts.iter().map(|p| vec![Vec::new(); p.len()]).collect();
        for part in parts {
            for (at, &i) in part.iter().enumerate() {
                local[i as usize] = at as u32;
            }
        }
        for (block, halo) in halos.iter().enumerate() {
            for (at, &i) in halo.iter().enumerate() {
                let there = (block << 16 | (parts[block].len() + at)) as u32;
                exported[owner[i as usize] as usize][local[i as usize] as usize].push(there);
            }
        }
        for (share, nodes) in self.shares.iter_mut().zip(exported) {
            share.export_start = self.exports.len() as u32;
            for refs in nodes {
                self.exports.push(self.export_refs.len() as u32);
                self.export_refs.extend(refs);
            }
            self.exports.push(self.export_refs.len() as u32);
        }
    }
}

fn triplet([i, j, k]: [u16; 3], owned: bool) -> Triplet {
    Triplet { i, j, k, owned: u16::from(owned) }
}

/// The control mark in 16 bits.
const SHORT_CONTROL: u16 = 1 << 15;

/// A local index in 16 bits; what does not fit is refused by `place_controls`.
fn encode(local: u32) -> u16 {
    let mark = if local & CONTROL != 0 { SHORT_CONTROL } else { 0 };
    mark | (local & u32::from(SHORT_CONTROL - 1)) as u16
}

impl Incidence {
    /// Incidence of a checked graph.
    pub(crate) fn new(graph: &Graph) -> Self {
        let ends = graph.node_count() + graph.control_count();
        let mut starts = vec![0_u32; ends + 1];
        for &e in graph.springs.iter().flatten() {
            starts[e as usize + 1] += 1;
        }
        let mut triplet_starts = vec![0_u32; ends + 1];
        for &e in graph.triplets.iter().flatten() {
            triplet_starts[e as usize + 1] += 1;
        }
        for e in 0..ends {
            starts[e + 1] += starts[e];
            triplet_starts[e + 1] += triplet_starts[e];
        }
        let mut springs = vec![(0, 0, false); 2 * graph.springs.len()];
        let mut cursor = starts.clone();
        for (s, (&[a, b], first)) in graph.springs.iter().zip(first_ends(graph)).enumerate() {
            for (end, other, owns) in [(a, b, first), (b, a, !first)] {
                springs[cursor[end as usize] as usize] = (s as u32, other, owns);
                cursor[end as usize] += 1;
            }
        }
        let mut triplets = vec![0; 3 * graph.triplets.len()];
        let mut cursor = triplet_starts.clone();
        for (t, ends) in graph.triplets.iter().enumerate() {
            for &e in ends {
                triplets[cursor[e as usize] as usize] = t as u32;
                cursor[e as usize] += 1;
            }
        }
        Self { starts, springs, triplet_starts, triplets }
    }

    fn springs_of(&self, end: u32) -> &[(u32, u32, bool)] {
        &self.springs[self.starts[end as usize] as usize..self.starts[end as usize + 1] as usize]
    }

    fn triplets_of(&self, end: u32) -> &[u32] {
        let starts = &self.triplet_starts;
        &self.triplets[starts[end as usize] as usize..starts[end as usize + 1] as usize]
    }
}

/// Triplets with an end in a part, ascending.
fn triplets_of(graph: &Graph, incidence: &Incidence, part: &[u32]) -> Vec<u32> {
    let mut found: Vec<u32> =
        part.iter().flat_map(|&i| incidence.triplets_of(i)).copied().collect();
    found.sort_unstable();
    found.dedup();
    // Neighbours in memory are neighbours in the graph.
    found.sort_by_key(|&t| (graph.triplets[t as usize][1], t));
    found
}

/// Nodes of other blocks that a part's elements reach, by block.
fn halo_of(
    graph: &Graph,
    incidence: &Incidence,
    owner: &[u32],
    block: u32,
    part: &[u32],
    triplets: &[u32],
) -> Vec<u32> {
    let n = graph.node_count();
    let by_springs = part.iter().flat_map(|&i| incidence.springs_of(i)).map(|h| h.1);
    let by_triplets = triplets.iter().flat_map(|&t| graph.triplets[t as usize]);
    let mut halo: Vec<u32> = by_springs
        .chain(by_triplets)
        .filter(|&e| (e as usize) < n && owner[e as usize] != block)
        .collect();
    halo.sort_unstable_by_key(|&i| (owner[i as usize], i));
    halo.dedup();
    halo
}

/// The block that reports a triplet's gradient: its centre's, or that of another node in it.
fn reporter(graph: &Graph, owner: &[u32], [i, j, k]: [u32; 3]) -> Option<u32> {
    let n = graph.node_count();
    [j, i, k].into_iter().find(|&e| (e as usize) < n).map(|e| owner[e as usize])
}

#[cfg(test)]
mod tests;
