//! An instance as the kernels that simulate have it; `kernels/instance.cuh` describes the fields.

use bendtwin_core::Point;

use super::{Pointer, SkinArgs, device_struct};

device_struct! {
    /// A block's share of a graph. A block knows its own nodes, then the halo of nodes that its
    /// elements reach into, by local index; control points stand at `TopologyArgs::control_base` in
    /// every block.
    Share {
        own: u32,
        local: u32,
        nodes: u32,
        rows: u32,
        control_rows: u32,
        row: u32,
        triplets: u32,
        triplet: u32,
        pins: u32,
        pin: u32,
        export_start: u32,
        slot: u32,
    }
}

device_struct! {
    LocalPin {
        local: u32,
        pin: u32,
    }
}

device_struct! {
    Pin {
        control: u32,
        offset: [f32; 3],
    }
}

device_struct! {
    Triplet {
        i: u16,
        j: u16,
        k: u16,
        owned: u16,
    }
}

device_struct! {
    Law {
        restitution: f32,
        friction: f32,
    }
}

device_struct! {
    Ground {
        normal: [f32; 3],
        offset: f32,
    }
}

device_struct! {
    /// A graph as one shape of launch sees it.
    TopologyArgs {
        shares: Pointer<Share>,
        nodes: Pointer<u32>,
        rows: Pointer<u32>,
        triplets: Pointer<Triplet>,
        arm_rows: Pointer<u32>,
        arm_refs: Pointer<u32>,
        local_pins: Pointer<LocalPin>,
        pins: Pointer<Pin>,
        pin_of: Pointer<i32>,
        exports: Pointer<u32>,
        export_refs: Pointer<u32>,
        inverse_mass: Pointer<f32>,
        masses: Pointer<f32>,
        sum_rows: Pointer<u32>,
        triplet_of: Pointer<u32>,
        rod_turns: Pointer<u32>,
        rod_shares: Pointer<f32>,
        node_count: u32,
        control_count: u32,
        control_base: u32,
        stride: u32,
        max_triplets: u32,
        max_pairs: u32,
        max_all_pairs: u32,
        rod_count: u32,
        triplet_count: u32,
        pin_count: u32,
    }
}

device_struct! {
    /// Material parameters, packed for a shape of launch.
    ParameterArgs {
        rates: Pointer<[f32; 4]>,
        others: Pointer<u32>,
        dashpots: Pointer<[f32; 2]>,
        bends: Pointer<[f32; 4]>,
        rods: Pointer<f32>,
        ground_law: Law,
        object_law: Law,
        dashpot: f32,
        decay: f32,
    }
}

device_struct! {
    /// A substep: its length, external forces, and the frame that it is a part of.
    StepArgs {
        kick: [f32; 3],
        ground: Ground,
        dt: f32,
        frame_s: f32,
        substeps: u32,
        controls_move: u32,
        pad: u32,
    }
}

device_struct! {
    /// States that frames begin and end in.
    StateArgs {
        controls: Pointer<Point>,
        states: Pointer<f32>,
        twists: Pointer<f32>,
        divergence: Pointer<u64>,
        slot_count: u32,
        first_frame: u32,
        frame_count: u32,
        pad: u32,
    }
}

device_struct! {
    /// Records of substeps for the backward pass.
    TapeArgs {
        slot_of: Pointer<u32>,
        x: Pointer<[f32; 4]>,
        v: Pointer<[f32; 2]>,
        before: Pointer<[f32; 3]>,
        twists: Pointer<f32>,
    }
}

device_struct! {
    /// Derivatives of the loss, and the sums that become gradients of parameters.
    AdjointArgs {
        bar_x: Pointer<[f32; 4]>,
        bar_v: Pointer<[f32; 4]>,
        bar_twists: Pointer<f32>,
        spring_sums: Pointer<f32>,
        bend_sums: Pointer<f32>,
        law_sums: Pointer<f32>,
        control_sums: Pointer<f32>,
        pin_sums: Pointer<f32>,
    }
}

device_struct! {
    /// Contact between nodes.
    ContactArgs {
        partners: Pointer<u32>,
        partner_counts: Pointer<u32>,
        partner_scratch: Pointer<u32>,
        object_ids: Pointer<u32>,
        neighbour_starts: Pointer<u32>,
        neighbours: Pointer<u32>,
        x: Pointer<[f32; 4]>,
        v: Pointer<[f32; 4]>,
        start: Pointer<[f32; 4]>,
        rest: Pointer<[f32; 4]>,
        collision_distance: f32,
        max_partners: u32,
        between_objects: u32,
        within_object: u32,
    }
}

device_struct! {
    /// Global memory that a team's blocks work in.
    TeamArgs {
        exchange_x: Pointer<[f32; 4]>,
        exchange_v: Pointer<[f32; 2]>,
        barrier: Pointer<u32>,
        spill: Pointer<[f32; 4]>,
        spill_stride: u32,
        pad: u32,
    }
}

device_struct! {
    /// A rigid obstacle.
    Collider {
        from: [f32; 3],
        radius: f32,
        axis: [f32; 3],
        friction: f32,
        restitution: f32,
        body: u32,
        face: u32,
        faces: u32,
    }
}

device_struct! {
    /// A hold on nodes by a body.
    Grasp {
        body: u32,
        region: u32,
        attachment: u32,
        member: u32,
        members: u32,
        stiffness: f32,
        damping: f32,
        max_force: f32,
        low: [f32; 3],
        high: [f32; 3],
    }
}

device_struct! {
    /// Hold of a node in a frame.
    Hold {
        place: [f32; 3],
        grasp: i32,
    }
}

device_struct! {
    /// Part of a rod that is twisted in a frame.
    RodSpan {
        first: u32,
        end: u32,
        inverse_share: f32,
        kept: f32,
        roll_rate: f32,
        pad: u32,
    }
}

device_struct! {
    /// Surroundings of the object, and the memory that goes with them.
    WorldArgs {
        poses: Pointer<[f32; 4]>,
        colliders: Pointer<Collider>,
        faces: Pointer<[f32; 4]>,
        grasps: Pointer<Grasp>,
        members: Pointer<u32>,
        grasp_of: Pointer<i32>,
        closed: Pointer<u32>,
        rolls: Pointer<f32>,
        initial: Pointer<f32>,
        holds: Pointer<Hold>,
        phases: Pointer<u32>,
        spans: Pointer<RodSpan>,
        impulses: Pointer<f32>,
        control_impulses: Pointer<f32>,
        forces: Pointer<f32>,
        hold_sums: Pointer<f32>,
        body_sums: Pointer<f32>,
        roll_sums: Pointer<f32>,
        place_bars: Pointer<[f32; 4]>,
        arrive_bars: Pointer<[f32; 4]>,
        force_bars: Pointer<f32>,
        body_count: u32,
        collider_count: u32,
        grasp_count: u32,
        slot_count: u32,
        smoothing: f32,
        pad: u32,
    }
}

device_struct! {
    /// Contact of the skin.
    ClearanceArgs {
        skin: SkinArgs,
        distances: Pointer<f32>,
        points: Pointer<u32>,
        bars: Pointer<f32>,
        by_points: Pointer<[f32; 4]>,
        places: Pointer<f32>,
    }
}

device_struct! {
    /// An instance to simulate.
    InstanceArgs {
        topology: TopologyArgs,
        parameters: ParameterArgs,
        step: StepArgs,
        state: StateArgs,
        tape: TapeArgs,
        adjoint: AdjointArgs,
        contact: ContactArgs,
        team: TeamArgs,
        world: WorldArgs,
        clearance: ClearanceArgs,
    }
}
