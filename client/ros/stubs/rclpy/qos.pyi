from enum import Enum

class ReliabilityPolicy(Enum):
    RELIABLE = 1
    BEST_EFFORT = 2

class DurabilityPolicy(Enum):
    TRANSIENT_LOCAL = 1
    VOLATILE = 2

class QoSProfile:
    def __init__(
        self,
        *,
        depth: int,
        reliability: ReliabilityPolicy = ...,
        durability: DurabilityPolicy = ...,
    ) -> None: ...

qos_profile_sensor_data: QoSProfile
