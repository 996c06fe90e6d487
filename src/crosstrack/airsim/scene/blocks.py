"""A world of our own for when none is given: obstacles of several kinds around a free start."""

import numpy as np

from crosstrack.airsim.scene.names import first_number
from crosstrack.airsim.scene.poses import from_angles
from crosstrack.airsim.scene.thing import Thing, named
from crosstrack.airsim.structs import Pose

ROWS: tuple[tuple[str, str, tuple[float, float, float], tuple[float, float, float], float], ...] = (
    # name, asset, north east and up of the middle (m), sides (m), yaw (degrees)
    ("Wall_North", "Cube", (60, 0, 4), (2, 60, 8), 0),
    ("Wall_East", "Cube", (10, 45, 3), (50, 1, 6), 0),
    ("Tower_1", "Cube", (35, 18, 10), (8, 8, 20), 0),
    ("Tower_2", "Cube", (48, -22, 7.5), (10, 6, 15), 30),
    ("Tower_3", "Cube", (-30, 25, 12), (7, 7, 24), 45),
    ("Tower_4", "Cube", (-42, -18, 6), (12, 9, 12), -20),
    ("Block_1", "Cube", (20, -12, 1.5), (3, 3, 3), 0),
    ("Block_2", "Cube", (20, -12, 4), (2, 2, 2), 25),
    ("Block_3", "Cube", (-12, -10, 1), (4, 2, 2), 60),
    ("Block_4", "Cube", (12, 14, 1), (2, 2, 2), 0),
    ("Gate_Left", "Cube", (28, -4, 2.5), (1, 1, 5), 0),
    ("Gate_Right", "Cube", (28, 4, 2.5), (1, 1, 5), 0),
    ("Gate_Top", "Cube", (28, 0, 5.5), (1, 9, 1), 0),
    ("Column_1", "Cylinder", (15, -25, 6), (2, 2, 12), 0),
    ("Column_2", "Cylinder", (25, -32, 6), (2, 2, 12), 0),
    ("Column_3", "Cylinder", (-18, 12, 5), (1.5, 1.5, 10), 0),
    ("Column_4", "Cylinder", (-25, -32, 8), (3, 3, 16), 0),
    ("Column_5", "Cylinder", (42, 6, 5), (1, 1, 10), 0),
    ("Ball_1", "Sphere", (16, 26, 2), (4, 4, 4), 0),
    ("Ball_2", "Sphere", (-20, -2, 6), (3, 3, 3), 0),
    ("Ball_3", "Sphere", (40, -8, 3), (2, 2, 2), 0),
    ("Cone_1", "Cone", (-8, 20, 2), (4, 4, 4), 0),
    ("Cone_2", "Cone", (10, -38, 4), (6, 6, 8), 0),
    ("Ramp", "Cube", (-35, 3, 1.5), (10, 6, 0.5), 0),
)
RAMP_PITCH = 15.0
"""degrees, up"""


def blocks() -> list[Thing]:
    """Return the things of the world; the start at its origin is free."""
    things = []
    for name, asset, (north, east, up), sides, yaw in ROWS:
        turn = from_angles(yaw, RAMP_PITCH if name == "Ramp" else 0.0, 0.0)
        pose = Pose(np.array([north, east, -up], dtype=float), turn)
        things.append(named(name, first_number(name), asset, pose, np.array(sides, dtype=float)))
    return things
