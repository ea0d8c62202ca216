//! A model of MuJoCo: every node a body that slides along x, y and z, every spring a spatial tendon.
//!
//! A tendon pulls with `stiffness (l - springlength) + damping dl/dt`, which is a spring of the twin
//! with `stiffness = k / l0` and `damping = γ`; damping of a joint by `drag · m` is the drag. MuJoCo's
//! flexes have one material for a whole body and elements that a twin does not have, so that they
//! would lose more. Losses stand in [`LOST`] and at the top of the file.

mod text;

use std::{collections::BTreeSet, io::Write};

use bendtwin_core::{Point, Twin};

use self::text::{escaped, numbers};
use crate::{Error, Scene};

/// Parts of a twin that the file does not carry, for its comment.
const LOST: [&str; 6] = [
    "bending: triplets stand under <custom> as bend_ends, bend_stiffness, bend_damping and",
    "  bend_rest_angle; docs/formats/exchange.md has the callback that applies them",
    "twist of rods; the skin; contact between nodes of one object",
    "impacts: contact is MuJoCo's own, soft and without restitution, with the twin's friction",
    "velocity of control points (mocap bodies stand still between steps): their dashpots brake, as",
    "  with control_velocity `ignored`",
];

/// Radius of a node's ball where nodes of different objects do not collide [m].
const BALL_M: f32 = 0.005;
/// Objects that MuJoCo's bits can distinguish, without the ground's.
const MAX_OBJECTS: usize = 30;

/// Writes the model; a motion becomes its keyframes.
pub(crate) fn write(scene: &Scene<'_>, out: &mut impl Write) -> Result<(), Error> {
    let model = Model::of(scene.twin());
    let twin = scene.twin();
    writeln!(out, "<!-- A twin by {}. Metres, kilograms, seconds, z up.", bendtwin_core::BUILD)?;
    writeln!(out, "     Not carried:")?;
    for line in LOST {
        writeln!(out, "     {line}")?;
    }
    writeln!(out, "-->\n<mujoco model=\"{}\">", escaped(scene.name()))?;
    writeln!(
        out,
        "  <option timestep=\"{}\" gravity=\"{}\" integrator=\"Euler\"/>",
        twin.timing.dt_s(),
        numbers(&twin.environment.gravity)
    )?;
    model.write_custom(out)?;
    writeln!(out, "  <worldbody>")?;
    model.write_ground(out)?;
    model.write_controls(out)?;
    model.write_nodes(out)?;
    writeln!(out, "  </worldbody>")?;
    model.write_tendons(out)?;
    if scene.motion().is_some() {
        model.write_keyframes(scene, out)?;
    }
    writeln!(out, "</mujoco>")?;
    Ok(())
}

struct Model<'a> {
    twin: &'a Twin,
    /// Newtons per unit of force, kilograms per unit of mass.
    unit: f64,
    /// Control point and offset of each pinned node, shape [N].
    pins: Vec<Option<(u32, Point)>>,
    /// Object of each node counted from 0, shape [N].
    objects: Vec<usize>,
    /// Nodes of different objects collide.
    collides: bool,
    /// Radius of a node's ball [m].
    ball_m: f32,
}

impl<'a> Model<'a> {
    fn of(twin: &'a Twin) -> Self {
        let graph = &twin.graph;
        let mut pins = vec![None; graph.node_count()];
        for pin in &graph.pins {
            pins[pin.node as usize] = Some((pin.control, pin.offset_m));
        }
        let ids: Vec<u32> =
            graph.object_ids.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
        let objects =
            graph.object_ids.iter().map(|id| ids.binary_search(id).unwrap_or(0)).collect();
        let contact = &twin.params.contact;
        let collides = contact.between_objects
            && (2..=MAX_OBJECTS).contains(&ids.len())
            && contact.collision_distance_m > 0.0;
        let ball_m = if collides { contact.collision_distance_m / 2.0 } else { BALL_M };
        Self { twin, unit: twin.newtons_per_unit(), pins, objects, collides, ball_m }
    }

    /// Triplets as numbers.
    fn write_custom(&self, out: &mut impl Write) -> Result<(), Error> {
        let (triplets, params) = (&self.twin.graph.triplets, &self.twin.params);
        if triplets.is_empty() {
            return Ok(());
        }
        let scaled = |values: &[f32]| -> Vec<f64> {
            values.iter().map(|x| f64::from(*x) * self.unit).collect()
        };
        writeln!(out, "  <custom>")?;
        let mut numeric = |name: &str, values: String| {
            writeln!(out, "    <numeric name=\"{name}\" data=\"{values}\"/>")
        };
        numeric("bend_ends", numbers(triplets.as_flattened()))?;
        numeric("bend_stiffness", numbers(&scaled(&params.bend_stiffness)))?;
        numeric("bend_damping", numbers(&scaled(&params.bend_damping)))?;
        numeric("bend_rest_angle", numbers(&params.rest_angles_rad))?;
        writeln!(out, "  </custom>")?;
        Ok(())
    }

    /// The ground: lower by a ball's radius, so that nodes themselves stop where the twin's do.
    fn write_ground(&self, out: &mut impl Write) -> Result<(), Error> {
        let Some(ground) = self.twin.environment.ground else { return Ok(()) };
        let offset = ground.offset_m - self.ball_m;
        writeln!(
            out,
            "    <geom name=\"ground\" type=\"plane\" size=\"2 2 0.1\" pos=\"{}\" zaxis=\"{}\" \
             contype=\"1\" conaffinity=\"0\" priority=\"1\" friction=\"{} 0 0\"/>",
            numbers(&ground.normal.map(|n| n * offset)),
            numbers(&ground.normal),
            self.twin.params.contact.ground_friction
        )?;
        Ok(())
    }

    /// Control points as bodies that are moved from outside; pinned nodes are sites of them.
    fn write_controls(&self, out: &mut impl Write) -> Result<(), Error> {
        for (c, at) in self.twin.graph.control_rest.iter().enumerate() {
            writeln!(
                out,
                "    <body name=\"c{c}\" mocap=\"true\" pos=\"{}\">\n      <site name=\"c{c}\"/>",
                numbers(at)
            )?;
            for (n, pin) in self.pins.iter().enumerate() {
                if let Some((_, offset)) = pin.filter(|p| p.0 as usize == c) {
                    writeln!(out, "      <site name=\"n{n}\" pos=\"{}\"/>", numbers(&offset))?;
                }
            }
            writeln!(out, "    </body>")?;
        }
        Ok(())
    }

    fn write_nodes(&self, out: &mut impl Write) -> Result<(), Error> {
        let graph = &self.twin.graph;
        let friction = self.twin.params.contact.object_friction;
        for (n, at) in graph.rest_positions.iter().enumerate() {
            if self.pins[n].is_some() {
                continue;
            }
            let mass = f64::from(graph.masses[n]) * self.unit;
            let damping = mass * f64::from(self.twin.params.drag);
            let (kind, meets) = self.bits(n);
            writeln!(out, "    <body name=\"n{n}\" pos=\"{}\">", numbers(at))?;
            for axis in ["1 0 0", "0 1 0", "0 0 1"] {
                writeln!(
                    out,
                    "      <joint type=\"slide\" axis=\"{axis}\" damping=\"{damping}\"/>"
                )?;
            }
            writeln!(
                out,
                "      <geom type=\"sphere\" size=\"{}\" mass=\"{mass}\" contype=\"{kind}\" \
                 conaffinity=\"{meets}\" friction=\"{friction} 0 0\"/>\n      \
                 <site name=\"n{n}\"/>\n    </body>",
                self.ball_m
            )?;
        }
        Ok(())
    }

    /// Bits by which MuJoCo decides what collides: the first is the ground's, the others are those
    /// of objects.
    fn bits(&self, node: usize) -> (u32, u32) {
        if !self.collides {
            return (0, 1);
        }
        let own = 2_u32 << self.objects[node];
        (own, 0x7fff_ffff & !own)
    }

    fn write_tendons(&self, out: &mut impl Write) -> Result<(), Error> {
        let (graph, params) = (&self.twin.graph, &self.twin.params);
        let n = graph.node_count() as u32;
        let moves = |e: u32| e < n && self.pins[e as usize].is_none();
        let name = |e: u32| if e < n { format!("n{e}") } else { format!("c{}", e - n) };
        if !graph.springs.iter().flatten().any(|e| moves(*e)) {
            return Ok(());
        }
        writeln!(out, "  <tendon>")?;
        for (s, &[a, b]) in graph.springs.iter().enumerate() {
            // MuJoCo refuses tendons that cannot change; a spring between held ends moves nothing.
            if !(moves(a) || moves(b)) {
                continue;
            }
            let rest = f64::from(params.rest_lengths_m[s]);
            let stiffness =
                if rest > 0.0 { f64::from(params.spring_stiffness[s]) / rest } else { 0.0 };
            writeln!(
                out,
                "    <spatial width=\"0.0005\" springlength=\"{rest}\" stiffness=\"{}\" \
                 damping=\"{}\"><site site=\"{}\"/><site site=\"{}\"/></spatial>",
                stiffness * self.unit,
                f64::from(params.spring_dashpot[s]) * self.unit,
                name(a),
                name(b)
            )?;
        }
        writeln!(out, "  </tendon>")?;
        Ok(())
    }

    /// Frames as states to start from or to compare with; velocities are not known.
    fn write_keyframes(&self, scene: &Scene<'_>, out: &mut impl Write) -> Result<(), Error> {
        let rest = &self.twin.graph.rest_positions;
        writeln!(out, "  <keyframe>")?;
        for (frame, time) in scene.times_s().iter().enumerate() {
            let places = scene.points_at(frame);
            let moved = places.iter().zip(rest).zip(&self.pins).filter(|(_, pin)| pin.is_none());
            let qpos: Vec<f32> =
                moved.flat_map(|((p, q), _)| (0..3).map(move |a| p[a] - q[a])).collect();
            write!(out, "    <key time=\"{time}\" qpos=\"{}\"", numbers(&qpos))?;
            let controls = scene.controls_at(frame);
            if !controls.is_empty() {
                write!(out, " mpos=\"{}\"", numbers(controls.as_flattened()))?;
            }
            writeln!(out, "/>")?;
        }
        writeln!(out, "  </keyframe>")?;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
