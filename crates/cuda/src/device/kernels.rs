//! The kernels by name: one function each, which launches it with the struct that it takes.

use bendtwin_engine::Error;

use super::{
    args::{
        AddSeedsArgs, AdvanceFramesArgs, BackFrameArgs, ChangeGraspsArgs, Checks,
        ClearanceAdjointArgs, CollectControlsArgs, CollectMotionArgs, DeviceType, ExtremesArgs,
        FindClearancesArgs, FindPartnersArgs, FinishGradientArgs, GatherArgs, GatherSumsArgs,
        MeanSquaresArgs, NormBarsArgs, PackBendsArgs, PackHalfSpringsArgs, RecordArgs, ScoreArgs,
        SeedArgs, SeedForcesArgs, SeedPosesArgs, SeedRestLengthsArgs, SeedSkinArgs,
        SplatAdjointArgs, SplatBackwardArgs, SplatCountsArgs, SplatExpandArgs, SplatForwardArgs,
        SplatHistogramArgs, SplatProjectArgs, SplatRangesArgs, SplatScanArgs, SplatScatterArgs,
        SquareLengthsArgs, StartArgs, StepAdamArgs, WeighGradientsArgs,
    },
    launch::Launch,
    specialization::Source,
};

macro_rules! kernels {
    ($($(#[$doc:meta])* $source:ident: $kernel:ident($args:ty);)*) => {
        impl Source {
            /// `static_assert`s of the structs that its kernels take, behind their declarations.
            pub(crate) fn layout_checks(self) -> String {
                let mut checks = Checks::default();
                $(if self == Self::$source {
                    <$args>::check(&mut checks);
                })*
                checks.text()
            }
        }

        $(
            $(#[$doc])*
            ///
            /// # Safety
            /// Those of [`Launch::run`].
            pub(crate) unsafe fn $kernel(launch: &Launch<'_>, args: &$args) -> Result<(), Error> {
                // SAFETY: the struct is the kernel's; the rest is the caller's promise.
                unsafe { launch.run(Source::$source, stringify!($kernel), args) }
            }
        )*
    };
}

kernels! {
    /// Initial states, with pinned nodes on their control points: a block for some nodes of an
    /// instance.
    Start: start(StartArgs);
    /// Frames forward: a team of blocks for an instance.
    Integrate: advance_frames(AdvanceFramesArgs);
    /// Substeps of a frame backward: a team of blocks for an instance.
    Adjoint: back_frame(BackFrameArgs);
    /// Contact candidates of a frame: a block for an instance.
    Partners: find_partners(FindPartnersArgs);
    /// Clearances of a frame: a block for an instance.
    Clearance: find_clearances(FindClearancesArgs);
    /// d loss / d the state that a frame begins in, by its clearances: a block for an instance.
    Clearance: clearance_adjoint(ClearanceAdjointArgs);
    /// Grasps at a frame boundary: a block for an instance.
    Grasps: change_grasps(ChangeGraspsArgs);
    /// d loss / d poses and rolls of a frame, and of what grasps take: a block for an instance.
    Grasps: collect_motion(CollectMotionArgs);
    /// Values of objectives: a block for a piece of a term of an instance.
    Loss: score(ScoreArgs);
    /// d loss / d skin at frame ends: a block for some points of a frame of an instance.
    Loss: seed_skin(SeedSkinArgs);
    /// d loss / d positions at frame ends: a block for some nodes of a frame of an instance.
    Loss: seed(SeedArgs);
    /// d loss / d rest lengths by strains: a block for some springs of an instance.
    Loss: seed_rest_lengths(SeedRestLengthsArgs);
    /// d loss / d forces of all frames: a block for an instance.
    Loss: seed_forces(SeedForcesArgs);
    /// d loss / d poses by the terms themselves: a block for an instance.
    Loss: seed_poses(SeedPosesArgs);
    /// Half-springs from parameters.
    Params: pack_half_springs(PackHalfSpringsArgs);
    /// Triplets from parameters.
    Params: pack_bends(PackBendsArgs);
    /// Sums of an instance's windows, added up.
    Params: gather_sums(GatherSumsArgs);
    /// d loss / d parameters from these sums.
    Params: finish_gradient(FinishGradientArgs);
    /// d loss / d controls of a frame: a block for some control points of an instance.
    Params: collect_controls(CollectControlsArgs);
    /// d loss / d state at a frame's end: a block for some nodes of an instance.
    Params: add_seeds(AddSeedsArgs);
    /// Norms of d loss / d positions: a block for an instance.
    Params: norm_bars(NormBarsArgs);
    /// Squared lengths of gradients: some blocks for a gradient.
    Optimizer: square_lengths(SquareLengthsArgs);
    /// The weighted sum of gradients.
    Optimizer: weigh_gradients(WeighGradientsArgs);
    /// Mean squares of the gradient: a block for a kind of parameter.
    Optimizer: mean_squares(MeanSquaresArgs);
    /// A step of Adam.
    Optimizer: step_adam(StepAdamArgs);
    /// Recorded positions: a block for some nodes of a recorded frame of an instance.
    Outputs: record(RecordArgs);
    /// Words from many places, into one: some blocks for a piece.
    Outputs: gather(GatherArgs);
    /// Largest strain and speed at frame ends: a block for a frame of an instance.
    Outputs: extremes(ExtremesArgs);
    /// Projected Gaussians, and the tiles that each touches: a thread for a Gaussian.
    Splat: splat_project(SplatProjectArgs);
    /// Keys of a sort by digit: a block for a piece.
    Splat: splat_histogram(SplatHistogramArgs);
    /// Sums of all numbers before each: one block.
    Splat: splat_scan(SplatScanArgs);
    /// Pairs of a sort to their places by a digit: a block for a piece.
    Splat: splat_scatter(SplatScatterArgs);
    /// Counts of tiles by depth: a thread for a Gaussian.
    Splat: splat_counts(SplatCountsArgs);
    /// Intersections of Gaussians and tiles: a thread for a Gaussian.
    Splat: splat_expand(SplatExpandArgs);
    /// Entries of each tile: a thread for an entry.
    Splat: splat_ranges(SplatRangesArgs);
    /// An image: a block for a tile.
    Splat: splat_forward(SplatForwardArgs);
    /// Derivatives by entries: a block for a tile.
    Splat: splat_backward(SplatBackwardArgs);
    /// Derivatives by Gaussians: a thread for a Gaussian.
    Splat: splat_adjoint(SplatAdjointArgs);
}
