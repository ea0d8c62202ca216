//! The object's whole shape at the first frame: from a mesh that lies in the recording, or else
//! carved out of what cameras did not see through, or a guess from the convex parts of what was
//! observed.

pub(crate) mod carve;
pub(crate) mod complete;
pub(crate) mod sight;

use bendtwin_capture::raw::{Alignment, MeshFile, Recording};
use bendtwin_core::{
    CancelToken, Finding, Point, Severity,
    settings::ingest::{IngestSettings, Interior},
};
use bendtwin_mesh::{Bvh, Limits, Mesh, Similarity, align, convex_interior, parse};

use self::{
    carve::{FirstFrame, carve},
    complete::Shape,
    sight::first_views,
};
use crate::{Error, evidence::ShapeEvidence};

/// Most observed points whose distance from a mesh is measured.
const MAX_MEASURED_POINTS: usize = 4000;

/// A shape and where it comes from. `observed` and `hands` are the surfaces of the object and of the
/// hands as all cameras see them in the first frame [m]. `None` if there is nothing to complete with,
/// for which a finding says why where that is a surprise.
pub(crate) fn shape(
    recording: &Recording,
    observed: &[Point],
    hands: &[Point],
    settings: &IngestSettings,
    findings: &mut Vec<Finding>,
    cancel: &CancelToken,
) -> Result<Option<(Shape, ShapeEvidence)>, Error> {
    if let Some(file) = recording.mesh.as_ref().filter(|_| settings.completion.mesh) {
        let mesh = parse(&file.name, &file.bytes, &Limits::default())
            .map_err(|error| Error::Mesh { name: file.name.clone(), why: error.to_string() })?;
        // A mesh that can be read but not used is left out, and a finding says why.
        match from_mesh(mesh, file, observed, settings, findings) {
            Ok(None) => {}
            Ok(shape) => return Ok(shape),
            Err(error) => findings.push(unused(error_code(&error), &file.name, &error.to_string())),
        }
    }
    match settings.interior {
        Interior::Mesh | Interior::None => Ok(None),
        Interior::Carved => {
            let views = first_views(recording, settings, cancel)?;
            let ground = recording.environment.ground;
            let seen = FirstFrame { views: &views, object: observed, hands, ground };
            let carved = carve(&seen, settings.completion.spacing_m, cancel)?;
            Ok(carved.map(|(shape, under_hands)| {
                let sampled_surface = shape.surface.len();
                (shape, ShapeEvidence { sampled_surface, under_hands, ..without_mesh("carved") })
            }))
        }
        Interior::Convex => {
            let spacing_m = settings.completion.spacing_m as f32;
            let interior = convex_interior(observed, spacing_m)
                .map_err(|e| Error::Mesh { name: "convex".to_owned(), why: e.to_string() })?;
            Ok(Some((Shape { surface: Vec::new(), interior }, without_mesh("convex"))))
        }
    }
}

fn without_mesh(source: &str) -> ShapeEvidence {
    ShapeEvidence { source: source.to_owned(), scale: 1.0, ..ShapeEvidence::default() }
}

fn from_mesh(
    mesh: Mesh,
    file: &MeshFile,
    observed: &[Point],
    settings: &IngestSettings,
    findings: &mut Vec<Finding>,
) -> Result<Option<(Shape, ShapeEvidence)>, bendtwin_mesh::Error> {
    let completion = &settings.completion;
    let to_world = match &file.to_world {
        Some(given) => similarity(given),
        None if !completion.align => {
            let why = "nobody says where it lies, and completion.align is false";
            findings.push(unused("MESH_NOT_ALIGNED", &file.name, why));
            return Ok(None);
        }
        None => match align(&mesh, observed) {
            Ok(aligned) => aligned.similarity,
            Err(error) => {
                findings.push(unused(error_code(&error), &file.name, &error.to_string()));
                return Ok(None);
            }
        },
    };
    let mesh = mesh.moved(&to_world);
    let [error_m, error_p90_m] = misfit(&mesh, observed);
    let far = error_m.is_nan() || error_m > completion.max_error_m;
    if far {
        let why = format!(
            "the observed surface is {:.1} mm from it in the median (limit {:.1}): check its units, axes and pose",
            1e3 * error_m,
            1e3 * completion.max_error_m
        );
        findings.push(unused("MESH_DOES_NOT_FIT", &file.name, &why));
        return Ok(None);
    }
    let spacing_m = completion.spacing_m as f32;
    let surface = mesh.sample_surface(spacing_m, 0)?;
    let interior = match settings.interior {
        Interior::None => Vec::new(),
        Interior::Carved | Interior::Mesh | Interior::Convex => mesh.sample_interior(spacing_m)?,
    };
    let evidence = ShapeEvidence {
        source: file.name.clone(),
        aligned: file.to_world.is_none(),
        scale: to_world.scale,
        error_m,
        error_p90_m,
        sampled_surface: surface.len(),
        ..ShapeEvidence::default()
    };
    Ok(Some((Shape { surface, interior }, evidence)))
}

/// Median and 90th percentile of the observed surface's distance from the mesh [m]; infinite if
/// there is nothing to measure.
fn misfit(mesh: &Mesh, observed: &[Point]) -> [f64; 2] {
    let bvh = Bvh::new(mesh);
    let some = observed.iter().step_by(observed.len().div_ceil(MAX_MEASURED_POINTS).max(1));
    let mut distances: Vec<f64> =
        some.filter_map(|p| bvh.closest(*p)).map(|c| c.distance).collect();
    distances.sort_by(f64::total_cmp);
    [50, 90]
        .map(|share| distances.get(distances.len() * share / 100).copied().unwrap_or(f64::INFINITY))
}

fn similarity(given: &Alignment) -> Similarity {
    Similarity {
        rotation: given.rotation.map(|row| row.map(f64::from)),
        scale: f64::from(given.scale),
        translation: given.translation.map(f64::from),
    }
}

fn error_code(error: &bendtwin_mesh::Error) -> &'static str {
    bendtwin_core::Problem::reason(error)
}

fn unused(code: &str, name: &str, why: &str) -> Finding {
    Finding::from_sentence(
        Severity::Warning,
        code,
        format!(
            "the mesh `{name}` is not used: {why}; the capture has only what cameras saw of the surface"
        ),
    )
}

#[cfg(test)]
mod tests;
