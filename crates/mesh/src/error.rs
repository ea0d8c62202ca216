//! Reasons why a mesh cannot be read or used, with what its owner should do.

use bendtwin_core::Problem;

/// Why a mesh cannot be read, sampled or aligned.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Problem)]
pub enum Error {
    /// An extension that is not read.
    #[error("`{0}` is no mesh that can be read: export it as .glb, .obj or .ply")]
    #[problem(InvalidArgument, "UNKNOWN_MESH_FORMAT")]
    Format(String),
    /// A file that is cut off, corrupted or against its format.
    #[error("the mesh `{at}` is damaged: {fault}; export it again")]
    #[problem(InvalidArgument, "MESH_DAMAGED")]
    Damaged {
        /// The file.
        at: String,
        /// The fault.
        fault: String,
    },
    /// A header that claims more than there is.
    #[error(
        "the mesh `{at}` claims {claimed} bytes of data but holds {present}: it is cut off or its header is wrong"
    )]
    #[problem(InvalidArgument, "MESH_CLAIMS_TOO_MUCH")]
    Absurd {
        /// The file.
        at: String,
        /// Bytes that its header claims, saturated.
        claimed: u64,
        /// Bytes present.
        present: u64,
    },
    /// Beyond [`crate::Limits`].
    #[error("the mesh has {count} {what}, the limit is {limit}: decimate it first")]
    #[problem(ResourceExhausted, "MESH_TOO_MANY")]
    TooMany {
        /// Vertices or triangles.
        what: &'static str,
        /// Their number.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// A file beyond [`crate::Limits::file_bytes`].
    #[error("the mesh `{at}` has {bytes} bytes, the limit is {limit}: decimate it first")]
    #[problem(ResourceExhausted, "MESH_TOO_LARGE")]
    TooLarge {
        /// The file.
        at: String,
        /// Size of the file.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// A compressed mesh: Draco, meshopt and similar.
    #[error(
        "the mesh `{at}` is compressed with {extension}: export it without compression \
         (`gltf-transform copy in.glb out.glb` decodes it)"
    )]
    #[problem(InvalidArgument, "MESH_COMPRESSED")]
    Compressed {
        /// The file.
        at: String,
        /// The extension.
        extension: String,
    },
    /// Data in another file.
    #[error("the mesh `{at}` keeps its data in other files: export it as one binary .glb")]
    #[problem(InvalidArgument, "MESH_EXTERNAL_DATA")]
    External {
        /// The file.
        at: String,
    },
    /// A feature of its format that is not supported.
    #[error("the mesh `{at}` uses {what}, which is not read: export plain triangles")]
    #[problem(InvalidArgument, "MESH_UNSUPPORTED")]
    Unsupported {
        /// The file.
        at: String,
        /// The feature.
        what: String,
    },
    /// Without surface to sample.
    #[error("the mesh `{0}` has no triangles: export the surface, not points or lines")]
    #[problem(InvalidArgument, "MESH_EMPTY")]
    Empty(String),
    /// NaN or infinity.
    #[error(
        "the mesh `{at}` has a coordinate of vertex {vertex} that is not a finite number: export it again"
    )]
    #[problem(InvalidArgument, "MESH_NOT_FINITE")]
    NotFinite {
        /// The file.
        at: String,
        /// The vertex.
        vertex: usize,
    },
    /// A triangle without its corner.
    #[error(
        "the mesh `{at}` has a face that names vertex {vertex}, but there are {vertices}: export it again"
    )]
    #[problem(InvalidArgument, "MESH_INDEX_OUT_OF_RANGE")]
    IndexRange {
        /// The file.
        at: String,
        /// The vertex named.
        vertex: i64,
        /// Number of vertices.
        vertices: usize,
    },
    /// A spacing that is not a length, or one so fine that memory would not hold the samples.
    #[error(
        "a spacing of {spacing_m} m gives about {samples} samples, the limit is {limit}: use a wider one"
    )]
    #[problem(InvalidArgument, "MESH_SPACING_TOO_FINE")]
    Spacing {
        /// The spacing asked for [m].
        spacing_m: f32,
        /// Number of samples at that spacing, saturated.
        samples: u64,
        /// The limit.
        limit: u64,
    },
    /// Too many triangles lie in one place to tell inside from outside.
    #[error(
        "its {triangles} triangles lie in many layers, so inside and outside cannot be distinguished in bounded time: \
         merge the copies, or simplify the mesh"
    )]
    #[problem(InvalidArgument, "MESH_LAYERS")]
    Layers {
        /// Number of triangles.
        triangles: usize,
    },
    /// Too little to align to.
    #[error(
        "a mesh is aligned to at least {needed} observed points, there are {found}: look at the object's masks and depth"
    )]
    #[problem(FailedPrecondition, "MESH_TOO_FEW_POINTS")]
    TooFewPoints {
        /// Points needed.
        needed: usize,
        /// Finite points found.
        found: usize,
    },
    /// No pose of the mesh explains the observation.
    #[error(
        "the mesh fits only {share:.0} % of the observed points within {within_mm:.1} mm in its best pose: it shows \
         another object or another shape of it; align it by hand, or leave it out",
        share = inlier_share * 100.0, within_mm = within_m * 1e3
    )]
    #[problem(FailedPrecondition, "MESH_NOT_ALIGNED")]
    NotAligned {
        /// Observed points that lie on the mesh, 0 to 1.
        inlier_share: f64,
        /// Distance within which a point counts as on the mesh [m].
        within_m: f64,
    },
}
