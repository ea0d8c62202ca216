from bendtwin.v1 import options_pb2 as _options_pb2
from bendtwin.v1 import fault_pb2 as _fault_pb2
from bendtwin.v1 import planning_pb2 as _planning_pb2
from bendtwin.v1 import registration_pb2 as _registration_pb2
from bendtwin.v1 import rollout_pb2 as _rollout_pb2
from bendtwin.v1 import world_pb2 as _world_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Session(_message.Message):
    __slots__ = ("name", "twin", "slots", "frames", "idle_timeout_s", "worker", "fidelity", "lost")
    NAME_FIELD_NUMBER: _ClassVar[int]
    TWIN_FIELD_NUMBER: _ClassVar[int]
    SLOTS_FIELD_NUMBER: _ClassVar[int]
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    IDLE_TIMEOUT_S_FIELD_NUMBER: _ClassVar[int]
    WORKER_FIELD_NUMBER: _ClassVar[int]
    FIDELITY_FIELD_NUMBER: _ClassVar[int]
    LOST_FIELD_NUMBER: _ClassVar[int]
    name: str
    twin: str
    slots: int
    frames: _containers.RepeatedScalarFieldContainer[int]
    idle_timeout_s: float
    worker: str
    fidelity: _rollout_pb2.Fidelity
    lost: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, name: _Optional[str] = ..., twin: _Optional[str] = ..., slots: _Optional[int] = ..., frames: _Optional[_Iterable[int]] = ..., idle_timeout_s: _Optional[float] = ..., worker: _Optional[str] = ..., fidelity: _Optional[_Union[_rollout_pb2.Fidelity, str]] = ..., lost: _Optional[_Iterable[int]] = ...) -> None: ...

class Tracking(_message.Message):
    __slots__ = ("lost", "misfit", "unexplained")
    LOST_FIELD_NUMBER: _ClassVar[int]
    MISFIT_FIELD_NUMBER: _ClassVar[int]
    UNEXPLAINED_FIELD_NUMBER: _ClassVar[int]
    lost: bool
    misfit: float
    unexplained: int
    def __init__(self, lost: bool = ..., misfit: _Optional[float] = ..., unexplained: _Optional[int] = ...) -> None: ...

class OpenSessionRequest(_message.Message):
    __slots__ = ("twin", "initial", "slots", "world", "grasps", "fidelity", "idle_timeout_s")
    TWIN_FIELD_NUMBER: _ClassVar[int]
    INITIAL_FIELD_NUMBER: _ClassVar[int]
    SLOTS_FIELD_NUMBER: _ClassVar[int]
    WORLD_FIELD_NUMBER: _ClassVar[int]
    GRASPS_FIELD_NUMBER: _ClassVar[int]
    FIDELITY_FIELD_NUMBER: _ClassVar[int]
    IDLE_TIMEOUT_S_FIELD_NUMBER: _ClassVar[int]
    twin: str
    initial: _rollout_pb2.InitialState
    slots: int
    world: _world_pb2.World
    grasps: _containers.RepeatedCompositeFieldContainer[_world_pb2.Grasp]
    fidelity: _rollout_pb2.Fidelity
    idle_timeout_s: float
    def __init__(self, twin: _Optional[str] = ..., initial: _Optional[_Union[_rollout_pb2.InitialState, _Mapping]] = ..., slots: _Optional[int] = ..., world: _Optional[_Union[_world_pb2.World, _Mapping]] = ..., grasps: _Optional[_Iterable[_Union[_world_pb2.Grasp, _Mapping]]] = ..., fidelity: _Optional[_Union[_rollout_pb2.Fidelity, str]] = ..., idle_timeout_s: _Optional[float] = ...) -> None: ...

class GetSessionRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class GetSessionStatesRequest(_message.Message):
    __slots__ = ("name", "slots")
    NAME_FIELD_NUMBER: _ClassVar[int]
    SLOTS_FIELD_NUMBER: _ClassVar[int]
    name: str
    slots: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, name: _Optional[str] = ..., slots: _Optional[_Iterable[int]] = ...) -> None: ...

class SessionStates(_message.Message):
    __slots__ = ("states", "slots", "frames")
    STATES_FIELD_NUMBER: _ClassVar[int]
    SLOTS_FIELD_NUMBER: _ClassVar[int]
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    states: _rollout_pb2.InitialState.GivenState
    slots: _containers.RepeatedScalarFieldContainer[int]
    frames: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, states: _Optional[_Union[_rollout_pb2.InitialState.GivenState, _Mapping]] = ..., slots: _Optional[_Iterable[int]] = ..., frames: _Optional[_Iterable[int]] = ...) -> None: ...

class AdvanceSessionRequest(_message.Message):
    __slots__ = ("name", "slots", "rollout")
    NAME_FIELD_NUMBER: _ClassVar[int]
    SLOTS_FIELD_NUMBER: _ClassVar[int]
    ROLLOUT_FIELD_NUMBER: _ClassVar[int]
    name: str
    slots: _containers.RepeatedScalarFieldContainer[int]
    rollout: _rollout_pb2.RollOutRequest
    def __init__(self, name: _Optional[str] = ..., slots: _Optional[_Iterable[int]] = ..., rollout: _Optional[_Union[_rollout_pb2.RollOutRequest, _Mapping]] = ...) -> None: ...

class ForkSessionRequest(_message.Message):
    __slots__ = ("name", "to")
    NAME_FIELD_NUMBER: _ClassVar[int]
    FROM_FIELD_NUMBER: _ClassVar[int]
    TO_FIELD_NUMBER: _ClassVar[int]
    name: str
    to: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, name: _Optional[str] = ..., to: _Optional[_Iterable[int]] = ..., **kwargs) -> None: ...

class ResetSessionRequest(_message.Message):
    __slots__ = ("name", "slots", "initial")
    NAME_FIELD_NUMBER: _ClassVar[int]
    SLOTS_FIELD_NUMBER: _ClassVar[int]
    INITIAL_FIELD_NUMBER: _ClassVar[int]
    name: str
    slots: _containers.RepeatedScalarFieldContainer[int]
    initial: _rollout_pb2.InitialState
    def __init__(self, name: _Optional[str] = ..., slots: _Optional[_Iterable[int]] = ..., initial: _Optional[_Union[_rollout_pb2.InitialState, _Mapping]] = ...) -> None: ...

class CorrectSessionRequest(_message.Message):
    __slots__ = ("name", "slots", "observation", "options")
    NAME_FIELD_NUMBER: _ClassVar[int]
    SLOTS_FIELD_NUMBER: _ClassVar[int]
    OBSERVATION_FIELD_NUMBER: _ClassVar[int]
    OPTIONS_FIELD_NUMBER: _ClassVar[int]
    name: str
    slots: _containers.RepeatedScalarFieldContainer[int]
    observation: _registration_pb2.Observation
    options: _registration_pb2.CorrectOptions
    def __init__(self, name: _Optional[str] = ..., slots: _Optional[_Iterable[int]] = ..., observation: _Optional[_Union[_registration_pb2.Observation, _Mapping]] = ..., options: _Optional[_Union[_registration_pb2.CorrectOptions, _Mapping]] = ...) -> None: ...

class CorrectedSession(_message.Message):
    __slots__ = ("session", "corrections")
    class Correction(_message.Message):
        __slots__ = ("slot", "before", "after", "moved_mm", "state", "tracking", "registered")
        SLOT_FIELD_NUMBER: _ClassVar[int]
        BEFORE_FIELD_NUMBER: _ClassVar[int]
        AFTER_FIELD_NUMBER: _ClassVar[int]
        MOVED_MM_FIELD_NUMBER: _ClassVar[int]
        STATE_FIELD_NUMBER: _ClassVar[int]
        TRACKING_FIELD_NUMBER: _ClassVar[int]
        REGISTERED_FIELD_NUMBER: _ClassVar[int]
        slot: int
        before: _registration_pb2.Residual
        after: _registration_pb2.Residual
        moved_mm: float
        state: _rollout_pb2.InitialState.GivenState
        tracking: Tracking
        registered: bool
        def __init__(self, slot: _Optional[int] = ..., before: _Optional[_Union[_registration_pb2.Residual, _Mapping]] = ..., after: _Optional[_Union[_registration_pb2.Residual, _Mapping]] = ..., moved_mm: _Optional[float] = ..., state: _Optional[_Union[_rollout_pb2.InitialState.GivenState, _Mapping]] = ..., tracking: _Optional[_Union[Tracking, _Mapping]] = ..., registered: bool = ...) -> None: ...
    SESSION_FIELD_NUMBER: _ClassVar[int]
    CORRECTIONS_FIELD_NUMBER: _ClassVar[int]
    session: Session
    corrections: _containers.RepeatedCompositeFieldContainer[CorrectedSession.Correction]
    def __init__(self, session: _Optional[_Union[Session, _Mapping]] = ..., corrections: _Optional[_Iterable[_Union[CorrectedSession.Correction, _Mapping]]] = ...) -> None: ...

class StepSessionRequest(_message.Message):
    __slots__ = ("name", "slot", "correction", "search", "execute_frames", "returns", "deadline_s")
    NAME_FIELD_NUMBER: _ClassVar[int]
    SLOT_FIELD_NUMBER: _ClassVar[int]
    CORRECTION_FIELD_NUMBER: _ClassVar[int]
    SEARCH_FIELD_NUMBER: _ClassVar[int]
    EXECUTE_FRAMES_FIELD_NUMBER: _ClassVar[int]
    RETURNS_FIELD_NUMBER: _ClassVar[int]
    DEADLINE_S_FIELD_NUMBER: _ClassVar[int]
    name: str
    slot: int
    correction: CorrectSessionRequest
    search: _planning_pb2.PlanRequest
    execute_frames: int
    returns: _rollout_pb2.Returns
    deadline_s: float
    def __init__(self, name: _Optional[str] = ..., slot: _Optional[int] = ..., correction: _Optional[_Union[CorrectSessionRequest, _Mapping]] = ..., search: _Optional[_Union[_planning_pb2.PlanRequest, _Mapping]] = ..., execute_frames: _Optional[int] = ..., returns: _Optional[_Union[_rollout_pb2.Returns, _Mapping]] = ..., deadline_s: _Optional[float] = ...) -> None: ...

class SteppedSession(_message.Message):
    __slots__ = ("corrected", "refused", "plan", "advanced", "state", "times", "lost")
    class Times(_message.Message):
        __slots__ = ("correct_s", "plan_s", "advance_s", "total_s")
        CORRECT_S_FIELD_NUMBER: _ClassVar[int]
        PLAN_S_FIELD_NUMBER: _ClassVar[int]
        ADVANCE_S_FIELD_NUMBER: _ClassVar[int]
        TOTAL_S_FIELD_NUMBER: _ClassVar[int]
        correct_s: float
        plan_s: float
        advance_s: float
        total_s: float
        def __init__(self, correct_s: _Optional[float] = ..., plan_s: _Optional[float] = ..., advance_s: _Optional[float] = ..., total_s: _Optional[float] = ...) -> None: ...
    CORRECTED_FIELD_NUMBER: _ClassVar[int]
    REFUSED_FIELD_NUMBER: _ClassVar[int]
    PLAN_FIELD_NUMBER: _ClassVar[int]
    ADVANCED_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    TIMES_FIELD_NUMBER: _ClassVar[int]
    LOST_FIELD_NUMBER: _ClassVar[int]
    corrected: CorrectedSession
    refused: _fault_pb2.Fault
    plan: _planning_pb2.PlanUpdate
    advanced: _rollout_pb2.RollOutResponse
    state: _rollout_pb2.InitialState.GivenState
    times: SteppedSession.Times
    lost: bool
    def __init__(self, corrected: _Optional[_Union[CorrectedSession, _Mapping]] = ..., refused: _Optional[_Union[_fault_pb2.Fault, _Mapping]] = ..., plan: _Optional[_Union[_planning_pb2.PlanUpdate, _Mapping]] = ..., advanced: _Optional[_Union[_rollout_pb2.RollOutResponse, _Mapping]] = ..., state: _Optional[_Union[_rollout_pb2.InitialState.GivenState, _Mapping]] = ..., times: _Optional[_Union[SteppedSession.Times, _Mapping]] = ..., lost: bool = ...) -> None: ...

class CloseSessionRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class CloseSessionResponse(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...
