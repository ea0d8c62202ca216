//! Parameters of the kernels of Gaussian splats. Fields are described beside each kernel.

use super::{Pointer, device_struct};

device_struct! {
    /// A pinhole camera and its tiles.
    SplatCamera {
        rows: [[f32; 4]; 3],
        fx: f32,
        fy: f32,
        cx: f32,
        cy: f32,
        width: u32,
        height: u32,
        columns: u32,
        tiles: u32,
    }
}

device_struct! {
    /// Gaussians in space.
    SplatSet {
        rotations: Pointer<[f32; 4]>,
        means: Pointer<f32>,
        scales: Pointer<f32>,
        colors: Pointer<f32>,
        opacities: Pointer<f32>,
        count: u32,
        pad: u32,
    }
}

device_struct! {
    /// A projected Gaussian, as pixels need it.
    Splat {
        a: [f32; 4],
        b: [f32; 4],
        c: [f32; 4],
    }
}

device_struct! {
    /// A projected Gaussian, as tiles need it.
    Extent {
        reach: f32,
        lean: f32,
        slope: f32,
        half_width: f32,
    }
}

device_struct! {
    /// Parameters of `splat_project`.
    SplatProjectArgs {
        set: SplatSet,
        camera: SplatCamera,
        splats: Pointer<Splat>,
        extents: Pointer<Extent>,
        counts: Pointer<u32>,
        keys: Pointer<u32>,
        indices: Pointer<u32>,
    }
}

device_struct! {
    /// Parameters of `splat_histogram`.
    SplatHistogramArgs {
        keys: Pointer<u32>,
        counts: Pointer<u32>,
        count: u32,
        shift: u32,
    }
}

device_struct! {
    /// Parameters of `splat_scan`.
    SplatScanArgs {
        values: Pointer<u32>,
        total: Pointer<u64>,
        count: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `splat_scatter`.
    SplatScatterArgs {
        keys: Pointer<u32>,
        values: Pointer<u32>,
        sorted_keys: Pointer<u32>,
        sorted_values: Pointer<u32>,
        offsets: Pointer<u32>,
        count: u32,
        shift: u32,
    }
}

device_struct! {
    /// Parameters of `splat_counts`.
    SplatCountsArgs {
        counts: Pointer<u32>,
        order: Pointer<u32>,
        offsets: Pointer<u32>,
        count: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `splat_expand`.
    SplatExpandArgs {
        camera: SplatCamera,
        splats: Pointer<Splat>,
        extents: Pointer<Extent>,
        counts: Pointer<u32>,
        order: Pointer<u32>,
        offsets: Pointer<u32>,
        keys: Pointer<u32>,
        values: Pointer<u32>,
        owners: Pointer<u32>,
        count: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `splat_ranges`.
    SplatRangesArgs {
        keys: Pointer<u32>,
        values: Pointer<u32>,
        owners: Pointer<u32>,
        entries: Pointer<u32>,
        ranges: Pointer<[u32; 2]>,
        count: u32,
        pad: u32,
    }
}

device_struct! {
    /// Parameters of `splat_forward`.
    SplatForwardArgs {
        camera: SplatCamera,
        splats: Pointer<Splat>,
        entries: Pointer<u32>,
        ranges: Pointer<[u32; 2]>,
        color: Pointer<f32>,
        alpha: Pointer<f32>,
        depth: Pointer<f32>,
    }
}

device_struct! {
    /// Parameters of `splat_backward`.
    SplatBackwardArgs {
        camera: SplatCamera,
        splats: Pointer<Splat>,
        entries: Pointer<u32>,
        places: Pointer<u32>,
        ranges: Pointer<[u32; 2]>,
        color: Pointer<f32>,
        alpha: Pointer<f32>,
        depth: Pointer<f32>,
        color_bar: Pointer<f32>,
        alpha_bar: Pointer<f32>,
        depth_bar: Pointer<f32>,
        moments: Pointer<f32>,
    }
}

device_struct! {
    /// Parameters of `splat_adjoint`.
    SplatAdjointArgs {
        set: SplatSet,
        camera: SplatCamera,
        splats: Pointer<Splat>,
        counts: Pointer<u32>,
        order: Pointer<u32>,
        offsets: Pointer<u32>,
        moments: Pointer<f32>,
        rotations: Pointer<[f32; 4]>,
        means: Pointer<f32>,
        scales: Pointer<f32>,
        colors: Pointer<f32>,
        opacities: Pointer<f32>,
        screen: Pointer<f32>,
    }
}
