"""Compiling ahead, so that the first picture does not keep a flight waiting."""

import numpy as np

from crosstrack.airsim.scene.images import INFRARED, Shot
from crosstrack.airsim.scene.scene import Scene
from crosstrack.airsim.structs import Pose


def warm(scene: Scene) -> None:
    """Look at a scene once in every way: some 20 s the first time ever, half a second from then on."""
    aside = np.array([0.0, 0.0, -1e3])
    shot = Shot(scene.eye_among([("another", aside)]), Pose(aside), 8, 8, 90.0)
    for image_type in range(INFRARED + 1):
        shot.coloured(image_type)
    scene.world.distance(aside)
    scene.world.gradient(aside)
    scene.world.swept(aside, 2 * aside)
