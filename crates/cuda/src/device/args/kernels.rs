//! Parameters of the kernels, one struct each, passed by value. Fields are described beside each
//! kernel.

use super::{InitialArgs, InstanceArgs, ObjectiveArgs, OutputArgs, Pointer, device_struct};

device_struct! {
    /// Parameters of `start`.
    StartArgs {
        instances: Pointer<InitialArgs>,
    }
}

device_struct! {
    /// Parameters of `advance_frames`.
    AdvanceFramesArgs {
        instances: Pointer<InstanceArgs>,
        first: u32,
        end: u32,
        from: u32,
        to: u32,
        keep: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `back_frame`.
    BackFrameArgs {
        instances: Pointer<InstanceArgs>,
        from: u32,
        to: u32,
    }
}

device_struct! {
    /// Parameters of `find_partners`.
    FindPartnersArgs {
        instances: Pointer<InstanceArgs>,
        frame: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `find_clearances`.
    FindClearancesArgs {
        instances: Pointer<InstanceArgs>,
        frame: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `clearance_adjoint`.
    ClearanceAdjointArgs {
        instances: Pointer<InstanceArgs>,
    }
}

device_struct! {
    /// Parameters of `change_grasps`.
    ChangeGraspsArgs {
        instances: Pointer<InstanceArgs>,
        boundary: u32,
        end: u32,
    }
}

device_struct! {
    /// Parameters of `collect_motion`.
    CollectMotionArgs {
        instances: Pointer<InstanceArgs>,
        poses: Pointer<Pointer<f32>>,
        rolls: Pointer<Pointer<f32>>,
        starts: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `score`.
    ScoreArgs {
        objectives: Pointer<ObjectiveArgs>,
    }
}

device_struct! {
    /// Parameters of `seed_skin`.
    SeedSkinArgs {
        objectives: Pointer<ObjectiveArgs>,
    }
}

device_struct! {
    /// Parameters of `seed`.
    SeedArgs {
        objectives: Pointer<ObjectiveArgs>,
    }
}

device_struct! {
    /// Parameters of `seed_rest_lengths`.
    SeedRestLengthsArgs {
        objectives: Pointer<ObjectiveArgs>,
        outs: Pointer<Pointer<f32>>,
    }
}

device_struct! {
    /// Parameters of `norm_bars`.
    NormBarsArgs {
        instances: Pointer<InstanceArgs>,
        outs: Pointer<Pointer<f64>>,
    }
}

device_struct! {
    /// Parameters of `seed_forces`.
    SeedForcesArgs {
        objectives: Pointer<ObjectiveArgs>,
    }
}

device_struct! {
    /// Parameters of `seed_poses`.
    SeedPosesArgs {
        objectives: Pointer<ObjectiveArgs>,
        outs: Pointer<Pointer<f32>>,
    }
}

device_struct! {
    /// Parameters of `pack_half_springs`.
    PackHalfSpringsArgs {
        rates: Pointer<[f32; 4]>,
        packed_others: Pointer<u32>,
        dashpots: Pointer<[f32; 2]>,
        springs: Pointer<u32>,
        others: Pointer<u32>,
        params: Pointer<f32>,
        pair_count: u32,
        spring_count: u32,
    }
}

device_struct! {
    /// Parameters of `pack_bends`.
    PackBendsArgs {
        out: Pointer<[f32; 4]>,
        triplets: Pointer<u32>,
        params: Pointer<f32>,
        count: u32,
        spring_count: u32,
        triplet_count: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `gather_sums`.
    GatherSumsArgs {
        total: Pointer<f32>,
        sums: Pointer<f32>,
        sum_of: Pointer<u32>,
        stride: u64,
        window_count: u32,
        spring_count: u32,
        other_count: u32,
        first_other: u32,
    }
}

device_struct! {
    /// Parameters of `finish_gradient`.
    FinishGradientArgs {
        out: Pointer<f32>,
        sums: Pointer<f32>,
        params: Pointer<f32>,
        spring_count: u32,
        hinge_count: u32,
        block_count: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `collect_controls`.
    CollectControlsArgs {
        instances: Pointer<InstanceArgs>,
        outs: Pointer<Pointer<[f32; 3]>>,
        block_count: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `add_seeds`.
    AddSeedsArgs {
        instances: Pointer<InstanceArgs>,
        seeds: Pointer<Pointer<f32>>,
        begins: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `square_lengths`.
    SquareLengthsArgs {
        out: Pointer<f64>,
        gradients: Pointer<Pointer<f32>>,
        params: Pointer<f32>,
        indices: Pointer<u32>,
        count: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `weigh_gradients`.
    WeighGradientsArgs {
        sums: Pointer<f64>,
        finite: Pointer<u32>,
        gradients: Pointer<Pointer<f32>>,
        weights: Pointer<f64>,
        params: Pointer<f32>,
        indices: Pointer<u32>,
        gradient_count: u32,
        count: u32,
    }
}

device_struct! {
    /// Parameters of `mean_squares`.
    MeanSquaresArgs {
        second: Pointer<f64>,
        sums: Pointer<f64>,
        starts: Pointer<u32>,
        beta2: f64,
    }
}

device_struct! {
    /// Parameters of `step_adam`.
    StepAdamArgs {
        theta: Pointer<f64>,
        first: Pointer<f64>,
        second: Pointer<f64>,
        sums: Pointer<f64>,
        kinds: Pointer<u32>,
        rates: Pointer<f64>,
        bounds: Pointer<[f64; 2]>,
        start: Pointer<f64>,
        params: Pointer<f32>,
        indices: Pointer<u32>,
        back: f64,
        rate: f64,
        beta1: f64,
        unbias1: f64,
        unbias2: f64,
        slope: f64,
        epsilon: f64,
        count: u32,
        angles: u32,
        angles_end: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `record`.
    RecordArgs {
        outputs: Pointer<OutputArgs>,
    }
}

device_struct! {
    /// Words somewhere on the device, and their place among those that are gathered.
    GatherPiece {
        from: Pointer<u32>,
        at: u64,
        count: u64,
    }
}

device_struct! {
    /// Parameters of `gather`.
    GatherArgs {
        pieces: Pointer<GatherPiece>,
        gathered: Pointer<u32>,
    }
}

device_struct! {
    /// Parameters of `extremes`.
    ExtremesArgs {
        outputs: Pointer<OutputArgs>,
    }
}
