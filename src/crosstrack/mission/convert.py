"""Missions written in north-east-down, turned into the library's east-north-up.

Converted are the start (position, yaw), the route's points, the wind, and the world's bounds, ground, shapes (those
that move or are not mapped too). An image, a cloud and a generator place themselves in east-north-up, a `.plan` file in
degrees, in any frame.
"""

from dataclasses import replace

from crosstrack.frames import yaw_from_heading
from crosstrack.mission.schema import MissionFile, Point, Points
from crosstrack.types import Vector
from crosstrack.world.build import ShapeSpec


def in_enu(mission: MissionFile) -> MissionFile:
    """Return a mission with `frame: enu` that flies the same."""
    if mission.frame == "enu":
        return mission
    world = mission.world
    return replace(
        mission,
        frame="enu",
        start=replace(
            mission.start,
            position=vector(mission.start.position),
            yaw=float(yaw_from_heading(mission.start.yaw)),
        ),
        route=turned(mission.route),
        goal=None if mission.goal is None else point(mission.goal),
        wind=replace(mission.wind, mean=vector(mission.wind.mean)),
        world=replace(
            world,
            bounds=None if world.bounds is None else corners(*world.bounds),
            ground=0.0 - world.ground,
            shapes=tuple(shape(s) for s in world.shapes),
            unmapped=tuple(shape(s) for s in world.unmapped),
            moving=tuple(replace(m, shape=shape(m.shape), velocity=vector(m.velocity)) for m in world.moving),
        ),
    )


def turned(route: str | Points | None) -> str | Points | None:
    """Convert the points of a route; the name of a file stays."""
    return route if route is None or isinstance(route, str) else tuple(point(p) for p in route)


def vector(v: Vector) -> Vector:
    """Swap the first two components and turn the third over: its own inverse."""
    return (v[1], v[0], 0.0 - v[2])


def point(p: Point) -> Point:
    """Convert a point of two or three coordinates."""
    return (p[1], p[0]) if len(p) == 2 else (p[1], p[0], 0.0 - p[2])


def interval(z: tuple[float, float]) -> tuple[float, float]:
    """Convert (lowest, highest) along the vertical axis."""
    return (0.0 - z[1], 0.0 - z[0])


def corners(low: Vector, high: Vector) -> tuple[Vector, Vector]:
    """Convert the two corners of a box."""
    return (low[1], low[0], 0.0 - high[2]), (high[1], high[0], 0.0 - low[2])


def shape(spec: ShapeSpec) -> ShapeSpec:
    """Convert an obstacle."""
    if spec.box is not None:
        low, high = corners(spec.box.min, spec.box.max)
        return replace(spec, box=replace(spec.box, min=low, max=high))
    if spec.sphere is not None:
        return replace(spec, sphere=replace(spec.sphere, center=vector(spec.sphere.center)))
    if spec.cylinder is not None:
        (north, east), z = spec.cylinder.center, interval(spec.cylinder.z)
        return replace(spec, cylinder=replace(spec.cylinder, center=(east, north), z=z))
    if spec.prism is not None:
        polygon = tuple((east, north) for north, east in spec.prism.polygon)
        return replace(spec, prism=replace(spec.prism, polygon=polygon, z=interval(spec.prism.z)))
    return spec
