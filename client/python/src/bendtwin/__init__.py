"""BendTwin from Python: upload captures, watch fits, roll out twins.

from bendtwin import Client, Returns

with Client("127.0.0.1:7070") as client:
    capture = client.upload_capture("rope.zip")
    fit = client.wait(client.fit(capture.name))
    twin = client.twin(fit.twin)
    result = twin.rollout(trajectories=controls, returns=Returns(every_frames=1))
    result.positions  # [B, T, N, 3], metres
"""

from bendtwin.actions import CaptureFrame, GivenState, InitialState, Rest
from bendtwin.client import Client
from bendtwin.costs import Cost, Keypoints, Smoothness, TargetCloud
from bendtwin.errors import BendTwinError, Category, FitFailed, IngestFailed
from bendtwin.resources import Capture, Fault, Fit, Job, JobState, Progress, TwinInfo, Worker
from bendtwin.rollout import Deviation, Diagnostics, Divergence, Returns, RolloutResult, Timing
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
    "GivenState",
    "IngestFailed",
    "InitialState",
    "Job",
    "JobState",
    "Keypoints",
    "Progress",
    "Rest",
    "Returns",
    "RolloutResult",
    "Smoothness",
    "TargetCloud",
    "Timing",
    "Twin",
    "TwinInfo",
    "Worker",
]
