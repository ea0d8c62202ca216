import datetime

from bendtwin.v1 import options_pb2 as _options_pb2
from bendtwin.v1 import tensor_pb2 as _tensor_pb2
from bendtwin.v1 import world_pb2 as _world_pb2
from google.protobuf import field_mask_pb2 as _field_mask_pb2
from google.protobuf import timestamp_pb2 as _timestamp_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Twin(_message.Message):
    __slots__ = ("name", "display_name", "capture", "fit", "create_time", "size_bytes", "digest", "node_count", "spring_count", "triplet_count", "control_count", "fps", "substeps", "quality_json", "mass_kg", "note", "tags", "error_m", "owner")
    NAME_FIELD_NUMBER: _ClassVar[int]
    DISPLAY_NAME_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    FIT_FIELD_NUMBER: _ClassVar[int]
    CREATE_TIME_FIELD_NUMBER: _ClassVar[int]
    SIZE_BYTES_FIELD_NUMBER: _ClassVar[int]
    DIGEST_FIELD_NUMBER: _ClassVar[int]
    NODE_COUNT_FIELD_NUMBER: _ClassVar[int]
    SPRING_COUNT_FIELD_NUMBER: _ClassVar[int]
    TRIPLET_COUNT_FIELD_NUMBER: _ClassVar[int]
    CONTROL_COUNT_FIELD_NUMBER: _ClassVar[int]
    FPS_FIELD_NUMBER: _ClassVar[int]
    SUBSTEPS_FIELD_NUMBER: _ClassVar[int]
    QUALITY_JSON_FIELD_NUMBER: _ClassVar[int]
    MASS_KG_FIELD_NUMBER: _ClassVar[int]
    NOTE_FIELD_NUMBER: _ClassVar[int]
    TAGS_FIELD_NUMBER: _ClassVar[int]
    ERROR_M_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    name: str
    display_name: str
    capture: str
    fit: str
    create_time: _timestamp_pb2.Timestamp
    size_bytes: int
    digest: str
    node_count: int
    spring_count: int
    triplet_count: int
    control_count: int
    fps: float
    substeps: int
    quality_json: str
    mass_kg: float
    note: str
    tags: _containers.RepeatedScalarFieldContainer[str]
    error_m: float
    owner: str
    def __init__(self, name: _Optional[str] = ..., display_name: _Optional[str] = ..., capture: _Optional[str] = ..., fit: _Optional[str] = ..., create_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., size_bytes: _Optional[int] = ..., digest: _Optional[str] = ..., node_count: _Optional[int] = ..., spring_count: _Optional[int] = ..., triplet_count: _Optional[int] = ..., control_count: _Optional[int] = ..., fps: _Optional[float] = ..., substeps: _Optional[int] = ..., quality_json: _Optional[str] = ..., mass_kg: _Optional[float] = ..., note: _Optional[str] = ..., tags: _Optional[_Iterable[str]] = ..., error_m: _Optional[float] = ..., owner: _Optional[str] = ...) -> None: ...

class GetTwinGeometryRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class TwinGeometry(_message.Message):
    __slots__ = ("rest_positions", "kinds", "edges", "rest_lengths", "triplets", "masses", "controls", "hands", "pins", "surface_count", "rod_count", "fps", "substeps", "gravity", "ground", "ground_friction", "ground_restitution", "mass_kg", "spacing_m", "rod_starts", "rod_nodes", "skin", "fits", "spring_stiffness", "bend_stiffness", "node_regions", "skin_sd")
    class Skin(_message.Message):
        __slots__ = ("rest_positions", "observed_points", "weight_counts", "weight_nodes", "weights", "frames", "offsets")
        REST_POSITIONS_FIELD_NUMBER: _ClassVar[int]
        OBSERVED_POINTS_FIELD_NUMBER: _ClassVar[int]
        WEIGHT_COUNTS_FIELD_NUMBER: _ClassVar[int]
        WEIGHT_NODES_FIELD_NUMBER: _ClassVar[int]
        WEIGHTS_FIELD_NUMBER: _ClassVar[int]
        FRAMES_FIELD_NUMBER: _ClassVar[int]
        OFFSETS_FIELD_NUMBER: _ClassVar[int]
        rest_positions: _tensor_pb2.Tensor
        observed_points: _tensor_pb2.Tensor
        weight_counts: _tensor_pb2.Tensor
        weight_nodes: _tensor_pb2.Tensor
        weights: _tensor_pb2.Tensor
        frames: _tensor_pb2.Tensor
        offsets: _tensor_pb2.Tensor
        def __init__(self, rest_positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., observed_points: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., weight_counts: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., weight_nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., weights: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., frames: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., offsets: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
    REST_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    KINDS_FIELD_NUMBER: _ClassVar[int]
    EDGES_FIELD_NUMBER: _ClassVar[int]
    REST_LENGTHS_FIELD_NUMBER: _ClassVar[int]
    TRIPLETS_FIELD_NUMBER: _ClassVar[int]
    MASSES_FIELD_NUMBER: _ClassVar[int]
    CONTROLS_FIELD_NUMBER: _ClassVar[int]
    HANDS_FIELD_NUMBER: _ClassVar[int]
    PINS_FIELD_NUMBER: _ClassVar[int]
    SURFACE_COUNT_FIELD_NUMBER: _ClassVar[int]
    ROD_COUNT_FIELD_NUMBER: _ClassVar[int]
    FPS_FIELD_NUMBER: _ClassVar[int]
    SUBSTEPS_FIELD_NUMBER: _ClassVar[int]
    GRAVITY_FIELD_NUMBER: _ClassVar[int]
    GROUND_FIELD_NUMBER: _ClassVar[int]
    GROUND_FRICTION_FIELD_NUMBER: _ClassVar[int]
    GROUND_RESTITUTION_FIELD_NUMBER: _ClassVar[int]
    MASS_KG_FIELD_NUMBER: _ClassVar[int]
    SPACING_M_FIELD_NUMBER: _ClassVar[int]
    ROD_STARTS_FIELD_NUMBER: _ClassVar[int]
    ROD_NODES_FIELD_NUMBER: _ClassVar[int]
    SKIN_FIELD_NUMBER: _ClassVar[int]
    FITS_FIELD_NUMBER: _ClassVar[int]
    SPRING_STIFFNESS_FIELD_NUMBER: _ClassVar[int]
    BEND_STIFFNESS_FIELD_NUMBER: _ClassVar[int]
    NODE_REGIONS_FIELD_NUMBER: _ClassVar[int]
    SKIN_SD_FIELD_NUMBER: _ClassVar[int]
    rest_positions: _tensor_pb2.Tensor
    kinds: _tensor_pb2.Tensor
    edges: _tensor_pb2.Tensor
    rest_lengths: _tensor_pb2.Tensor
    triplets: _tensor_pb2.Tensor
    masses: _tensor_pb2.Tensor
    controls: _tensor_pb2.Tensor
    hands: _tensor_pb2.Tensor
    pins: _tensor_pb2.Tensor
    surface_count: int
    rod_count: int
    fps: float
    substeps: int
    gravity: _containers.RepeatedScalarFieldContainer[float]
    ground: _world_pb2.Plane
    ground_friction: float
    ground_restitution: float
    mass_kg: float
    spacing_m: float
    rod_starts: _tensor_pb2.Tensor
    rod_nodes: _tensor_pb2.Tensor
    skin: TwinGeometry.Skin
    fits: int
    spring_stiffness: _tensor_pb2.Tensor
    bend_stiffness: _tensor_pb2.Tensor
    node_regions: _tensor_pb2.Tensor
    skin_sd: _tensor_pb2.Tensor
    def __init__(self, rest_positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., kinds: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., edges: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., rest_lengths: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., triplets: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., masses: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., controls: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., hands: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., pins: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., surface_count: _Optional[int] = ..., rod_count: _Optional[int] = ..., fps: _Optional[float] = ..., substeps: _Optional[int] = ..., gravity: _Optional[_Iterable[float]] = ..., ground: _Optional[_Union[_world_pb2.Plane, _Mapping]] = ..., ground_friction: _Optional[float] = ..., ground_restitution: _Optional[float] = ..., mass_kg: _Optional[float] = ..., spacing_m: _Optional[float] = ..., rod_starts: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., rod_nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., skin: _Optional[_Union[TwinGeometry.Skin, _Mapping]] = ..., fits: _Optional[int] = ..., spring_stiffness: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., bend_stiffness: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., node_regions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., skin_sd: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...

class GetTwinSurfaceRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class TwinSurface(_message.Message):
    __slots__ = ("carriers", "triangles", "colors", "tube_starts", "tube_nodes", "tube_radii", "node_count")
    CARRIERS_FIELD_NUMBER: _ClassVar[int]
    TRIANGLES_FIELD_NUMBER: _ClassVar[int]
    COLORS_FIELD_NUMBER: _ClassVar[int]
    TUBE_STARTS_FIELD_NUMBER: _ClassVar[int]
    TUBE_NODES_FIELD_NUMBER: _ClassVar[int]
    TUBE_RADII_FIELD_NUMBER: _ClassVar[int]
    NODE_COUNT_FIELD_NUMBER: _ClassVar[int]
    carriers: TwinGeometry.Skin
    triangles: _tensor_pb2.Tensor
    colors: _tensor_pb2.Tensor
    tube_starts: _tensor_pb2.Tensor
    tube_nodes: _tensor_pb2.Tensor
    tube_radii: _tensor_pb2.Tensor
    node_count: int
    def __init__(self, carriers: _Optional[_Union[TwinGeometry.Skin, _Mapping]] = ..., triangles: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., colors: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., tube_starts: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., tube_nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., tube_radii: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., node_count: _Optional[int] = ...) -> None: ...

class CreateTwinRequest(_message.Message):
    __slots__ = ("metadata", "chunk")
    METADATA_FIELD_NUMBER: _ClassVar[int]
    CHUNK_FIELD_NUMBER: _ClassVar[int]
    metadata: TwinMetadata
    chunk: bytes
    def __init__(self, metadata: _Optional[_Union[TwinMetadata, _Mapping]] = ..., chunk: _Optional[bytes] = ...) -> None: ...

class TwinMetadata(_message.Message):
    __slots__ = ("display_name", "request_id", "digest")
    DISPLAY_NAME_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    DIGEST_FIELD_NUMBER: _ClassVar[int]
    display_name: str
    request_id: str
    digest: str
    def __init__(self, display_name: _Optional[str] = ..., request_id: _Optional[str] = ..., digest: _Optional[str] = ...) -> None: ...

class GetTwinRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class ListTwinsRequest(_message.Message):
    __slots__ = ("page_size", "page_token", "capture", "search", "tag", "order_by", "owner", "level")
    PAGE_SIZE_FIELD_NUMBER: _ClassVar[int]
    PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    SEARCH_FIELD_NUMBER: _ClassVar[int]
    TAG_FIELD_NUMBER: _ClassVar[int]
    ORDER_BY_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    LEVEL_FIELD_NUMBER: _ClassVar[int]
    page_size: int
    page_token: str
    capture: str
    search: str
    tag: str
    order_by: str
    owner: str
    level: str
    def __init__(self, page_size: _Optional[int] = ..., page_token: _Optional[str] = ..., capture: _Optional[str] = ..., search: _Optional[str] = ..., tag: _Optional[str] = ..., order_by: _Optional[str] = ..., owner: _Optional[str] = ..., level: _Optional[str] = ...) -> None: ...

class ListTwinsResponse(_message.Message):
    __slots__ = ("twins", "next_page_token", "total_size")
    TWINS_FIELD_NUMBER: _ClassVar[int]
    NEXT_PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    TOTAL_SIZE_FIELD_NUMBER: _ClassVar[int]
    twins: _containers.RepeatedCompositeFieldContainer[Twin]
    next_page_token: str
    total_size: int
    def __init__(self, twins: _Optional[_Iterable[_Union[Twin, _Mapping]]] = ..., next_page_token: _Optional[str] = ..., total_size: _Optional[int] = ...) -> None: ...

class UpdateTwinRequest(_message.Message):
    __slots__ = ("twin", "update_mask", "add_tags", "remove_tags")
    TWIN_FIELD_NUMBER: _ClassVar[int]
    UPDATE_MASK_FIELD_NUMBER: _ClassVar[int]
    ADD_TAGS_FIELD_NUMBER: _ClassVar[int]
    REMOVE_TAGS_FIELD_NUMBER: _ClassVar[int]
    twin: Twin
    update_mask: _field_mask_pb2.FieldMask
    add_tags: _containers.RepeatedScalarFieldContainer[str]
    remove_tags: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, twin: _Optional[_Union[Twin, _Mapping]] = ..., update_mask: _Optional[_Union[_field_mask_pb2.FieldMask, _Mapping]] = ..., add_tags: _Optional[_Iterable[str]] = ..., remove_tags: _Optional[_Iterable[str]] = ...) -> None: ...

class DeleteTwinRequest(_message.Message):
    __slots__ = ("name", "purge")
    NAME_FIELD_NUMBER: _ClassVar[int]
    PURGE_FIELD_NUMBER: _ClassVar[int]
    name: str
    purge: bool
    def __init__(self, name: _Optional[str] = ..., purge: bool = ...) -> None: ...

class DeleteTwinResponse(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ExportTwinRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class ExportTwinResponse(_message.Message):
    __slots__ = ("chunk",)
    CHUNK_FIELD_NUMBER: _ClassVar[int]
    chunk: bytes
    def __init__(self, chunk: _Optional[bytes] = ...) -> None: ...
