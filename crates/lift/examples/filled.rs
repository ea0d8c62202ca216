//! Carves a recording that has a mesh as if it had none, and compares:
//! `cargo run --release -p bendtwin-lift --example filled -- RECORDING...`
//!
//! Prints the share of the mesh's inside that is filled, within the spacing of the points; the
//! share of the points that lie farther outside than that; the same share of the inside within 3 cm
//! of what cameras see of hands; and how many control points hold the object.

use bendtwin_capture::{
    Limits,
    raw::{self, Alignment, Recording},
};
use bendtwin_core::{
    CancelToken, Point, geometry::point_distance, settings::ingest::IngestSettings,
};
use bendtwin_lift::lift;
use bendtwin_mesh::{Mesh, Similarity, Solid, parse};

type Failure = Box<dyn std::error::Error>;

/// Distance from a hand's control points within which material counts as held [m].
const HELD_M: f64 = 0.03;

fn main() -> Result<(), Failure> {
    println!("recording | inside filled | near the hand | outside | control points that hold");
    for path in std::env::args().skip(1) {
        let recording = raw::open(path.as_ref(), &Limits::default())?;
        let mut settings = IngestSettings::default();
        settings.completion.mesh = false;
        let lifted = lift(&recording, &settings, None, &mut (), &CancelToken::default())?;
        let (object, sequence) = (&lifted.capture.object, &lifted.capture.sequences[0]);
        let made = [&object.completed_surface[..], &object.interior].concat();
        let all = [sequence.points_at(0), &made].concat();
        let spacing_m = settings.completion.spacing_m;

        let solid = Solid::new(&mesh(&recording)?);
        let inside = mesh(&recording)?.sample_interior(spacing_m as f32)?;
        let filled = |of: &[Point]| share(of, |p| within(p, &all, spacing_m));
        let held: Vec<Point> =
            inside.iter().copied().filter(|p| within(p, sequence.controls_at(0), HELD_M)).collect();
        let far = |p: &Point| solid.surface().closest(*p).is_some_and(|c| c.distance > spacing_m);
        let outside = share(&made, |p| !solid.contains(*p) && far(p));
        let [holding, controls] =
            lifted.evidence.hands.iter().fold([0, 0], |[h, c], e| [h + e.holding, c + e.controls]);
        println!(
            "{path} | {:.1} % of {} | {:.1} % of {} | {:.1} % of {} | {holding} of {controls}",
            100.0 * filled(&inside),
            inside.len(),
            100.0 * filled(&held),
            held.len(),
            100.0 * outside,
            made.len()
        );
    }
    Ok(())
}

/// The mesh of a recording, where the object lies.
fn mesh(recording: &Recording) -> Result<Mesh, Failure> {
    let file = recording.mesh.as_ref().ok_or("the recording has no mesh")?;
    let Alignment { rotation, scale, translation } =
        file.to_world.ok_or("nobody says where the mesh lies")?;
    let to_world = Similarity {
        rotation: rotation.map(|row| row.map(f64::from)),
        scale: f64::from(scale),
        translation: translation.map(f64::from),
    };
    Ok(parse(&file.name, &file.bytes, &bendtwin_mesh::Limits::default())?.moved(&to_world))
}

fn share(of: &[Point], is: impl Fn(&Point) -> bool) -> f64 {
    of.iter().filter(|p| is(p)).count() as f64 / of.len().max(1) as f64
}

fn within(place: &Point, of: &[Point], reach_m: f64) -> bool {
    of.iter().any(|p| point_distance(*p, *place) <= reach_m)
}
