from bendtwin.v1 import options_pb2 as _options_pb2
from bendtwin.v1 import tensor_pb2 as _tensor_pb2
from bendtwin.v1 import world_pb2 as _world_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Fidelity(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    FIDELITY_UNSPECIFIED: _ClassVar[Fidelity]
    EXACT: _ClassVar[Fidelity]
    FAST: _ClassVar[Fidelity]
    PLANNER: _ClassVar[Fidelity]

class PointSet(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    POINT_SET_UNSPECIFIED: _ClassVar[PointSet]
    NODES: _ClassVar[PointSet]
    SKIN: _ClassVar[PointSet]

class Interpolation(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    INTERPOLATION_UNSPECIFIED: _ClassVar[Interpolation]
    LINEAR: _ClassVar[Interpolation]
    CUBIC: _ClassVar[Interpolation]
    ZERO: _ClassVar[Interpolation]
FIDELITY_UNSPECIFIED: Fidelity
EXACT: Fidelity
FAST: Fidelity
PLANNER: Fidelity
POINT_SET_UNSPECIFIED: PointSet
NODES: PointSet
SKIN: PointSet
INTERPOLATION_UNSPECIFIED: Interpolation
LINEAR: Interpolation
CUBIC: Interpolation
ZERO: Interpolation

class RollOutRequest(_message.Message):
    __slots__ = ("twin", "trajectories", "poses", "initial", "frames", "costs", "returns", "fidelity", "world", "grasps", "vary", "ensemble", "gradient", "plausibility", "knot_times", "time_limit_s")
    TWIN_FIELD_NUMBER: _ClassVar[int]
    TRAJECTORIES_FIELD_NUMBER: _ClassVar[int]
    POSES_FIELD_NUMBER: _ClassVar[int]
    INITIAL_FIELD_NUMBER: _ClassVar[int]
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    COSTS_FIELD_NUMBER: _ClassVar[int]
    RETURNS_FIELD_NUMBER: _ClassVar[int]
    FIDELITY_FIELD_NUMBER: _ClassVar[int]
    WORLD_FIELD_NUMBER: _ClassVar[int]
    GRASPS_FIELD_NUMBER: _ClassVar[int]
    VARY_FIELD_NUMBER: _ClassVar[int]
    ENSEMBLE_FIELD_NUMBER: _ClassVar[int]
    GRADIENT_FIELD_NUMBER: _ClassVar[int]
    PLAUSIBILITY_FIELD_NUMBER: _ClassVar[int]
    KNOT_TIMES_FIELD_NUMBER: _ClassVar[int]
    TIME_LIMIT_S_FIELD_NUMBER: _ClassVar[int]
    twin: str
    trajectories: ControlTrajectories
    poses: GripperPoses
    initial: InitialState
    frames: int
    costs: _containers.RepeatedCompositeFieldContainer[Cost]
    returns: Returns
    fidelity: Fidelity
    world: _world_pb2.World
    grasps: _containers.RepeatedCompositeFieldContainer[_world_pb2.Grasp]
    vary: _world_pb2.Vary
    ensemble: Ensemble
    gradient: GradientOptions
    plausibility: Plausibility
    knot_times: KnotTimes
    time_limit_s: float
    def __init__(self, twin: _Optional[str] = ..., trajectories: _Optional[_Union[ControlTrajectories, _Mapping]] = ..., poses: _Optional[_Union[GripperPoses, _Mapping]] = ..., initial: _Optional[_Union[InitialState, _Mapping]] = ..., frames: _Optional[int] = ..., costs: _Optional[_Iterable[_Union[Cost, _Mapping]]] = ..., returns: _Optional[_Union[Returns, _Mapping]] = ..., fidelity: _Optional[_Union[Fidelity, str]] = ..., world: _Optional[_Union[_world_pb2.World, _Mapping]] = ..., grasps: _Optional[_Iterable[_Union[_world_pb2.Grasp, _Mapping]]] = ..., vary: _Optional[_Union[_world_pb2.Vary, _Mapping]] = ..., ensemble: _Optional[_Union[Ensemble, _Mapping]] = ..., gradient: _Optional[_Union[GradientOptions, _Mapping]] = ..., plausibility: _Optional[_Union[Plausibility, _Mapping]] = ..., knot_times: _Optional[_Union[KnotTimes, _Mapping]] = ..., time_limit_s: _Optional[float] = ...) -> None: ...

class KnotTimes(_message.Message):
    __slots__ = ("at_s", "period_s")
    AT_S_FIELD_NUMBER: _ClassVar[int]
    PERIOD_S_FIELD_NUMBER: _ClassVar[int]
    at_s: _tensor_pb2.Tensor
    period_s: float
    def __init__(self, at_s: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., period_s: _Optional[float] = ...) -> None: ...

class Ensemble(_message.Message):
    __slots__ = ("members", "statistic", "share")
    class Statistic(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        STATISTIC_UNSPECIFIED: _ClassVar[Ensemble.Statistic]
        MEAN: _ClassVar[Ensemble.Statistic]
        WORST: _ClassVar[Ensemble.Statistic]
        CVAR: _ClassVar[Ensemble.Statistic]
        MEAN_PREDICTION: _ClassVar[Ensemble.Statistic]
    STATISTIC_UNSPECIFIED: Ensemble.Statistic
    MEAN: Ensemble.Statistic
    WORST: Ensemble.Statistic
    CVAR: Ensemble.Statistic
    MEAN_PREDICTION: Ensemble.Statistic
    MEMBERS_FIELD_NUMBER: _ClassVar[int]
    STATISTIC_FIELD_NUMBER: _ClassVar[int]
    SHARE_FIELD_NUMBER: _ClassVar[int]
    members: int
    statistic: Ensemble.Statistic
    share: float
    def __init__(self, members: _Optional[int] = ..., statistic: _Optional[_Union[Ensemble.Statistic, str]] = ..., share: _Optional[float] = ...) -> None: ...

class GradientOptions(_message.Message):
    __slots__ = ("reach_frames", "smoothing_m")
    REACH_FRAMES_FIELD_NUMBER: _ClassVar[int]
    SMOOTHING_M_FIELD_NUMBER: _ClassVar[int]
    reach_frames: int
    smoothing_m: float
    def __init__(self, reach_frames: _Optional[int] = ..., smoothing_m: _Optional[float] = ...) -> None: ...

class Plausibility(_message.Message):
    __slots__ = ("start_gap_m", "control_speed_m_s", "strain", "refuse", "control_depth_m")
    START_GAP_M_FIELD_NUMBER: _ClassVar[int]
    CONTROL_SPEED_M_S_FIELD_NUMBER: _ClassVar[int]
    STRAIN_FIELD_NUMBER: _ClassVar[int]
    REFUSE_FIELD_NUMBER: _ClassVar[int]
    CONTROL_DEPTH_M_FIELD_NUMBER: _ClassVar[int]
    start_gap_m: float
    control_speed_m_s: float
    strain: float
    refuse: bool
    control_depth_m: float
    def __init__(self, start_gap_m: _Optional[float] = ..., control_speed_m_s: _Optional[float] = ..., strain: _Optional[float] = ..., refuse: bool = ..., control_depth_m: _Optional[float] = ...) -> None: ...

class ControlTrajectories(_message.Message):
    __slots__ = ("positions", "interpolation")
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    INTERPOLATION_FIELD_NUMBER: _ClassVar[int]
    positions: _tensor_pb2.Tensor
    interpolation: Interpolation
    def __init__(self, positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., interpolation: _Optional[_Union[Interpolation, str]] = ...) -> None: ...

class GripperPoses(_message.Message):
    __slots__ = ("poses", "gripper_of_control", "interpolation")
    POSES_FIELD_NUMBER: _ClassVar[int]
    GRIPPER_OF_CONTROL_FIELD_NUMBER: _ClassVar[int]
    INTERPOLATION_FIELD_NUMBER: _ClassVar[int]
    poses: _tensor_pb2.Tensor
    gripper_of_control: _tensor_pb2.Tensor
    interpolation: Interpolation
    def __init__(self, poses: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., gripper_of_control: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., interpolation: _Optional[_Union[Interpolation, str]] = ...) -> None: ...

class InitialState(_message.Message):
    __slots__ = ("rest", "capture_frame", "given", "settled", "session")
    class Rest(_message.Message):
        __slots__ = ()
        def __init__(self) -> None: ...
    class Settled(_message.Message):
        __slots__ = ()
        def __init__(self) -> None: ...
    class SessionSlots(_message.Message):
        __slots__ = ("session", "slots")
        SESSION_FIELD_NUMBER: _ClassVar[int]
        SLOTS_FIELD_NUMBER: _ClassVar[int]
        session: str
        slots: _containers.RepeatedScalarFieldContainer[int]
        def __init__(self, session: _Optional[str] = ..., slots: _Optional[_Iterable[int]] = ...) -> None: ...
    class CaptureFrame(_message.Message):
        __slots__ = ("capture", "sequence", "frame")
        CAPTURE_FIELD_NUMBER: _ClassVar[int]
        SEQUENCE_FIELD_NUMBER: _ClassVar[int]
        FRAME_FIELD_NUMBER: _ClassVar[int]
        capture: str
        sequence: int
        frame: int
        def __init__(self, capture: _Optional[str] = ..., sequence: _Optional[int] = ..., frame: _Optional[int] = ...) -> None: ...
    class GivenState(_message.Message):
        __slots__ = ("positions", "velocities", "twists", "controls", "grasping", "commanded_controls")
        POSITIONS_FIELD_NUMBER: _ClassVar[int]
        VELOCITIES_FIELD_NUMBER: _ClassVar[int]
        TWISTS_FIELD_NUMBER: _ClassVar[int]
        CONTROLS_FIELD_NUMBER: _ClassVar[int]
        GRASPING_FIELD_NUMBER: _ClassVar[int]
        COMMANDED_CONTROLS_FIELD_NUMBER: _ClassVar[int]
        positions: _tensor_pb2.Tensor
        velocities: _tensor_pb2.Tensor
        twists: _tensor_pb2.Tensor
        controls: _tensor_pb2.Tensor
        grasping: _world_pb2.Grasping
        commanded_controls: _tensor_pb2.Tensor
        def __init__(self, positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., velocities: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., twists: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., controls: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., grasping: _Optional[_Union[_world_pb2.Grasping, _Mapping]] = ..., commanded_controls: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
    REST_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FRAME_FIELD_NUMBER: _ClassVar[int]
    GIVEN_FIELD_NUMBER: _ClassVar[int]
    SETTLED_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    rest: InitialState.Rest
    capture_frame: InitialState.CaptureFrame
    given: InitialState.GivenState
    settled: InitialState.Settled
    session: InitialState.SessionSlots
    def __init__(self, rest: _Optional[_Union[InitialState.Rest, _Mapping]] = ..., capture_frame: _Optional[_Union[InitialState.CaptureFrame, _Mapping]] = ..., given: _Optional[_Union[InitialState.GivenState, _Mapping]] = ..., settled: _Optional[_Union[InitialState.Settled, _Mapping]] = ..., session: _Optional[_Union[InitialState.SessionSlots, _Mapping]] = ...) -> None: ...

class Cost(_message.Message):
    __slots__ = ("name", "weight", "when", "target_cloud", "keypoints", "smoothness", "strain", "force", "height", "within", "clearance", "control_path", "control_speed", "temperature")
    class When(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        WHEN_UNSPECIFIED: _ClassVar[Cost.When]
        LAST_FRAME: _ClassVar[Cost.When]
        EVERY_FRAME: _ClassVar[Cost.When]
        SOFT_MIN: _ClassVar[Cost.When]
    WHEN_UNSPECIFIED: Cost.When
    LAST_FRAME: Cost.When
    EVERY_FRAME: Cost.When
    SOFT_MIN: Cost.When
    class TargetCloud(_message.Message):
        __slots__ = ("points", "point_set")
        POINTS_FIELD_NUMBER: _ClassVar[int]
        POINT_SET_FIELD_NUMBER: _ClassVar[int]
        points: _tensor_pb2.Tensor
        point_set: PointSet
        def __init__(self, points: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., point_set: _Optional[_Union[PointSet, str]] = ...) -> None: ...
    class Keypoints(_message.Message):
        __slots__ = ("nodes", "targets", "squared", "skin_points")
        NODES_FIELD_NUMBER: _ClassVar[int]
        TARGETS_FIELD_NUMBER: _ClassVar[int]
        SQUARED_FIELD_NUMBER: _ClassVar[int]
        SKIN_POINTS_FIELD_NUMBER: _ClassVar[int]
        nodes: _tensor_pb2.Tensor
        targets: _tensor_pb2.Tensor
        squared: bool
        skin_points: _tensor_pb2.Tensor
        def __init__(self, nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., targets: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., squared: bool = ..., skin_points: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
    class Smoothness(_message.Message):
        __slots__ = ()
        def __init__(self) -> None: ...
    class Strain(_message.Message):
        __slots__ = ("limit",)
        LIMIT_FIELD_NUMBER: _ClassVar[int]
        limit: float
        def __init__(self, limit: _Optional[float] = ...) -> None: ...
    class Force(_message.Message):
        __slots__ = ("controls", "control", "grasp", "ground", "collider", "limit_n")
        class All(_message.Message):
            __slots__ = ()
            def __init__(self) -> None: ...
        CONTROLS_FIELD_NUMBER: _ClassVar[int]
        CONTROL_FIELD_NUMBER: _ClassVar[int]
        GRASP_FIELD_NUMBER: _ClassVar[int]
        GROUND_FIELD_NUMBER: _ClassVar[int]
        COLLIDER_FIELD_NUMBER: _ClassVar[int]
        LIMIT_N_FIELD_NUMBER: _ClassVar[int]
        controls: Cost.Force.All
        control: int
        grasp: int
        ground: Cost.Force.All
        collider: int
        limit_n: float
        def __init__(self, controls: _Optional[_Union[Cost.Force.All, _Mapping]] = ..., control: _Optional[int] = ..., grasp: _Optional[int] = ..., ground: _Optional[_Union[Cost.Force.All, _Mapping]] = ..., collider: _Optional[int] = ..., limit_n: _Optional[float] = ...) -> None: ...
    class Height(_message.Message):
        __slots__ = ("plane", "nodes")
        PLANE_FIELD_NUMBER: _ClassVar[int]
        NODES_FIELD_NUMBER: _ClassVar[int]
        plane: _world_pb2.Plane
        nodes: _tensor_pb2.Tensor
        def __init__(self, plane: _Optional[_Union[_world_pb2.Plane, _Mapping]] = ..., nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
    class Within(_message.Message):
        __slots__ = ("cuboid", "nodes")
        CUBOID_FIELD_NUMBER: _ClassVar[int]
        NODES_FIELD_NUMBER: _ClassVar[int]
        cuboid: _world_pb2.Cuboid
        nodes: _tensor_pb2.Tensor
        def __init__(self, cuboid: _Optional[_Union[_world_pb2.Cuboid, _Mapping]] = ..., nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
    class Clearance(_message.Message):
        __slots__ = ("collider", "margin_m")
        COLLIDER_FIELD_NUMBER: _ClassVar[int]
        MARGIN_M_FIELD_NUMBER: _ClassVar[int]
        collider: int
        margin_m: float
        def __init__(self, collider: _Optional[int] = ..., margin_m: _Optional[float] = ...) -> None: ...
    class ControlPath(_message.Message):
        __slots__ = ()
        def __init__(self) -> None: ...
    class ControlSpeed(_message.Message):
        __slots__ = ("limit_m_s",)
        LIMIT_M_S_FIELD_NUMBER: _ClassVar[int]
        limit_m_s: float
        def __init__(self, limit_m_s: _Optional[float] = ...) -> None: ...
    NAME_FIELD_NUMBER: _ClassVar[int]
    WEIGHT_FIELD_NUMBER: _ClassVar[int]
    WHEN_FIELD_NUMBER: _ClassVar[int]
    TARGET_CLOUD_FIELD_NUMBER: _ClassVar[int]
    KEYPOINTS_FIELD_NUMBER: _ClassVar[int]
    SMOOTHNESS_FIELD_NUMBER: _ClassVar[int]
    STRAIN_FIELD_NUMBER: _ClassVar[int]
    FORCE_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    WITHIN_FIELD_NUMBER: _ClassVar[int]
    CLEARANCE_FIELD_NUMBER: _ClassVar[int]
    CONTROL_PATH_FIELD_NUMBER: _ClassVar[int]
    CONTROL_SPEED_FIELD_NUMBER: _ClassVar[int]
    TEMPERATURE_FIELD_NUMBER: _ClassVar[int]
    name: str
    weight: float
    when: Cost.When
    target_cloud: Cost.TargetCloud
    keypoints: Cost.Keypoints
    smoothness: Cost.Smoothness
    strain: Cost.Strain
    force: Cost.Force
    height: Cost.Height
    within: Cost.Within
    clearance: Cost.Clearance
    control_path: Cost.ControlPath
    control_speed: Cost.ControlSpeed
    temperature: float
    def __init__(self, name: _Optional[str] = ..., weight: _Optional[float] = ..., when: _Optional[_Union[Cost.When, str]] = ..., target_cloud: _Optional[_Union[Cost.TargetCloud, _Mapping]] = ..., keypoints: _Optional[_Union[Cost.Keypoints, _Mapping]] = ..., smoothness: _Optional[_Union[Cost.Smoothness, _Mapping]] = ..., strain: _Optional[_Union[Cost.Strain, _Mapping]] = ..., force: _Optional[_Union[Cost.Force, _Mapping]] = ..., height: _Optional[_Union[Cost.Height, _Mapping]] = ..., within: _Optional[_Union[Cost.Within, _Mapping]] = ..., clearance: _Optional[_Union[Cost.Clearance, _Mapping]] = ..., control_path: _Optional[_Union[Cost.ControlPath, _Mapping]] = ..., control_speed: _Optional[_Union[Cost.ControlSpeed, _Mapping]] = ..., temperature: _Optional[float] = ...) -> None: ...

class Returns(_message.Message):
    __slots__ = ("every_frames", "nodes", "encoding", "best", "final_state", "diagnostics", "control_gradients", "action_gradients", "initial_gradients", "gradient_norms", "velocities", "forces", "frame_costs", "controls", "part_frames", "point_set", "skin_points", "spread")
    class Encoding(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        ENCODING_UNSPECIFIED: _ClassVar[Returns.Encoding]
        FLOAT32: _ClassVar[Returns.Encoding]
        INT16: _ClassVar[Returns.Encoding]
    ENCODING_UNSPECIFIED: Returns.Encoding
    FLOAT32: Returns.Encoding
    INT16: Returns.Encoding
    EVERY_FRAMES_FIELD_NUMBER: _ClassVar[int]
    NODES_FIELD_NUMBER: _ClassVar[int]
    ENCODING_FIELD_NUMBER: _ClassVar[int]
    BEST_FIELD_NUMBER: _ClassVar[int]
    FINAL_STATE_FIELD_NUMBER: _ClassVar[int]
    DIAGNOSTICS_FIELD_NUMBER: _ClassVar[int]
    CONTROL_GRADIENTS_FIELD_NUMBER: _ClassVar[int]
    ACTION_GRADIENTS_FIELD_NUMBER: _ClassVar[int]
    INITIAL_GRADIENTS_FIELD_NUMBER: _ClassVar[int]
    GRADIENT_NORMS_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    FORCES_FIELD_NUMBER: _ClassVar[int]
    FRAME_COSTS_FIELD_NUMBER: _ClassVar[int]
    CONTROLS_FIELD_NUMBER: _ClassVar[int]
    PART_FRAMES_FIELD_NUMBER: _ClassVar[int]
    POINT_SET_FIELD_NUMBER: _ClassVar[int]
    SKIN_POINTS_FIELD_NUMBER: _ClassVar[int]
    SPREAD_FIELD_NUMBER: _ClassVar[int]
    every_frames: int
    nodes: _tensor_pb2.Tensor
    encoding: Returns.Encoding
    best: int
    final_state: bool
    diagnostics: bool
    control_gradients: bool
    action_gradients: bool
    initial_gradients: bool
    gradient_norms: bool
    velocities: bool
    forces: bool
    frame_costs: bool
    controls: bool
    part_frames: int
    point_set: PointSet
    skin_points: _tensor_pb2.Tensor
    spread: bool
    def __init__(self, every_frames: _Optional[int] = ..., nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., encoding: _Optional[_Union[Returns.Encoding, str]] = ..., best: _Optional[int] = ..., final_state: bool = ..., diagnostics: bool = ..., control_gradients: bool = ..., action_gradients: bool = ..., initial_gradients: bool = ..., gradient_norms: bool = ..., velocities: bool = ..., forces: bool = ..., frame_costs: bool = ..., controls: bool = ..., part_frames: _Optional[int] = ..., point_set: _Optional[_Union[PointSet, str]] = ..., skin_points: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., spread: bool = ...) -> None: ...

class RollOutResponse(_message.Message):
    __slots__ = ("first_instance", "costs", "cost_names", "cost_terms", "instances", "frames", "positions", "final_positions", "final_velocities", "control_gradients", "diagnostics", "diverged", "timing", "worker", "fidelity", "substeps", "deviation", "final_twists", "final_controls", "final_grasping", "final_commanded_controls", "action_gradients", "initial_position_gradients", "initial_velocity_gradients", "gradient_norms", "gradient_exploded", "velocities", "forces", "frame_costs", "controls", "member_costs", "implausible", "mass_kg", "window", "unfinished", "spread")
    class Window(_message.Message):
        __slots__ = ("first_frame", "last_frame")
        FIRST_FRAME_FIELD_NUMBER: _ClassVar[int]
        LAST_FRAME_FIELD_NUMBER: _ClassVar[int]
        first_frame: int
        last_frame: int
        def __init__(self, first_frame: _Optional[int] = ..., last_frame: _Optional[int] = ...) -> None: ...
    class Forces(_message.Message):
        __slots__ = ("controls", "grasps", "ground", "colliders")
        CONTROLS_FIELD_NUMBER: _ClassVar[int]
        GRASPS_FIELD_NUMBER: _ClassVar[int]
        GROUND_FIELD_NUMBER: _ClassVar[int]
        COLLIDERS_FIELD_NUMBER: _ClassVar[int]
        controls: _tensor_pb2.Tensor
        grasps: _tensor_pb2.Tensor
        ground: _tensor_pb2.Tensor
        colliders: _tensor_pb2.Tensor
        def __init__(self, controls: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., grasps: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., ground: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., colliders: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
    class Implausible(_message.Message):
        __slots__ = ("instance", "reason", "found", "limit", "frame")
        INSTANCE_FIELD_NUMBER: _ClassVar[int]
        REASON_FIELD_NUMBER: _ClassVar[int]
        FOUND_FIELD_NUMBER: _ClassVar[int]
        LIMIT_FIELD_NUMBER: _ClassVar[int]
        FRAME_FIELD_NUMBER: _ClassVar[int]
        instance: int
        reason: str
        found: float
        limit: float
        frame: int
        def __init__(self, instance: _Optional[int] = ..., reason: _Optional[str] = ..., found: _Optional[float] = ..., limit: _Optional[float] = ..., frame: _Optional[int] = ...) -> None: ...
    class Diagnostics(_message.Message):
        __slots__ = ("max_strain", "max_speed_m_s", "kinetic_energy", "elastic_energy", "ground_contacts", "max_control_strain", "control_depth_m", "stopped_hand_m")
        MAX_STRAIN_FIELD_NUMBER: _ClassVar[int]
        MAX_SPEED_M_S_FIELD_NUMBER: _ClassVar[int]
        KINETIC_ENERGY_FIELD_NUMBER: _ClassVar[int]
        ELASTIC_ENERGY_FIELD_NUMBER: _ClassVar[int]
        GROUND_CONTACTS_FIELD_NUMBER: _ClassVar[int]
        MAX_CONTROL_STRAIN_FIELD_NUMBER: _ClassVar[int]
        CONTROL_DEPTH_M_FIELD_NUMBER: _ClassVar[int]
        STOPPED_HAND_M_FIELD_NUMBER: _ClassVar[int]
        max_strain: float
        max_speed_m_s: float
        kinetic_energy: float
        elastic_energy: float
        ground_contacts: int
        max_control_strain: float
        control_depth_m: float
        stopped_hand_m: float
        def __init__(self, max_strain: _Optional[float] = ..., max_speed_m_s: _Optional[float] = ..., kinetic_energy: _Optional[float] = ..., elastic_energy: _Optional[float] = ..., ground_contacts: _Optional[int] = ..., max_control_strain: _Optional[float] = ..., control_depth_m: _Optional[float] = ..., stopped_hand_m: _Optional[float] = ...) -> None: ...
    class Divergence(_message.Message):
        __slots__ = ("instance", "frame", "node")
        INSTANCE_FIELD_NUMBER: _ClassVar[int]
        FRAME_FIELD_NUMBER: _ClassVar[int]
        NODE_FIELD_NUMBER: _ClassVar[int]
        instance: int
        frame: int
        node: int
        def __init__(self, instance: _Optional[int] = ..., frame: _Optional[int] = ..., node: _Optional[int] = ...) -> None: ...
    class Timing(_message.Message):
        __slots__ = ("queue_s", "compute_s")
        QUEUE_S_FIELD_NUMBER: _ClassVar[int]
        COMPUTE_S_FIELD_NUMBER: _ClassVar[int]
        queue_s: float
        compute_s: float
        def __init__(self, queue_s: _Optional[float] = ..., compute_s: _Optional[float] = ...) -> None: ...
    class Deviation(_message.Message):
        __slots__ = ("mean_m", "max_m", "mean_travel_m", "frames")
        MEAN_M_FIELD_NUMBER: _ClassVar[int]
        MAX_M_FIELD_NUMBER: _ClassVar[int]
        MEAN_TRAVEL_M_FIELD_NUMBER: _ClassVar[int]
        FRAMES_FIELD_NUMBER: _ClassVar[int]
        mean_m: float
        max_m: float
        mean_travel_m: float
        frames: int
        def __init__(self, mean_m: _Optional[float] = ..., max_m: _Optional[float] = ..., mean_travel_m: _Optional[float] = ..., frames: _Optional[int] = ...) -> None: ...
    FIRST_INSTANCE_FIELD_NUMBER: _ClassVar[int]
    COSTS_FIELD_NUMBER: _ClassVar[int]
    COST_NAMES_FIELD_NUMBER: _ClassVar[int]
    COST_TERMS_FIELD_NUMBER: _ClassVar[int]
    INSTANCES_FIELD_NUMBER: _ClassVar[int]
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    FINAL_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    FINAL_VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    CONTROL_GRADIENTS_FIELD_NUMBER: _ClassVar[int]
    DIAGNOSTICS_FIELD_NUMBER: _ClassVar[int]
    DIVERGED_FIELD_NUMBER: _ClassVar[int]
    TIMING_FIELD_NUMBER: _ClassVar[int]
    WORKER_FIELD_NUMBER: _ClassVar[int]
    FIDELITY_FIELD_NUMBER: _ClassVar[int]
    SUBSTEPS_FIELD_NUMBER: _ClassVar[int]
    DEVIATION_FIELD_NUMBER: _ClassVar[int]
    FINAL_TWISTS_FIELD_NUMBER: _ClassVar[int]
    FINAL_CONTROLS_FIELD_NUMBER: _ClassVar[int]
    FINAL_GRASPING_FIELD_NUMBER: _ClassVar[int]
    FINAL_COMMANDED_CONTROLS_FIELD_NUMBER: _ClassVar[int]
    ACTION_GRADIENTS_FIELD_NUMBER: _ClassVar[int]
    INITIAL_POSITION_GRADIENTS_FIELD_NUMBER: _ClassVar[int]
    INITIAL_VELOCITY_GRADIENTS_FIELD_NUMBER: _ClassVar[int]
    GRADIENT_NORMS_FIELD_NUMBER: _ClassVar[int]
    GRADIENT_EXPLODED_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    FORCES_FIELD_NUMBER: _ClassVar[int]
    FRAME_COSTS_FIELD_NUMBER: _ClassVar[int]
    CONTROLS_FIELD_NUMBER: _ClassVar[int]
    MEMBER_COSTS_FIELD_NUMBER: _ClassVar[int]
    IMPLAUSIBLE_FIELD_NUMBER: _ClassVar[int]
    MASS_KG_FIELD_NUMBER: _ClassVar[int]
    WINDOW_FIELD_NUMBER: _ClassVar[int]
    UNFINISHED_FIELD_NUMBER: _ClassVar[int]
    SPREAD_FIELD_NUMBER: _ClassVar[int]
    first_instance: int
    costs: _tensor_pb2.Tensor
    cost_names: _containers.RepeatedScalarFieldContainer[str]
    cost_terms: _tensor_pb2.Tensor
    instances: _tensor_pb2.Tensor
    frames: _tensor_pb2.Tensor
    positions: _tensor_pb2.Tensor
    final_positions: _tensor_pb2.Tensor
    final_velocities: _tensor_pb2.Tensor
    control_gradients: _tensor_pb2.Tensor
    diagnostics: _containers.RepeatedCompositeFieldContainer[RollOutResponse.Diagnostics]
    diverged: _containers.RepeatedCompositeFieldContainer[RollOutResponse.Divergence]
    timing: RollOutResponse.Timing
    worker: str
    fidelity: Fidelity
    substeps: int
    deviation: RollOutResponse.Deviation
    final_twists: _tensor_pb2.Tensor
    final_controls: _tensor_pb2.Tensor
    final_grasping: _world_pb2.Grasping
    final_commanded_controls: _tensor_pb2.Tensor
    action_gradients: _tensor_pb2.Tensor
    initial_position_gradients: _tensor_pb2.Tensor
    initial_velocity_gradients: _tensor_pb2.Tensor
    gradient_norms: _tensor_pb2.Tensor
    gradient_exploded: _tensor_pb2.Tensor
    velocities: _tensor_pb2.Tensor
    forces: RollOutResponse.Forces
    frame_costs: _tensor_pb2.Tensor
    controls: _tensor_pb2.Tensor
    member_costs: _tensor_pb2.Tensor
    implausible: _containers.RepeatedCompositeFieldContainer[RollOutResponse.Implausible]
    mass_kg: float
    window: RollOutResponse.Window
    unfinished: _tensor_pb2.Tensor
    spread: _tensor_pb2.Tensor
    def __init__(self, first_instance: _Optional[int] = ..., costs: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., cost_names: _Optional[_Iterable[str]] = ..., cost_terms: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., instances: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., frames: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., final_positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., final_velocities: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., control_gradients: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., diagnostics: _Optional[_Iterable[_Union[RollOutResponse.Diagnostics, _Mapping]]] = ..., diverged: _Optional[_Iterable[_Union[RollOutResponse.Divergence, _Mapping]]] = ..., timing: _Optional[_Union[RollOutResponse.Timing, _Mapping]] = ..., worker: _Optional[str] = ..., fidelity: _Optional[_Union[Fidelity, str]] = ..., substeps: _Optional[int] = ..., deviation: _Optional[_Union[RollOutResponse.Deviation, _Mapping]] = ..., final_twists: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., final_controls: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., final_grasping: _Optional[_Union[_world_pb2.Grasping, _Mapping]] = ..., final_commanded_controls: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., action_gradients: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., initial_position_gradients: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., initial_velocity_gradients: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., gradient_norms: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., gradient_exploded: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., velocities: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., forces: _Optional[_Union[RollOutResponse.Forces, _Mapping]] = ..., frame_costs: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., controls: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., member_costs: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., implausible: _Optional[_Iterable[_Union[RollOutResponse.Implausible, _Mapping]]] = ..., mass_kg: _Optional[float] = ..., window: _Optional[_Union[RollOutResponse.Window, _Mapping]] = ..., unfinished: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., spread: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
