//! The kernels' sources, and what a launch of them is specialized for at compile time.

use std::fmt::Write as _;

use bendtwin_core::twin::skin::LEAST_SINE;
use bendtwin_engine::constants;
use bendtwin_splat::constants as splat;

use super::team::TeamShape;

/// Threads of a block of the small kernels.
pub(crate) const THREADS: u32 = 256;
/// Targets that such a thread seeks the nearest point of at a time, at most.
pub(crate) const TARGETS_EACH: u32 = 4;

const HEADERS: &[(&str, &str)] = &[
    ("vector.cuh", include_str!("../../kernels/vector.cuh")),
    ("reduce.cuh", include_str!("../../kernels/reduce.cuh")),
    ("spring.cuh", include_str!("../../kernels/spring.cuh")),
    ("bend.cuh", include_str!("../../kernels/bend.cuh")),
    ("rod.cuh", include_str!("../../kernels/rod.cuh")),
    ("impulse.cuh", include_str!("../../kernels/impulse.cuh")),
    ("ground.cuh", include_str!("../../kernels/ground.cuh")),
    ("instance.cuh", include_str!("../../kernels/instance.cuh")),
    ("clearance.cuh", include_str!("../../kernels/clearance.cuh")),
    ("body.cuh", include_str!("../../kernels/body.cuh")),
    ("hold.cuh", include_str!("../../kernels/hold.cuh")),
    ("clamp.cuh", include_str!("../../kernels/clamp.cuh")),
    ("force.cuh", include_str!("../../kernels/force.cuh")),
    ("smooth.cuh", include_str!("../../kernels/smooth.cuh")),
    ("meet.cuh", include_str!("../../kernels/meet.cuh")),
    ("team.cuh", include_str!("../../kernels/team.cuh")),
    ("contact.cuh", include_str!("../../kernels/contact.cuh")),
    ("share.cuh", include_str!("../../kernels/share.cuh")),
];

/// A source file of kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Source {
    /// Initial states.
    Start,
    /// Frames forward.
    Integrate,
    /// A frame backward.
    Adjoint,
    /// Contact candidates.
    Partners,
    /// Contact of the skin.
    Clearance,
    /// Grasps that open and close.
    Grasps,
    /// Objectives.
    Loss,
    /// Parameters and their gradients.
    Params,
    /// Adam.
    Optimizer,
    /// Outputs of a rollout.
    Outputs,
    /// Gaussian splats.
    Splat,
}

impl Source {
    /// Sources without specialization that a backend needs.
    pub(crate) const SMALL: [Self; 8] = [
        Self::Start,
        Self::Partners,
        Self::Clearance,
        Self::Grasps,
        Self::Loss,
        Self::Params,
        Self::Optimizer,
        Self::Outputs,
    ];

    /// True if its kernels keep states in dynamic shared memory.
    pub(crate) fn is_persistent(self) -> bool {
        matches!(self, Self::Integrate | Self::Adjoint)
    }

    /// Source files, headers before kernels.
    fn files(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Start => &[("start.cu", include_str!("../../kernels/start.cu"))],
            Self::Integrate => &[
                ("integrate_forces.cuh", include_str!("../../kernels/integrate_forces.cuh")),
                ("grasp.cuh", include_str!("../../kernels/grasp.cuh")),
                ("measure.cuh", include_str!("../../kernels/measure.cuh")),
                ("integrate.cu", include_str!("../../kernels/integrate.cu")),
            ],
            Self::Adjoint => &[
                ("adjoint_state.cuh", include_str!("../../kernels/adjoint_state.cuh")),
                ("adjoint_forces.cuh", include_str!("../../kernels/adjoint_forces.cuh")),
                ("adjoint.cu", include_str!("../../kernels/adjoint.cu")),
            ],
            Self::Partners => &[("partners.cu", include_str!("../../kernels/partners.cu"))],
            Self::Clearance => &[
                ("skin.cuh", include_str!("../../kernels/skin.cuh")),
                ("clearance.cu", include_str!("../../kernels/clearance.cu")),
            ],
            Self::Grasps => &[
                ("grasp.cuh", include_str!("../../kernels/grasp.cuh")),
                ("grasps.cu", include_str!("../../kernels/grasps.cu")),
            ],
            Self::Loss => &[
                ("skin.cuh", include_str!("../../kernels/skin.cuh")),
                ("objective.cuh", include_str!("../../kernels/objective.cuh")),
                ("terms.cuh", include_str!("../../kernels/terms.cuh")),
                ("chain.cuh", include_str!("../../kernels/chain.cuh")),
                ("points.cuh", include_str!("../../kernels/points.cuh")),
                ("loss.cu", include_str!("../../kernels/loss.cu")),
            ],
            Self::Params => &[("params.cu", include_str!("../../kernels/params.cu"))],
            Self::Optimizer => &[("optimizer.cu", include_str!("../../kernels/optimizer.cu"))],
            Self::Outputs => &[("outputs.cu", include_str!("../../kernels/outputs.cu"))],
            Self::Splat => &[
                ("splat.cuh", include_str!("../../kernels/splat.cuh")),
                ("splat_lists.cu", include_str!("../../kernels/splat_lists.cu")),
                ("splat_raster.cu", include_str!("../../kernels/splat_raster.cu")),
                ("splat_adjoint.cu", include_str!("../../kernels/splat_adjoint.cu")),
            ],
        }
    }
}

/// The parts of an instance's surroundings beside the ground that a kernel has code for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct WorldParts {
    pub(crate) grasps: bool,
    pub(crate) colliders: bool,
    /// Ground and colliders act in a layer of some width.
    pub(crate) smooth: bool,
    /// Clamps of rods turn.
    pub(crate) rolls: bool,
    /// Forces are measured.
    pub(crate) forces: bool,
}

/// Constants that a kernel is compiled with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Specialization {
    pub(crate) source: Source,
    pub(crate) shape: TeamShape,
    /// Blocks of a team.
    pub(crate) blocks: u32,
    /// Instances that a team simulates together.
    pub(crate) instances: u32,
    /// Lanes that share a node; a power of two up to 32.
    pub(crate) lanes: u32,
    pub(crate) threads: u32,
    /// Every warp has one row of nodes at most.
    pub(crate) one_row: bool,
    /// Pairs of half-springs of a lane in registers (forward); whether their sums are in registers
    /// (backward).
    pub(crate) held: u32,
    /// Pairs of `held` that every row has.
    pub(crate) held_always: u32,
    /// Pairs that have their sums in registers.
    pub(crate) held_sums: u32,
    /// All springs have the same dashpot.
    pub(crate) uniform_dashpot: bool,
    /// With triplets or rods.
    pub(crate) bending: bool,
    /// Rods of an instance.
    pub(crate) rods: u32,
    pub(crate) ground: bool,
    pub(crate) contact: bool,
    /// Ground and colliders meet the skin.
    pub(crate) skin_contact: bool,
    pub(crate) tape: bool,
    pub(crate) world: WorldParts,
    pub(crate) half_springs_in_shared: bool,
    pub(crate) bend_in_shared: bool,
}

impl Specialization {
    /// A source without specialization.
    pub(crate) fn small(source: Source) -> Self {
        Self {
            source,
            shape: TeamShape::Block,
            blocks: 1,
            instances: 1,
            lanes: 1,
            threads: THREADS,
            one_row: true,
            held: 0,
            held_always: 0,
            held_sums: 0,
            uniform_dashpot: false,
            bending: false,
            rods: 0,
            ground: false,
            contact: false,
            skin_contact: false,
            tape: false,
            // Clearances are those to colliders too.
            world: WorldParts { colliders: source == Source::Clearance, ..WorldParts::default() },
            half_springs_in_shared: false,
            bend_in_shared: false,
        }
    }

    /// True if a block works on triplets with its half-springs or their forces outside shared
    /// memory.
    pub(crate) fn spills(&self) -> bool {
        self.bending && !(self.bend_in_shared && self.half_springs_in_shared)
    }

    /// The whole source with its constants in front.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        let constants = [
            ("SHAPE", self.shape as u32),
            ("BLOCKS", self.blocks),
            ("INSTANCES", self.instances),
            ("LANES", self.lanes),
            ("THREADS", self.threads),
            ("TARGETS_EACH", TARGETS_EACH),
            ("ONE_ROW", self.one_row.into()),
            ("HELD", self.held),
            ("HELD_ALWAYS", self.held_always),
            ("HELD_SUMS", self.held_sums),
            ("UNIFORM_DASHPOT", self.uniform_dashpot.into()),
            ("BENDING", self.bending.into()),
            ("RODS", self.rods),
            ("GROUND", self.ground.into()),
            ("CONTACT", self.contact.into()),
            ("SKIN_CONTACT", self.skin_contact.into()),
            ("TAPE", self.tape.into()),
            ("GRASPS", self.world.grasps.into()),
            ("COLLIDERS", self.world.colliders.into()),
            ("SMOOTH", self.world.smooth.into()),
            ("ROLLS", self.world.rolls.into()),
            ("FORCES", self.world.forces.into()),
            ("HALF_SPRINGS_IN_SHARED", self.half_springs_in_shared.into()),
            ("BEND_IN_SHARED", self.bend_in_shared.into()),
        ];
        // Writing to a string cannot fail.
        for (name, value) in constants {
            let _ = writeln!(text, "#define {name} {value}");
        }
        text.push_str(&physics());
        if self.source == Source::Splat {
            text.push_str(&rendering());
        }
        for (name, body) in HEADERS.iter().chain(self.source.files()) {
            let _ = writeln!(text, "#line 1 \"{name}\"\n{body}");
        }
        let _ = writeln!(text, "#line 1 \"arguments\"\n{}", self.source.layout_checks());
        text
    }
}

/// Definitions of the engine's constants, in single precision where the kernels use them so.
fn physics() -> String {
    let single = [
        ("MIN_SINE", constants::MIN_SINE),
        ("LEAST_FRAME_SINE", LEAST_SINE),
        ("MIN_ARM_M", constants::MIN_ARM_M),
        ("ROUNDING", constants::ROUNDING),
        ("ROUNDED_REST", 1.0_f64.hypot(constants::ROUNDING)),
        ("MIN_FOLD", constants::MIN_FOLD),
        ("MIN_EDGE_M", constants::MIN_EDGE_M),
        ("MIN_SINE_SQUARED", constants::MIN_SINE_SQUARED),
        ("MIN_LENGTH_SQUARED_M2", constants::MIN_LENGTH_M * constants::MIN_LENGTH_M),
        ("LEAST_RADIUS_M", constants::LEAST_RADIUS_M),
        ("CONTACT_MARGIN_M", constants::CONTACT_MARGIN_M),
        ("MAX_COORDINATE_M", constants::MAX_COORDINATE_M),
        ("PUSH_S", constants::PUSH_S),
        ("MAX_PUSH_M", constants::MAX_PUSH_M),
        ("SMOOTH_STIFFNESS_M_S2", constants::SMOOTH_STIFFNESS_M_S2),
        ("SMOOTH_RATE_1_S", constants::SMOOTH_RATE_1_S),
    ];
    let mut text = String::new();
    // The shortest digits that are this number: parsed again they are the same.
    for (name, value) in single {
        let _ = writeln!(text, "#define {name} {value:e}f");
    }
    let _ = writeln!(text, "#define STRAIGHT_RAD {:e}", constants::STRAIGHT_RAD);
    text
}

/// Definitions of the constants of rendering.
fn rendering() -> String {
    let numbers = [
        ("BLUR_PX2", splat::BLUR_PX2),
        ("MOST_ALPHA", splat::MOST_ALPHA),
        ("LEAST_ALPHA", splat::LEAST_ALPHA),
        ("LEAST_TRANSMITTANCE", splat::LEAST_TRANSMITTANCE),
        ("NEAR_M", splat::NEAR_M),
        ("MOST_TANGENT", splat::MOST_TANGENT),
    ];
    let mut text = format!("#define SPLAT_TILE_PX {}u\n", splat::TILE_PX);
    for (name, value) in numbers {
        let _ = writeln!(text, "#define SPLAT_{name} {value:e}f");
    }
    text
}

/// Options for an architecture, 90 for sm_90 say. Square roots and quotients within two units in
/// the last place are exact enough, and subnormal numbers are no lengths.
pub(crate) fn options(architecture: u32) -> Vec<String> {
    [
        format!("--gpu-architecture=sm_{architecture}"),
        "--std=c++17".to_owned(),
        "--ftz=true".to_owned(),
        "--prec-div=false".to_owned(),
        "--prec-sqrt=false".to_owned(),
        "--device-as-default-execution-space".to_owned(),
    ]
    .to_vec()
}

#[cfg(test)]
mod tests;
