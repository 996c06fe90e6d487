"""Calls that take pictures, and that detect things in them."""

import math
from dataclasses import replace

from crosstrack.airsim.scene.cameras.camera import Camera
from crosstrack.airsim.scene.cameras.settings import IMAGE_TYPES
from crosstrack.airsim.scene.detect import RADIUS, detect, wanted
from crosstrack.airsim.scene.earth import geodetic
from crosstrack.airsim.scene.images import Kind, Shot
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers.aboard import eye_of
from crosstrack.airsim.server.handlers.cameras import find, placed
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.server.vehicle import ServedVehicle
from crosstrack.airsim.structs import DetectionInfo, GeoPoint, ImageRequest, ImageResponse

ABSENT = "Can't take screenshot because texture target is null"
"""said of optical flow, which is not offered"""
MOST_PIXELS = 1 << 25
"""of one call for several pictures, as floats 160 MiB on the wire; one alone is as large as its settings say"""
MOST_PATTERNS = 1000
"""of names to detect, of one camera and type of picture"""
Shots = dict[tuple[int, int, int, float], Shot]


def take(
    simulator: Simulator, camera: Camera, vehicle: ServedVehicle | None, request: ImageRequest, shots: Shots
) -> ImageResponse:
    """Return one picture; pictures of a camera that have the same size and field of view share their rays."""
    image_type = checked(request.image_type)
    pose, told = placed(camera, vehicle)
    how, fov = camera.capture(image_type), camera.view(image_type)
    answer = ImageResponse(
        camera_position=told.position,
        camera_name=request.camera_name,
        camera_orientation=told.orientation,
        time_stamp=simulator.now,
        pixels_as_float=request.pixels_as_float,
        compress=request.compress,
        image_type=image_type,
    )
    if image_type > Kind.INFRARED:
        return replace(answer, message=ABSENT)
    key = id(camera), how.width, how.height, fov
    if key not in shots:
        shots[key] = Shot(eye_of(simulator, vehicle), pose, how.width, how.height, fov)
    shot = shots[key]
    if request.pixels_as_float:
        return replace(answer, image_data_float=shot.numbers(image_type), width=how.width, height=how.height)
    data = shot.png(image_type) if request.compress else shot.coloured(image_type).tobytes()
    return replace(answer, image_data_uint8=data, width=how.width, height=how.height)


def pictures(
    simulator: Simulator, requests: list[ImageRequest], vehicle_name: str, external: bool
) -> list[ImageResponse]:
    """Return pictures, all of one instant; one that is asked for several times is taken once.

    Raises:
        Refused: there is no such camera, or no such type, or they are too many.
    """
    answers: list[ImageResponse] = []
    found = [(*find(simulator, one.camera_name, vehicle_name, external), one) for one in requests]
    sizes = (camera.capture(one.image_type) for camera, _, one in found)
    pixels = sum(size.width * size.height for size in sizes)
    if len(requests) > 1 and pixels > MOST_PIXELS:
        raise Refused(f"{pixels} pixels at once; at most {MOST_PIXELS} are taken")
    shots: Shots = {}
    taken: dict[tuple[int, int, bool, bool], ImageResponse] = {}
    for camera, vehicle, one in found:
        key = id(camera), one.image_type, one.pixels_as_float, one.compress
        if key not in taken:
            taken[key] = take(simulator, camera, vehicle, one, shots)
        answers.append(replace(taken[key], camera_name=one.camera_name))
    return answers


def picture(simulator: Simulator, name: str, image_type: int, vehicle_name: str, external: bool) -> bytes:
    """Return a picture as PNG; empty where there is none."""
    request = ImageRequest(name, image_type, pixels_as_float=False, compress=True)
    return pictures(simulator, [request], vehicle_name, external)[0].image_data_uint8


def add_filter(
    simulator: Simulator, name: str, image_type: int, mesh_name: str, vehicle_name: str, external: bool
) -> None:
    """Detect things that go by a name, in which * and ? stand for what they do in file names."""
    camera, _ = find(simulator, name, vehicle_name, external)
    patterns = camera.wanted.setdefault(checked(image_type), [])
    if mesh_name not in patterns:
        if len(patterns) >= MOST_PATTERNS:
            raise Refused(f"{MOST_PATTERNS} names are detected already; no more are taken")
        patterns.append(mesh_name)


def set_radius(
    simulator: Simulator, name: str, image_type: int, radius_cm: float, vehicle_name: str, external: bool
) -> None:
    """Detect things no farther away than a radius (cm)."""
    camera, _ = find(simulator, name, vehicle_name, external)
    if math.isnan(radius_cm):
        raise Refused("the radius is not a number")
    camera.radius[checked(image_type)] = radius_cm / 100


def clear_filter(simulator: Simulator, name: str, image_type: int, vehicle_name: str, external: bool) -> None:
    """Detect nothing any more."""
    camera, _ = find(simulator, name, vehicle_name, external)
    camera.wanted.pop(checked(image_type), None)


def detections(
    simulator: Simulator, name: str, image_type: int, vehicle_name: str, external: bool
) -> list[DetectionInfo]:
    """Return what is detected in a picture."""
    camera, vehicle = find(simulator, name, vehicle_name, external)
    patterns, scene = camera.wanted.get(checked(image_type), []), simulator.scene
    things = [thing for thing in scene.things.values() if wanted(thing, patterns)]
    if not things:
        return []
    how, pose = camera.capture(image_type), placed(camera, vehicle)[0]
    shot = Shot(eye_of(simulator, vehicle), pose, how.width, how.height, camera.view(image_type))
    places = {thing.name: GeoPoint(*geodetic(thing.pose.position, simulator.origin)) for thing in things}
    return detect(shot, things, places, camera.radius.get(image_type, RADIUS))


def checked(image_type: int) -> int:
    """Return a type of picture.

    Raises:
        Refused: there is none of that number.
    """
    if not 0 <= image_type < IMAGE_TYPES:
        raise Refused(f"image type {image_type}; there are 0 to {IMAGE_TYPES - 1}")
    return image_type


HANDLERS = {
    "simGetImages": pictures,
    "simGetImage": picture,
    "simAddDetectionFilterMeshName": add_filter,
    "simSetDetectionFilterRadius": set_radius,
    "simClearDetectionMeshNames": clear_filter,
    "simGetDetections": detections,
}
