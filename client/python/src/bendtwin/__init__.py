"""BendTwin from Python: upload captures, watch fits, roll out twins.

from bendtwin import Client, Returns

with Client("127.0.0.1:7070") as client:
    capture = client.upload_capture("rope.zip")
    fit = client.wait(client.fit(capture.name))
    twin = client.twin(fit.twin)
    result = twin.rollout(trajectories=controls, returns=Returns(every_frames=1))
    result.positions  # [B, T, N, 3], metres
"""

from bendtwin.captures.motion import Motion
from bendtwin.client import Client
from bendtwin.errors import BendTwinError, Category, FitFailed, IngestFailed
from bendtwin.geometry import Geometry, Ground
from bendtwin.labels import (
    CaptureArguments,
    CaptureLabelArguments,
    CaptureListArguments,
    LabelArguments,
    ListArguments,
)
from bendtwin.resources import (
    Capture,
    Fault,
    Fit,
    FitPreview,
    Job,
    JobState,
    LossCurve,
    MadeShare,
    ModelLoss,
    OwnerUsage,
    Progress,
    Project,
    Quotas,
    Requirements,
    SessionInfo,
    Share,
    StoredBytes,
    Supplement,
    Trashed,
    TwinInfo,
    Worker,
)
from bendtwin.session import Session
from bendtwin.simulation.arguments import RolloutArguments
from bendtwin.simulation.bounds import Bounds
from bendtwin.simulation.costs import (
    Clearance,
    ControlPath,
    ControlSpeed,
    Cost,
    Coverage,
    Force,
    Height,
    Keypoints,
    Order,
    Smoothness,
    Strain,
    TargetCloud,
    Winding,
    Within,
)
from bendtwin.simulation.interpolation import Interpolation, interpolate, interpolate_poses
from bendtwin.simulation.pictures import Light, PictureCamera, Pictures, Prop
from bendtwin.simulation.places import GraspPlaces, grasp_places
from bendtwin.simulation.plan import GraspSearch, PlanArguments, PlanUpdate, Search
from bendtwin.simulation.registration import Correction, Registration, Residual, Tracking
from bendtwin.simulation.rollout import (
    Deviation,
    Diagnostics,
    Divergence,
    Forces,
    Implausible,
    Returns,
    RolloutResult,
    Timing,
)
from bendtwin.simulation.state import (
    CaptureFrame,
    GivenState,
    Grasping,
    InitialState,
    Rest,
    SessionSlots,
    Settled,
    State,
)
from bendtwin.simulation.step import Step
from bendtwin.simulation.world import (
    Capsule,
    Collider,
    ConvexMesh,
    Cuboid,
    Ensemble,
    GradientOptions,
    Grasp,
    Plane,
    Plausibility,
    Sphere,
    Vary,
    World,
)
from bendtwin.skin import Skin
from bendtwin.surface import Surface, Tube
from bendtwin.twin import Twin

__all__ = [
    "BendTwinError",
    "Bounds",
    "Capsule",
    "Capture",
    "CaptureArguments",
    "CaptureFrame",
    "CaptureLabelArguments",
    "CaptureListArguments",
    "Category",
    "Clearance",
    "Client",
    "Collider",
    "ControlPath",
    "ControlSpeed",
    "ConvexMesh",
    "Correction",
    "Cost",
    "Coverage",
    "Cuboid",
    "Deviation",
    "Diagnostics",
    "Divergence",
    "Ensemble",
    "Fault",
    "Fit",
    "FitFailed",
    "FitPreview",
    "Force",
    "Forces",
    "Geometry",
    "GivenState",
    "GradientOptions",
    "Grasp",
    "GraspPlaces",
    "GraspSearch",
    "Grasping",
    "Ground",
    "Height",
    "Implausible",
    "IngestFailed",
    "InitialState",
    "Interpolation",
    "Job",
    "JobState",
    "Keypoints",
    "LabelArguments",
    "Light",
    "ListArguments",
    "LossCurve",
    "MadeShare",
    "ModelLoss",
    "Motion",
    "Order",
    "OwnerUsage",
    "PictureCamera",
    "Pictures",
    "PlanArguments",
    "PlanUpdate",
    "Plane",
    "Plausibility",
    "Progress",
    "Project",
    "Prop",
    "Quotas",
    "Registration",
    "Requirements",
    "Residual",
    "Rest",
    "Returns",
    "RolloutArguments",
    "RolloutResult",
    "Search",
    "Session",
    "SessionInfo",
    "SessionSlots",
    "Settled",
    "Share",
    "Skin",
    "Smoothness",
    "Sphere",
    "State",
    "Step",
    "StoredBytes",
    "Strain",
    "Supplement",
    "Surface",
    "TargetCloud",
    "Timing",
    "Tracking",
    "Trashed",
    "Tube",
    "Twin",
    "TwinInfo",
    "Vary",
    "Winding",
    "Within",
    "Worker",
    "World",
    "grasp_places",
    "interpolate",
    "interpolate_poses",
]
