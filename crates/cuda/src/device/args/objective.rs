//! Instances as the kernels beside the simulation have them: initial states, objectives, outputs.
//! Fields are described where the kernels declare them.

use bendtwin_core::Point;

use super::{Pin, Pointer, WorldArgs, device_struct};

device_struct! {
    /// Initial state of an instance.
    InitialArgs {
        initial: Pointer<f32>,
        states: Pointer<f32>,
        controls: Pointer<Point>,
        pin_of: Pointer<i32>,
        pins: Pointer<Pin>,
        initial_twists: Pointer<f32>,
        twists: Pointer<f32>,
        frame_s: f32,
        node_count: u32,
        rod_count: u32,
        control_count: u32,
        controls_move: u32,
        frame_count: u32,
        world: WorldArgs,
    }
}

device_struct! {
    Term {
        kind: u32,
        frame: u32,
        count: u32,
        first: u32,
        loss: u32,
        of: u32,
        beta: f32,
        weight: f32,
        part: u32,
        low: [f32; 3],
        high: [f32; 3],
    }
}

device_struct! {
    Piece {
        term: u32,
        first: u32,
    }
}

device_struct! {
    SkinArgs {
        starts: Pointer<u32>,
        nodes: Pointer<u32>,
        weights: Pointer<f32>,
        frames: Pointer<[u32; 3]>,
        offsets: Pointer<[f32; 3]>,
        node_starts: Pointer<u32>,
        carried: Pointer<u32>,
        carried_weights: Pointer<f32>,
        corner_starts: Pointer<u32>,
        corners: Pointer<[u32; 2]>,
        borne_starts: Pointer<u32>,
        borne: Pointer<u32>,
        point_count: u32,
        pad: u32,
    }
}

device_struct! {
    ObjectiveArgs {
        states: Pointer<f32>,
        terms: Pointer<Term>,
        frame_terms: Pointer<u32>,
        pieces: Pointer<Piece>,
        targets: Pointer<[f32; 3]>,
        target_points: Pointer<u32>,
        nearest: Pointer<u32>,
        values: Pointer<f64>,
        seeds: Pointer<f32>,
        springs: Pointer<[u32; 2]>,
        params: Pointer<f32>,
        spring_starts: Pointer<u32>,
        node_springs: Pointer<u32>,
        node_count: u32,
        surface_count: u32,
        frame_count: u32,
        term_count: u32,
        piece_count: u32,
        cut_every: u32,
        spring_count: u32,
        strained_count: u32,
        control_count: u32,
        skin_frame_count: u32,
        world: WorldArgs,
        force_bars: Pointer<f32>,
        skin: SkinArgs,
        skin_frames: Pointer<u32>,
        point_bars: Pointer<f32>,
    }
}

device_struct! {
    OutputArgs {
        states: Pointer<f32>,
        frames: Pointer<u32>,
        nodes: Pointer<u32>,
        positions: Pointer<[f32; 3]>,
        springs: Pointer<[u32; 2]>,
        params: Pointer<f32>,
        controls: Pointer<Point>,
        velocities: Pointer<[f32; 3]>,
        extremes: Pointer<[f32; 3]>,
        node_count: u32,
        recorded_nodes: u32,
        recorded_frames: u32,
        slot_count: u32,
        spring_count: u32,
        control_count: u32,
        frame_count: u32,
        pad: u32,
    }
}
