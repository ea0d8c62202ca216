//! Teams of blocks: how many simulate an instance, and how they exchange state.

use super::Capabilities;

/// Threads of a block that is a team by itself, and of one among several.
pub(crate) const BLOCK_THREADS: u32 = 1024;
pub(crate) const TEAM_THREADS: u32 = 512;

/// Shape of a team: the way in which its blocks exchange state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum TeamShape {
    /// A single block.
    Block = 0,
    /// A cluster of blocks through distributed shared memory.
    Cluster = 1,
    /// Any blocks through global memory.
    Grid = 2,
}

/// A team of blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Team {
    pub(crate) shape: TeamShape,
    pub(crate) blocks: u32,
    /// Threads that a block may have.
    pub(crate) threads: u32,
    /// Instances of one model that it simulates together.
    pub(crate) instances: u32,
}

/// Notation of a named team: `block`, `block4` (instances), `cluster16` or `grid66` (blocks), each
/// perhaps with the threads of a block: `cluster16@256`.
impl std::str::FromStr for Team {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let (s, given) = match s.split_once('@') {
            Some((s, threads)) => (s, threads.parse::<u32>().ok()),
            None => (s, None),
        };
        let digits = s.trim_start_matches(|c: char| !c.is_ascii_digit());
        let name = &s[..s.len() - digits.len()];
        let number = match digits {
            "" => Ok(1),
            digits => digits.parse::<u32>().map_err(|e| format!("`{s}`: {e}")),
        }?;
        let team = |shape, blocks, threads, instances| {
            let threads = given.unwrap_or(threads).clamp(64, 1024).next_multiple_of(32);
            Self { shape, blocks, threads, instances }
        };
        match (name, number) {
            ("block", 1 | 2 | 4) => Ok(team(TeamShape::Block, 1, BLOCK_THREADS, number)),
            ("cluster", 2 | 4 | 8 | 16) => Ok(team(TeamShape::Cluster, number, BLOCK_THREADS, 1)),
            ("grid", 1..=1024) => Ok(team(TeamShape::Grid, number, TEAM_THREADS, 1)),
            _ => Err(format!(
                "`{s}` is no team: use block, block2, block4, cluster2 to cluster16 or grid1 to grid1024"
            )),
        }
    }
}

impl Team {
    /// Makes one block of a team of several.
    pub(crate) fn keep_together(&mut self) {
        if self.shape != TeamShape::Block {
            (self.shape, self.blocks, self.threads) = (TeamShape::Block, 1, BLOCK_THREADS);
        }
    }

    /// Checks that such a team fits a device; the error says why it does not.
    pub(crate) fn check(&self, capabilities: &Capabilities) -> Result<(), String> {
        let most = match self.shape {
            TeamShape::Block => 1,
            TeamShape::Cluster => capabilities.cluster,
            TeamShape::Grid => capabilities.processors,
        };
        if self.blocks > most {
            return Err(format!("{self}: this device has room for {most} blocks"));
        }
        Ok(())
    }
}

impl std::fmt::Display for Team {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { shape, blocks, instances, .. } = self;
        match (shape, instances) {
            (TeamShape::Block, 1) => write!(f, "a block per instance"),
            (TeamShape::Block, n) => write!(f, "{n} instances interleaved in a block"),
            (TeamShape::Cluster, _) => write!(f, "a cluster of {blocks} blocks per instance"),
            (TeamShape::Grid, _) => write!(f, "a grid of {blocks} blocks per instance"),
        }
    }
}
