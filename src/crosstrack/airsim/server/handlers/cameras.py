"""Calls about cameras: where they are, what they see, and their lenses."""

from crosstrack.airsim.scene.cameras.camera import Camera
from crosstrack.airsim.scene.cameras.settings import IMAGE_TYPES
from crosstrack.airsim.scene.poses import usable
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers.aboard import equipment
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.server.vehicle import ServedVehicle
from crosstrack.airsim.structs import CameraInfo, Pose


def find(simulator: Simulator, name: str, vehicle_name: str, external: bool) -> tuple[Camera, ServedVehicle | None]:
    """Return a camera and the vehicle that carries it, None for one that stands in the world.

    Raises:
        Refused: there is none of that name.
    """
    vehicle = None if external else simulator.pawn(vehicle_name)
    cameras = equipment(simulator).external if vehicle is None else equipment(simulator).aboard(vehicle).cameras
    camera = cameras.find(name)
    if camera is None:
        raise Refused("map::at")
    return camera, vehicle


def placed(camera: Camera, vehicle: ServedVehicle | None) -> tuple[Pose, Pose]:
    """Return where a camera is: world NED, and relative to the start of its vehicle, as clients are told."""
    if vehicle is None:
        pose = camera.placed(Pose())
        return pose, pose
    pose = camera.placed(vehicle.pose())
    return pose, Pose(pose.position - vehicle.start.position, pose.orientation)


def info(simulator: Simulator, name: str, vehicle_name: str, external: bool) -> CameraInfo:
    """Return where a camera is, its field of view, and its projection."""
    camera, vehicle = find(simulator, name, vehicle_name, external)
    return CameraInfo(placed(camera, vehicle)[1], camera.lens.fov, camera.projection())


def set_pose(simulator: Simulator, name: str, pose: Pose, vehicle_name: str, external: bool) -> None:
    """Mount a camera elsewhere on its vehicle, or in the world."""
    camera, _ = find(simulator, name, vehicle_name, external)
    if not usable(pose):
        raise Refused("the pose of the camera is not finite, or turns by nothing")
    camera.pose = pose


def set_fov(simulator: Simulator, name: str, degrees: float, vehicle_name: str, external: bool) -> None:
    """Set the field of view of pictures of all types."""
    camera, _ = find(simulator, name, vehicle_name, external)
    if not 0.0 < degrees < 180.0:
        raise Refused(f"a field of view of {degrees} degrees; it must be above 0 and below 180")
    camera.lens.fov = degrees
    camera.fovs = dict.fromkeys(range(IMAGE_TYPES), degrees)


def distortion(simulator: Simulator, name: str, vehicle_name: str, external: bool) -> list[float]:
    """Return K1, K2, K3, P1 and P2."""
    return list(find(simulator, name, vehicle_name, external)[0].distortion.values())


def set_distortion(
    simulator: Simulator, name: str, parameter: str, value: float, vehicle_name: str, external: bool
) -> None:
    """Set a parameter of distortion, which is told, but bends no picture; names other than its five do nothing."""
    camera, _ = find(simulator, name, vehicle_name, external)
    if parameter in camera.distortion:
        camera.distortion[parameter] = value


HANDLERS = {
    "simGetCameraInfo": info,
    "simSetCameraPose": set_pose,
    "simSetCameraFov": set_fov,
    "simGetDistortionParams": distortion,
    "simSetDistortionParam": set_distortion,
}
