//! Files: Landlock leaves one folder. Files that are open already stay usable.

use std::{io, path::Path};

use landlock::{
    ABI, Access, AccessFs, AccessNet, CompatLevel, Compatible, PathBeneath, PathFd, Ruleset,
    RulesetAttr, RulesetCreatedAttr, RulesetError, RulesetStatus, Scope, make_bitflags,
};

use super::Layer;

/// Newest rights that are asked for: files since Linux 5.13, TCP since 6.7, devices since 6.10,
/// signals and abstract sockets since 6.12.
const WANTED: ABI = ABI::V6;

/// Restricts this thread, and everything that it starts, to the files below `folder`, without
/// executing them.
pub(super) fn restrict_to(folder: &Path) -> io::Result<Layer> {
    let folder = PathFd::new(folder).map_err(io::Error::other)?;
    let status = restrict(folder).map_err(io::Error::other)?;
    Ok(match status {
        RulesetStatus::FullyEnforced => Layer::Full,
        RulesetStatus::PartiallyEnforced => Layer::Partial,
        RulesetStatus::NotEnforced => Layer::Missing,
    })
}

fn restrict(folder: PathFd) -> Result<RulesetStatus, RulesetError> {
    // Regular files only: the worker opens what it finds there afterwards, and a link would lead it
    // to its own files.
    let within = make_bitflags!(AccessFs::{
        ReadFile | ReadDir | WriteFile | Truncate | MakeReg | RemoveFile
    });
    let ruleset = Ruleset::default()
        .set_compatibility(CompatLevel::BestEffort)
        .handle_access(AccessFs::from_all(WANTED))?
        .handle_access(AccessNet::from_all(WANTED))?
        .scope(Scope::from_all(WANTED))?
        .create()?
        .add_rule(PathBeneath::new(folder, within))?;
    Ok(ruleset.restrict_self()?.ruleset)
}

/// Completeness of Landlock in this kernel: making a set of rules restricts nothing yet.
pub(super) fn available() -> Layer {
    let has = |abi: ABI| {
        let ruleset = Ruleset::default().set_compatibility(CompatLevel::HardRequirement);
        ruleset.handle_access(AccessFs::from_all(abi)).and_then(Ruleset::create).is_ok()
    };
    match (has(WANTED), has(ABI::V1)) {
        (true, _) => Layer::Full,
        (false, true) => Layer::Partial,
        (false, false) => Layer::Missing,
    }
}
