//! The arrays of a twin's identifiability report, by node and by skin point; its numbers are in the
//! quality table. A file of any version may have them, and older programs pass over them.

use safetensors::Dtype;

use super::{FormatError, Raw, Tensors, raw};
use crate::{Identifiability, Quality};

const NODE_REGIONS: &str = "identifiability.node_region";
const POINT_SD: &str = "identifiability.point_sd";

/// Tensors of a report; those without content are left out.
pub(super) fn tensors(report: &Identifiability) -> Vec<(&'static str, Raw<'static>)> {
    let mut tensors = Vec::new();
    if !report.node_regions.is_empty() {
        let regions = &report.node_regions;
        tensors.push((NODE_REGIONS, raw(Dtype::U8, &[regions.len()], regions)));
    }
    if !report.point_sd_m.is_empty() {
        let points = &report.point_sd_m;
        tensors.push((POINT_SD, raw(Dtype::F32, &[points.len()], points)));
    }
    tensors
}

impl Tensors<'_> {
    /// Completes the report of a quality table, if it has one.
    pub(super) fn complete_identifiability(
        &self,
        quality: &mut Quality,
    ) -> Result<(), FormatError> {
        let Some(report) = &mut quality.identifiability else { return Ok(()) };
        if self.has(NODE_REGIONS) {
            report.node_regions = self.read(NODE_REGIONS, Dtype::U8, None)?;
        }
        if self.has(POINT_SD) {
            report.point_sd_m = self.read(POINT_SD, Dtype::F32, None)?;
        }
        Ok(())
    }
}
