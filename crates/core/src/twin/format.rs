//! The twin file: one safetensors container. `docs/formats/twin.md` specifies it
//! for other programs; [`Twin::decode`] checks every index and number, so a
//! decoded twin can be simulated without further checks.

mod appearance;
mod carried;
mod identifiability;
mod members;
mod planner;
mod surface;

use std::borrow::Cow;

use safetensors::{Dtype, SafeTensors, View};
use serde::{Deserialize, Serialize};

use self::carried::Carried;
use super::{Provenance, Twin};
use crate::{
    Contact, Environment, FRAME_RATES, Graph, MASSES, NodeKind, Params, Pin, Point, Problem,
    Quality, Skin, Timing, environment::ControlVelocity,
};

/// Newest version that this build reads and writes; it reads every earlier one. A twin is written
/// in the earliest version that can hold it, so that older programs read the twins that they
/// support and refuse others.
pub const VERSION: u32 = WITH_PLANNER;

/// The version with rods.
const WITH_RODS: u32 = 2;

/// The version with a skin finer than the nodes.
const WITH_SKIN: u32 = 3;

/// The version with other fits of the object.
const WITH_MEMBERS: u32 = 4;

/// The version with an appearance.
const WITH_APPEARANCE: u32 = 5;

/// The version with contact of the skin.
const WITH_SKIN_CONTACT: u32 = 6;

/// The version with a planner's twin.
const WITH_PLANNER: u32 = 7;

/// The tensor that says the hand of each control point; a file of any version may have it.
const HANDS: &str = "controls.hand";

/// The tensors of the skin, and that of the tracked points that it has.
const SKIN: Carried = Carried {
    counts: "skin.weight_count",
    nodes: "skin.weight_node",
    weights: "skin.weight",
    frames: "skin.frame",
    offsets: "skin.offset",
};
const OBSERVED: &str = "skin.observed_point";

/// Key of the JSON document in the container's metadata.
const METADATA_KEY: &str = "bendtwin.twin";

/// The reason why a twin file cannot be read.
#[derive(Debug, thiserror::Error, Problem)]
#[problem(InvalidArgument, "INVALID_TWIN_FILE")]
pub enum FormatError {
    /// Not a safetensors container, or a damaged one.
    #[error("the twin file is damaged or not a safetensors file: {0}")]
    Container(String),
    /// The metadata document is missing or wrong.
    #[error("the twin file's metadata is not a BendTwin twin: {0}")]
    Metadata(String),
    /// Written by a newer build.
    #[error("the twin file has version {0}, this build reads up to {VERSION}: update BendTwin")]
    Version(u32),
    /// A tensor is missing or has another type or shape.
    #[error("tensor `{name}`: {fault}")]
    Tensor {
        /// The tensor's name.
        name: &'static str,
        /// Description of the fault.
        fault: String,
    },
    /// Tensors contradict one another or hold impossible numbers.
    #[error("the twin is inconsistent: {0}")]
    Inconsistent(String),
}

#[derive(Serialize, Deserialize)]
struct Metadata {
    version: u32,
    environment: Environment,
    timing: Timing,
    control_velocity: ControlVelocity,
    drag: f32,
    contact: Contact,
    provenance: Provenance,
    quality: Quality,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    mass_kg: Option<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    members: Vec<members::Numbers>,
}

struct Raw<'a> {
    dtype: Dtype,
    shape: Vec<usize>,
    bytes: Cow<'a, [u8]>,
}

impl View for Raw<'_> {
    fn dtype(&self) -> Dtype {
        self.dtype
    }
    fn shape(&self) -> &[usize] {
        &self.shape
    }
    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Borrowed(&self.bytes)
    }
    fn data_len(&self) -> usize {
        self.bytes.len()
    }
}

fn raw<T: bytemuck::NoUninit>(dtype: Dtype, shape: &[usize], data: &[T]) -> Raw<'static> {
    Raw { dtype, shape: shape.to_vec(), bytes: Cow::Owned(bytemuck::cast_slice(data).to_vec()) }
}

impl Twin {
    /// The twin as bytes. Equal twins give equal bytes.
    ///
    /// # Errors
    /// If the twin contradicts itself, see [`Twin::check`].
    pub fn encode(&self) -> Result<Vec<u8>, FormatError> {
        self.check()?;
        let (g, p) = (&self.graph, &self.params);
        let (n, c, e, t) = (g.node_count(), g.control_count(), g.springs.len(), g.triplets.len());
        let kinds: Vec<u8> = g.kinds.iter().map(|k| *k as u8).collect();
        let pins: Vec<[u32; 2]> = g.pins.iter().map(|p| [p.node, p.control]).collect();
        let offsets: Vec<Point> = g.pins.iter().map(|p| p.offset_m).collect();
        let version = self.version();
        let mut tensors = vec![
            ("nodes.rest_position", raw(Dtype::F32, &[n, 3], &g.rest_positions)),
            ("nodes.kind", raw(Dtype::U8, &[n], &kinds)),
            ("nodes.mass", raw(Dtype::F32, &[n], &g.masses)),
            ("nodes.object_id", raw(Dtype::U32, &[n], &g.object_ids)),
            ("nodes.observed_point", raw(Dtype::U32, &[n], &g.observed_points)),
            ("controls.rest_position", raw(Dtype::F32, &[c, 3], &g.control_rest)),
            ("springs.ends", raw(Dtype::U32, &[e, 2], &g.springs)),
            ("springs.rest_length", raw(Dtype::F32, &[e], &p.rest_lengths_m)),
            ("springs.stiffness", raw(Dtype::F32, &[e], &p.spring_stiffness)),
            ("springs.dashpot", raw(Dtype::F32, &[e], &p.spring_dashpot)),
            ("triplets.ends", raw(Dtype::U32, &[t, 3], &g.triplets)),
            ("triplets.rest_angle", raw(Dtype::F32, &[t], &p.rest_angles_rad)),
            ("triplets.bend_stiffness", raw(Dtype::F32, &[t], &p.bend_stiffness)),
            ("triplets.bend_damping", raw(Dtype::F32, &[t], &p.bend_damping)),
            ("pins.ends", raw(Dtype::U32, &[pins.len(), 2], &pins)),
            ("pins.offset", raw(Dtype::F32, &[offsets.len(), 3], &offsets)),
        ];
        if version >= WITH_RODS {
            let (r, nodes) = (g.rods.len(), g.rods.concat());
            let lengths: Vec<u32> = g.rods.iter().map(|rod| rod.len() as u32).collect();
            tensors.extend([
                ("rods.lengths", raw(Dtype::U32, &[r], &lengths)),
                ("rods.nodes", raw(Dtype::U32, &[nodes.len()], &nodes)),
                ("rods.twist_stiffness", raw(Dtype::F32, &[r], &p.twist_stiffness)),
                ("rods.twist_damping", raw(Dtype::F32, &[r], &p.twist_damping)),
                ("rods.rest_twist", raw(Dtype::F32, &[r], &p.rest_twists_rad)),
            ]);
        }
        if version >= WITH_SKIN {
            let observed = &self.skin.observed_points;
            tensors.push((OBSERVED, raw(Dtype::U32, &[observed.len()], observed)));
            tensors.extend(SKIN.tensors(&self.skin));
        }
        if !self.members.is_empty() {
            tensors.extend(members::tensors(&self.members));
        }
        if let Some(appearance) = &self.appearance {
            tensors.extend(appearance::tensors(appearance));
        }
        if let Some(surface) = &self.surface {
            tensors.extend(surface::tensors(surface));
        }
        if let Some(planner) = &self.planner {
            tensors.extend(planner::tensors(planner)?);
        }
        if !self.control_hands.is_empty() {
            tensors.push((HANDS, raw(Dtype::U32, &[c], &self.control_hands)));
        }
        if let Some(report) = &self.quality.identifiability {
            tensors.extend(identifiability::tensors(report));
        }
        let metadata = Metadata {
            version,
            environment: self.environment,
            timing: self.timing,
            control_velocity: self.control_velocity,
            drag: p.drag,
            contact: p.contact,
            provenance: self.provenance.clone(),
            quality: self.quality.clone(),
            mass_kg: self.mass_kg,
            members: self.members.iter().map(members::Numbers::of).collect(),
        };
        let json =
            serde_json::to_string(&metadata).map_err(|e| FormatError::Metadata(e.to_string()))?;
        let info = std::iter::once((METADATA_KEY.to_owned(), json)).collect();
        safetensors::serialize(tensors, Some(info))
            .map_err(|e| FormatError::Container(e.to_string()))
    }

    /// Reads a twin file.
    ///
    /// # Errors
    /// If the bytes are no twin file, are damaged, or hold a twin that cannot be simulated.
    pub fn decode(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::decode_before(bytes, VERSION + 1)
    }

    /// Reads a twin file of a version before this one.
    fn decode_before(bytes: &[u8], end: u32) -> Result<Self, FormatError> {
        let container = |e: safetensors::SafeTensorError| FormatError::Container(e.to_string());
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(container)?;
        let json = header
            .metadata()
            .as_ref()
            .and_then(|m| m.get(METADATA_KEY))
            .ok_or_else(|| FormatError::Metadata(format!("no `{METADATA_KEY}` entry")))?;
        #[derive(Deserialize)]
        struct Version {
            version: u32,
        }
        let invalid = |e: serde_json::Error| FormatError::Metadata(e.to_string());
        let version = serde_json::from_str::<Version>(json).map_err(invalid)?.version;
        if version == 0 || version >= end {
            return Err(FormatError::Version(version));
        }
        let mut metadata: Metadata = serde_json::from_str(json).map_err(invalid)?;
        let file = Tensors(SafeTensors::deserialize(bytes).map_err(container)?);

        file.complete_identifiability(&mut metadata.quality)?;
        let kinds = file
            .read::<u8>("nodes.kind", Dtype::U8, None)?
            .into_iter()
            .map(|k| match k {
                0 => Ok(NodeKind::Observed),
                1 => Ok(NodeKind::Completed),
                2 => Ok(NodeKind::Interior),
                k => Err(FormatError::Inconsistent(format!("node kind {k} is not 0, 1 or 2"))),
            })
            .collect::<Result<_, _>>()?;
        let pin_ends: Vec<[u32; 2]> = file.read("pins.ends", Dtype::U32, Some(2))?;
        let pin_offsets: Vec<Point> = file.read("pins.offset", Dtype::F32, Some(3))?;
        if pin_ends.len() != pin_offsets.len() {
            return Err(FormatError::Inconsistent(
                "pins.ends and pins.offset differ in length".into(),
            ));
        }
        let has_rods = version >= WITH_RODS;
        let per_rod = |name| {
            if has_rods { file.read::<f32>(name, Dtype::F32, None) } else { Ok(Vec::new()) }
        };
        let graph = Graph {
            rest_positions: file.read("nodes.rest_position", Dtype::F32, Some(3))?,
            kinds,
            masses: file.read("nodes.mass", Dtype::F32, None)?,
            object_ids: file.read("nodes.object_id", Dtype::U32, None)?,
            observed_points: file.read("nodes.observed_point", Dtype::U32, None)?,
            control_rest: file.read("controls.rest_position", Dtype::F32, Some(3))?,
            springs: file.read("springs.ends", Dtype::U32, Some(2))?,
            triplets: file.read("triplets.ends", Dtype::U32, Some(3))?,
            pins: pin_ends
                .into_iter()
                .zip(pin_offsets)
                .map(|([node, control], offset_m)| Pin { node, control, offset_m })
                .collect(),
            rods: if has_rods { file.rods()? } else { Vec::new() },
        };
        let skin = if version >= WITH_SKIN { file.skin()? } else { Skin::of_nodes(&graph) };
        // A file with an appearance may have none.
        let has_members = version == WITH_MEMBERS || !metadata.members.is_empty();
        let members = if has_members && version >= WITH_MEMBERS {
            file.members(&metadata.members, graph.rods.len())?
        } else {
            Vec::new()
        };
        // A file with contact of the skin may have none.
        let has_appearance =
            version == WITH_APPEARANCE || (version > WITH_APPEARANCE && file.has_appearance());
        let twin = Self {
            graph,
            skin,
            params: Params {
                spring_stiffness: file.read("springs.stiffness", Dtype::F32, None)?,
                spring_dashpot: file.read("springs.dashpot", Dtype::F32, None)?,
                rest_lengths_m: file.read("springs.rest_length", Dtype::F32, None)?,
                bend_stiffness: file.read("triplets.bend_stiffness", Dtype::F32, None)?,
                bend_damping: file.read("triplets.bend_damping", Dtype::F32, None)?,
                rest_angles_rad: file.read("triplets.rest_angle", Dtype::F32, None)?,
                twist_stiffness: per_rod("rods.twist_stiffness")?,
                twist_damping: per_rod("rods.twist_damping")?,
                rest_twists_rad: per_rod("rods.rest_twist")?,
                drag: metadata.drag,
                contact: metadata.contact,
            },
            environment: metadata.environment,
            timing: metadata.timing,
            control_velocity: metadata.control_velocity,
            provenance: metadata.provenance,
            quality: metadata.quality,
            mass_kg: metadata.mass_kg,
            control_hands: if file.has(HANDS) {
                file.read(HANDS, Dtype::U32, None)?
            } else {
                Vec::new()
            },
            members,
            appearance: match has_appearance {
                true => Some(file.appearance()?),
                false => None,
            },
            surface: file.surface()?,
            planner: match version >= WITH_PLANNER {
                true => Some(file.planner()?),
                false => None,
            },
        };
        twin.check()?;
        Ok(twin)
    }

    /// The earliest version that can hold this twin.
    fn version(&self) -> u32 {
        let g = &self.graph;
        let members = self.members.iter().map(|m| &m.params);
        let needs = [
            (WITH_PLANNER, self.planner.is_some()),
            (WITH_SKIN_CONTACT, members.chain([&self.params]).any(|p| p.contact.skin)),
            (WITH_APPEARANCE, self.appearance.is_some()),
            (WITH_MEMBERS, !self.members.is_empty()),
            (WITH_SKIN, !self.skin.is_nodes(g)),
            (WITH_RODS, !g.rods.is_empty()),
        ];
        needs.into_iter().find(|(_, needed)| *needed).map_or(1, |(version, _)| version)
    }

    /// Checks that the twin can be simulated: lengths agree, indices exist, numbers are finite.
    ///
    /// # Errors
    /// The first contradiction found.
    pub fn check(&self) -> Result<(), FormatError> {
        let fail = |m: String| Err(FormatError::Inconsistent(m));
        self.graph.check().or_else(fail)?;
        self.params.check(&self.graph).or_else(fail)?;
        self.check_members()?;
        if let Err(m) = self.skin.check(self.graph.node_count()) {
            return fail(m);
        }
        if let Some(appearance) = &self.appearance {
            appearance.check(self.skin.len(), self.graph.node_count()).or_else(fail)?;
        }
        if let Some(surface) = &self.surface {
            surface.check(self.graph.node_count()).or_else(fail)?;
        }
        let t = self.timing;
        if !(FRAME_RATES.contains(&t.fps) && t.substeps > 0) {
            let (low, high) = (FRAME_RATES.start(), FRAME_RATES.end());
            return fail(format!(
                "{} frames per second ({low} to {high} are possible) with {} substeps",
                t.fps, t.substeps
            ));
        }
        let e = &self.environment;
        let ground =
            e.ground.map_or([0.0; 4], |p| [p.normal[0], p.normal[1], p.normal[2], p.offset_m]);
        if !e.gravity.iter().chain(&ground).all(|x| x.is_finite()) {
            return fail("gravity or ground is not finite".into());
        }
        if let Some(mass) = self.mass_kg.filter(|mass| !MASSES.contains(mass)) {
            let (low, high) = (MASSES.start(), MASSES.end());
            return fail(format!("the mass is {mass} kg ({low} to {high} are possible)"));
        }
        if let Some(loss) = self.provenance.loss.filter(|loss| !(*loss >= 0.0 && loss.is_finite()))
        {
            return fail(format!("the loss is {loss}: it must be finite and not negative"));
        }
        let (hands, controls) = (self.control_hands.len(), self.graph.control_count());
        if hands != 0 && hands != controls {
            return fail(format!("{hands} hands for {controls} control points: one each, or none"));
        }
        if let Some(report) = &self.quality.identifiability {
            report.check(self.graph.node_count(), self.skin.len()).or_else(fail)?;
        }
        self.check_planner()?;
        self.quality.fast.as_ref().map_or(Ok(()), |f| f.check().or_else(fail))
    }
}

struct Tensors<'a>(SafeTensors<'a>);

impl Tensors<'_> {
    /// True if there is a tensor of this name.
    fn has(&self, name: &str) -> bool {
        self.0.tensor(name).is_ok()
    }

    /// The skin.
    fn skin(&self) -> Result<Skin, FormatError> {
        Ok(Skin { observed_points: self.read(OBSERVED, Dtype::U32, None)?, ..self.carried(&SKIN)? })
    }

    /// The rods' nodes, one rod after another in the file.
    fn rods(&self) -> Result<Vec<Vec<u32>>, FormatError> {
        let lengths: Vec<u32> = self.read("rods.lengths", Dtype::U32, None)?;
        let nodes: Vec<u32> = self.read("rods.nodes", Dtype::U32, None)?;
        let mut rest = nodes.as_slice();
        let mut rods = Vec::with_capacity(lengths.len());
        for &length in &lengths {
            let Some((rod, after)) = rest.split_at_checked(length as usize) else { break };
            rods.push(rod.to_vec());
            rest = after;
        }
        if rods.len() < lengths.len() || !rest.is_empty() {
            let why = "rods.lengths does not add up to the length of rods.nodes";
            return Err(FormatError::Inconsistent(why.into()));
        }
        Ok(rods)
    }

    /// Reads a tensor of shape [n] or, with `width`, [n, width].
    fn read<T: bytemuck::AnyBitPattern>(
        &self,
        name: &'static str,
        dtype: Dtype,
        width: Option<usize>,
    ) -> Result<Vec<T>, FormatError> {
        let fault = |fault: String| FormatError::Tensor { name, fault };
        let view = self.0.tensor(name).map_err(|_| fault("is missing".into()))?;
        if view.dtype() != dtype {
            return Err(fault(format!("has type {:?}, not {dtype:?}", view.dtype())));
        }
        let fits = match (view.shape(), width) {
            ([_], None) => true,
            ([_, w], Some(width)) => *w == width,
            _ => false,
        };
        if !fits {
            let inner = width.map_or(String::new(), |w| format!(", {w}"));
            return Err(fault(format!("has shape {:?}, not [n{inner}]", view.shape())));
        }
        // The container gives no alignment, so elements are read one by one.
        Ok(view.data().chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
    }
}

#[cfg(test)]
mod tests;
