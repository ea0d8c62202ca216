//! A quality table in words, and beside it what recordings leave open ([`identifiability`]) and a
//! drawing of predicted motion ([`picture`]).

pub(crate) mod identifiability;
pub(crate) mod picture;

use bendtwin_client::{Client, TwinId};
use bendtwin_core::{Quality, Twin, quality::Assessment};
use bendtwin_eval::{Scale, assess};

/// The assessment of a twin of this machine by a table: that of its fit, where the table is its fit's.
pub(crate) fn of_twin(twin: &Twin, quality: &Quality) -> Assessment {
    let anew = || assess(quality, Scale::of_nodes(&twin.graph.rest_positions, &twin.graph.rods));
    quality.assessment.clone().unwrap_or_else(anew)
}

/// The assessment of a twin of the server by the table that it carries: that of its fit, where the
/// fit has left one.
pub(crate) async fn of_stored(
    client: &Client,
    name: TwinId,
) -> Result<Assessment, bendtwin_client::Error> {
    let twin = client.twins().get(name).await?;
    if let Some(assessment) = twin.quality.assessment {
        return Ok(assessment);
    }
    let geometry = client.twins().geometry(name).await?;
    Ok(assess(&twin.quality, Scale::of_nodes(&geometry.rest_positions, &geometry.rods)))
}

/// The fast variant in a line; `None` without one. `substeps` are those of the twin.
pub(crate) fn fast(quality: &Quality, substeps: u32) -> Option<String> {
    let fast = quality.fast.as_ref()?;
    if fast.substeps >= substeps {
        return Some(format!("{substeps} substeps a frame as well: fewer would stray too far"));
    }
    let softened = if fast.rate_limit.is_some() { ", softened" } else { "" };
    Some(format!(
        "{} substeps a frame ({:.1} times fewer{softened}), {:.2} mm from the exact twin on average, {:.1} mm at most, where nodes travel {:.0} mm",
        fast.substeps,
        f64::from(substeps) / f64::from(fast.substeps.max(1)),
        1e3 * fast.mean_deviation_m,
        1e3 * fast.max_deviation_m,
        1e3 * fast.mean_travel_m,
    ))
}

/// The planner's twin in a line, if there is one.
pub(crate) fn planner(quality: &Quality) -> Option<String> {
    let planner = quality.planner.as_ref()?;
    Some(format!(
        "{} nodes, {} springs, {} triplets, {} substeps a frame, {:.2} mm from the exact twin on average, {:.1} mm at most, {:.1} % of the way that its skin travels",
        planner.nodes,
        planner.springs,
        planner.triplets,
        planner.substeps,
        1e3 * planner.mean_deviation_m,
        1e3 * planner.max_deviation_m,
        1e2 * planner.share_of_travel(),
    ))
}

#[cfg(test)]
mod tests {
    use bendtwin_core::{FastVariant, PlannerQuality};

    use super::*;

    #[test]
    fn the_fast_variant_takes_a_line() {
        let fast = FastVariant {
            substeps: 20,
            rate_limit: None,
            mean_deviation_m: 4.2e-4,
            max_deviation_m: 3e-3,
            mean_travel_m: 0.1,
            frames: 30,
        };
        let quality = Quality { fast: Some(fast), ..Quality::default() };
        let line = super::fast(&quality, 100).unwrap();
        assert!(line.contains("5.0 times fewer)") && line.contains("0.42 mm"), "{line}");
        assert!(super::fast(&quality, 20).unwrap().contains("as well"));
        assert_eq!(super::fast(&Quality::default(), 20), None);
    }

    #[test]
    fn the_planners_twin_takes_a_line() {
        let planner = PlannerQuality {
            nodes: 80,
            springs: 500,
            triplets: 90,
            substeps: 12,
            mean_deviation_m: 2e-3,
            max_deviation_m: 1e-2,
            mean_travel_m: 0.1,
            frames: 30,
            actions: 16,
        };
        let quality = Quality { planner: Some(planner), ..Quality::default() };
        let line = super::planner(&quality).unwrap();
        assert!(line.contains("80 nodes") && line.contains("2.0 % of the way"), "{line}");
        assert_eq!(super::planner(&Quality::default()), None);
    }
}
