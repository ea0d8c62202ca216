"""Tasks on any soft object, with rewards, predicates of success and scripts."""

from bendtwin.envs.tasks.fold import Fold
from bendtwin.envs.tasks.insert_end import InsertEnd
from bendtwin.envs.tasks.lay_along import LayAlong
from bendtwin.envs.tasks.move_tip import MoveTip
from bendtwin.envs.tasks.put_in_bin import PutInBin
from bendtwin.envs.tasks.task import Draw, Judgement, Task, Unsuitable, View, Waypoint

__all__ = [
    "Draw",
    "Fold",
    "InsertEnd",
    "Judgement",
    "LayAlong",
    "MoveTip",
    "PutInBin",
    "Task",
    "Unsuitable",
    "View",
    "Waypoint",
]
