"""BendTwin from Python: upload captures, watch fits, roll out twins.

from bendtwin import Client, Returns

with Client("127.0.0.1:7070") as client:
    capture = client.upload_capture("rope.zip")
    fit = client.wait(client.fit(capture.name))
    twin = client.twin(fit.twin)
    result = twin.rollout(trajectories=controls, returns=Returns(every_frames=1))
    result.positions  # [B, T, N, 3], metres
"""

from bendtwin.client import Client
from bendtwin.costs import Cost, Keypoints, Smoothness, TargetCloud
from bendtwin.errors import BendTwinError, Category, FitFailed, IngestFailed
from bendtwin.geometry import Geometry, Ground
from bendtwin.interpolation import Interpolation, interpolate, interpolate_poses
from bendtwin.resources import Capture, Fault, Fit, Job, JobState, Progress, TwinInfo, Worker
from bendtwin.rollout import Deviation, Diagnostics, Divergence, Returns, RolloutResult, Timing
from bendtwin.state import (
    CaptureFrame,
    GivenState,
    Grasping,
    InitialState,
    Rest,
    Settled,
    State,
)
from bendtwin.twin import Twin

__all__ = [
    "BendTwinError",
    "Capture",
    "CaptureFrame",
    "Category",
    "Client",
    "Cost",
    "Deviation",
    "Diagnostics",
    "Divergence",
    "Fault",
    "Fit",
    "FitFailed",
    "Geometry",
    "GivenState",
    "Grasping",
    "Ground",
    "IngestFailed",
    "InitialState",
    "Interpolation",
    "Job",
    "JobState",
    "Keypoints",
    "Progress",
    "Rest",
    "Returns",
    "RolloutResult",
    "Settled",
    "Smoothness",
    "State",
    "TargetCloud",
    "Timing",
    "Twin",
    "TwinInfo",
    "Worker",
    "interpolate",
    "interpolate_poses",
]
