"""Calls about the things of the scene."""

import math

import numpy as np

from crosstrack import frames
from crosstrack.airsim.scene import voxel_grid
from crosstrack.airsim.scene.assets import ASSETS, LEAST, MOST, OTHER_NAMES
from crosstrack.airsim.scene.earth import geodetic
from crosstrack.airsim.scene.files import inside
from crosstrack.airsim.scene.names import LONGEST, first_number, numbered, pattern
from crosstrack.airsim.scene.poses import usable
from crosstrack.airsim.scene.thing import Thing, named
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers.recording import folders
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import GeoPoint, MeshPositionVertexBuffersResponse, Pose
from crosstrack.types import Array

GIGANTIC = 200.0
"""m, half the side of a thing that counts not for the extents of the world"""
CENTIMETRES = 100.0
"""in a metre: meshes come in Unreal's units and axes, north, east, up"""
NOWHERE = Pose(np.full(3, np.nan), np.full(4, np.nan))


def matching(simulator: Simulator, text: str, ignoring_case: bool) -> list[str]:
    """Return the names of things, vehicles among them, that a regular expression matches as a whole."""
    try:
        wanted = pattern(text, ignoring_case)
    except ValueError as error:
        raise Refused(str(error)) from None
    names = [thing.name for thing in simulator.scene.all()] + list(simulator.vehicles)
    return [name for name in names if wanted.fullmatch(name)]


def listed(simulator: Simulator, text: str) -> list[str]:
    """Return the names of things and vehicles that a regular expression matches as a whole."""
    return matching(simulator, text, ignoring_case=False)


def tagged(simulator: Simulator, text: str) -> list[str]:
    """Return the things that have a tag: none has."""
    listed(simulator, text)
    return []


def assets(simulator: Simulator) -> list[str]:
    """Return what things can be made from."""
    return [*ASSETS, *OTHER_NAMES]


def measured(scale: Array) -> Array:
    """Return a scale.

    Raises:
        Refused: a side would be too short or too long.
    """
    sides = np.abs(scale)
    if not ((sides >= LEAST) & (sides <= MOST)).all():
        raise Refused(f"a scale of {[float(part) for part in scale]}; each part must be {LEAST} to {MOST}")
    return scale


def standing(pose: Pose) -> Pose:
    """Return a pose.

    Raises:
        Refused: it is not finite, is far out, or turns by nothing.
    """
    if not usable(pose) or np.abs(pose.position).max() > MOST:
        raise Refused(f"a pose must be finite, within {MOST} m, and its quaternion not zero")
    return pose


def put(simulator: Simulator, thing: Thing) -> None:
    """Add a thing to the scene, or replace it.

    Raises:
        Refused: the scene is full.
    """
    try:
        simulator.scene.put(thing)
    except ValueError as error:
        raise Refused(str(error)) from None


def spawn(simulator: Simulator, name: str, asset: str, pose: Pose, scale: Array, physics: bool, blueprint: bool) -> str:
    """Add a thing; return its name, with a number where the name is taken. It stays where it is, physics or not."""
    kind = OTHER_NAMES.get(asset, asset)
    if kind not in ASSETS:
        raise Refused(f"There were no objects with name {asset} found in the Registry")
    if not 0 < len(name) <= LONGEST:
        raise Refused(f"a name of {len(name)} characters; it must have 1 to {LONGEST}")
    taken = [thing.name for thing in simulator.scene.all()] + list(simulator.vehicles)
    final = numbered(name, taken)
    put(simulator, named(final, first_number(final), kind, standing(pose), measured(scale)))
    return final


def destroy(simulator: Simulator, name: str) -> bool:
    """Take a thing away; return whether there was one."""
    if name not in simulator.scene.things:
        return False
    simulator.scene.remove(name)
    return True


def find(simulator: Simulator, name: str) -> Thing | None:
    """Return the thing of a name."""
    return next((thing for thing in simulator.scene.all() if thing.name == name), None)


def pose_of(simulator: Simulator, name: str) -> Pose:
    """Return where a thing or a vehicle is, world NED; not a number where there is none."""
    if name in simulator.vehicles:
        return simulator.vehicles[name].pose()
    thing = find(simulator, name)
    return NOWHERE if thing is None else thing.pose


def set_pose(simulator: Simulator, name: str, pose: Pose, teleport: bool) -> bool:
    """Put a thing elsewhere; return whether there is one that can be moved. Without teleport it stops at nothing."""
    thing = simulator.scene.things.get(name)
    if thing is None or not thing.asset:
        return False
    put(simulator, thing.moved(standing(pose)))
    return True


def scale_of(simulator: Simulator, name: str) -> Array:
    """Return the scale of a thing, zero where there is none."""
    thing = find(simulator, name)
    return np.zeros(3) if thing is None else thing.scale


def set_scale(simulator: Simulator, name: str, scale: Array) -> bool:
    """Make a thing larger or smaller; return whether there is one that can be."""
    thing = simulator.scene.things.get(name)
    if thing is None or not thing.asset:
        return False
    put(simulator, thing.scaled(measured(scale)))
    return True


def set_number(simulator: Simulator, name: str, number: int, regex: bool) -> bool:
    """Give things a number in segmentation pictures, -1 for none; return whether there are any."""
    if not -1 <= number <= 255:
        raise Refused(f"object id {number}; it must be -1 to 255")
    names = matching(simulator, name, ignoring_case=True) if regex else [name]
    found = [one for one in names if find(simulator, one) is not None or one in simulator.vehicles]
    simulator.scene.renumber(found, number)
    return bool(found)


def number_of(simulator: Simulator, name: str) -> int:
    """Return the number of a thing in segmentation pictures, -1 where there is none; as in AirSim, case counts not."""
    wanted, scene = name.lower(), simulator.scene
    numbers = [(thing.name, thing.number) for thing in scene.all()]
    numbers += [(one, scene.number_of(one)) for one in simulator.vehicles]
    return next((number for one, number in numbers if one.lower() == wanted), -1)


def extents(simulator: Simulator) -> list[GeoPoint]:
    """Return the lowest and the highest corner of the box around all things that are not gigantic, on the Earth."""
    boxes = [thing.box for thing in simulator.scene.things.values()]
    boxes = [box for box in boxes if box[1, 1] - box[0, 1] <= 2 * GIGANTIC] or [np.zeros((2, 3))]
    low, high = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
    return [GeoPoint(*geodetic(frames.ned_from_enu(corner), simulator.origin)) for corner in (low, high)]


def meshes(simulator: Simulator) -> list[MeshPositionVertexBuffersResponse]:
    """Return the surfaces of all things, in Unreal's centimetres and axes: north, east, up."""
    unreal = np.array([1.0, 1.0, -1.0]) * CENTIMETRES
    found = []
    for thing in simulator.scene.things.values():
        mesh = thing.mesh()
        vertices = frames.ned_from_enu(mesh.vertices) * unreal
        x, y, z, w = thing.pose.orientation
        found.append(
            MeshPositionVertexBuffersResponse(
                thing.pose.position * unreal,
                np.array([-x, -y, z, w]),
                vertices.astype(np.float32).ravel(),
                mesh.triangles.astype(np.uint32).ravel(),
                thing.name.lower(),
            )
        )
    return found


def voxels(simulator: Simulator, centre: Array, x: int, y: int, z: int, cell: float, name: str) -> bool:
    """Write which cells around a point are in the way; return whether that could be written.

    Raises:
        Refused: the file is not a binvox file in the server's working folder or that of its recordings.
    """
    path = inside(name, folders(simulator), ".binvox")
    if path is None:
        raise Refused(f"{name}: only .binvox files in the working folder of the server are written")
    if not np.isfinite(centre).all():
        raise Refused("the middle of the grid is not finite")
    try:
        cells = voxel_grid.occupied(simulator.scene.world, centre, (x, y, z), cell)
    except ValueError as error:
        raise Refused(str(error)) from None
    try:
        path.write_bytes(voxel_grid.binvox(cells, (x, y, z)))
    except OSError:
        return False
    return True


def look_at(simulator: Simulator, vehicle_name: str, name: str) -> Array:
    """Return pitch (up), roll and yaw (degrees) of the look from a vehicle at a thing; zero where there is none."""
    target = pose_of(simulator, name)
    north, east, down = np.nan_to_num(target.position - simulator.pawn(vehicle_name).pose().position)
    pitch = math.degrees(math.atan2(-down, math.hypot(north, east)))
    return np.array([pitch, 0.0, math.degrees(math.atan2(east, north))])


HANDLERS = {
    "simListSceneObjects": listed,
    "simListSceneObjectsByTag": tagged,
    "simListAssets": assets,
    "simSpawnObject": spawn,
    "simDestroyObject": destroy,
    "simGetObjectPose": pose_of,
    "simSetObjectPose": set_pose,
    "simGetObjectScale": scale_of,
    "simSetObjectScale": set_scale,
    "simSetSegmentationObjectID": set_number,
    "simGetSegmentationObjectID": number_of,
    "simGetWorldExtents": extents,
    "simGetMeshPositionVertexBuffers": meshes,
    "simCreateVoxelGrid": voxels,
    "simFindLookAtRotation": look_at,
}
