"""What all interpreters of this folder hand out: the moves of a program, and why one is not followed."""
from dataclasses import dataclass, field
from typing import Optional, Tuple

Vec = Tuple[float, float, float]


@dataclass
class Move:
    kind: str            # "rapid", "line", "arc", "joint", "spline"
    file: str            # key of `files`
    line: int            # 1-based, of the block that makes the move
    end: Vec             # mm, programmed point in the program's first workpiece frame (robots: position of the pose)
    axis_or_rotation: object = None   # None, or a 3x3 rotation, or a unit tool axis
    centre: Optional[Vec] = None      # arcs: a point on the axis of the arc (helices: at the height of the start)
    turn: Optional[Vec] = None        # arcs: unit axis times the whole angle in rad, signed, with further turns
    feed: Optional[float] = None      # mm/min where known
    known: float = field(default=0.0, kw_only=True)   # mm to which the end is known beyond rounding: radii of an arc that differ, numbers of few digits


class Refused(Exception):
    def __init__(self, file, line, why):
        super().__init__(f"{file}:{line}: {why}")
        self.file, self.line, self.why = file, line, why
