//! The planner's twin in the twin file: a nested twin file, as the bytes of a tensor, and the numbers of
//! its nodes.

use safetensors::Dtype;

use super::{FormatError, Raw, Tensors, Twin, WITH_PLANNER, raw};
use crate::PlannersTwin;

/// The tensor that holds the file of the planner's twin.
const FILE: &str = "planner.twin";
/// The tensor that says which nodes of the twin are its nodes.
const NODES: &str = "planner.nodes";

/// Tensors of a planner's twin.
///
/// # Errors
/// If it contradicts itself.
pub(super) fn tensors(
    planner: &PlannersTwin,
) -> Result<[(&'static str, Raw<'static>); 2], FormatError> {
    let file = planner.twin.encode()?;
    Ok([
        (FILE, raw(Dtype::U8, &[file.len()], &file)),
        (NODES, raw(Dtype::U32, &[planner.nodes.len()], &planner.nodes)),
    ])
}

impl Tensors<'_> {
    /// The planner's twin.
    pub(super) fn planner(&self) -> Result<PlannersTwin, FormatError> {
        let file: Vec<u8> = self.read(FILE, Dtype::U8, None)?;
        // A nested file with a planner's twin could nest without end.
        let twin = Twin::decode_before(&file, WITH_PLANNER)?;
        Ok(PlannersTwin { nodes: self.read(NODES, Dtype::U32, None)?, twin: Box::new(twin) })
    }
}

impl Twin {
    /// Checks the planner's twin, and that its figures exist if and only if it does.
    pub(super) fn check_planner(&self) -> Result<(), FormatError> {
        let fail = |m: String| Err(FormatError::Inconsistent(m));
        match (&self.planner, &self.quality.planner) {
            (None, None) => Ok(()),
            (Some(_), None) => fail("the planner's twin has no figures".into()),
            (None, Some(_)) => {
                fail("there are figures of a planner's twin, and no such twin".into())
            }
            (Some(planner), Some(figures)) => {
                planner.check(self).or_else(fail)?;
                planner.twin.check()?;
                figures.check(&planner.twin).or_else(fail)
            }
        }
    }
}
