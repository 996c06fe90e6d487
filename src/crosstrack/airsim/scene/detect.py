"""What a camera sees of a thing: the box around it in the picture, if any of it is in view."""

from fnmatch import fnmatchcase
from itertools import product

import numpy as np

from crosstrack import frames
from crosstrack.airsim.scene.images import Shot
from crosstrack.airsim.scene.poses import matrix, seen_from
from crosstrack.airsim.scene.thing import Thing
from crosstrack.airsim.structs import Box2D, Box3D, DetectionInfo, GeoPoint
from crosstrack.types import Array

RADIUS = 200.0
"""m, within which things are detected unless told otherwise"""
IN_FRONT = 0.1
"""m, from the camera, nearer than which a corner has no place in the picture"""


def wanted(thing: Thing, patterns: list[str]) -> bool:
    """Return whether a thing goes by one of some names, in which * and ? stand for what they do in file names."""
    names = {thing.name.lower(), thing.asset.lower()}
    plain = [pattern.lower().replace("[", "[[]") for pattern in patterns]
    return any(fnmatchcase(name, pattern) for name in names for pattern in plain)


def box_in_picture(shot: Shot, thing: Thing) -> Box2D | None:
    """Return the box around the corners (pixels) of the box around a thing; None where none of them is in the picture.

    Corners behind the camera are moved in front of it: they are beyond an edge then.
    """
    corners = frames.ned_from_enu(np.array(list(product(*thing.box.T))))
    ahead, right, down = ((corners - shot.pose.position) @ matrix(shot.pose.orientation)).T
    if (ahead < IN_FRONT).all():
        return None
    size, focal = np.array([shot.width, shot.height]), shot.width / (2 * shot.half)
    pixels = size / 2 + focal * np.stack([right, down], axis=1) / np.maximum(ahead, IN_FRONT)[:, None]
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    if (high <= 0).any() or (low >= size).any():
        return None
    return Box2D(np.clip(low, 0, size), np.clip(high, 0, size))


def detect(shot: Shot, things: list[Thing], geodetic: dict[str, GeoPoint], radius: float) -> list[DetectionInfo]:
    """Return the things that are in view of a picture, within a radius (m) of the camera.

    Args:
        shot: the picture; a thing is in view where one of its pixels shows it
        things: of the scene
        geodetic: where each is on the Earth
        radius: m, of the middles of things
    """
    shown = {shot.eye.things[k].name for k in np.unique(shot.sighting.seen)}
    found = []
    for thing in things:
        if thing.name not in shown or np.linalg.norm(thing.pose.position - shot.pose.position) > radius:
            continue
        box = box_in_picture(shot, thing)
        if box is not None:
            relative = seen_from(shot.pose, thing.pose)
            found.append(DetectionInfo(thing.name, geodetic[thing.name], box, corners(shot, thing.box), relative))
    return found


def corners(shot: Shot, box: Array) -> Box3D:
    """Return the lowest and the highest corner of a box (2, 3) m, ENU, as the camera sees them (FRD)."""
    low, high = (frames.ned_from_enu(box) - shot.pose.position) @ matrix(shot.pose.orientation)
    return Box3D(low, high)
