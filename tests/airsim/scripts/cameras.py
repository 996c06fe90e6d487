"""Move cameras, turn them, and zoom."""

import math

import airsim
import numpy as np
from shared import at, climb, connect, refused, vector

client = connect()
climb(client, 6)
place, info = at(client), client.simGetCameraInfo("0")
assert abs(info.fov - 90) < 0.2, "that of the lens of Unreal's camera"
assert np.linalg.norm(vector(info.pose.position) - place) < 0.7
assert len(info.proj_mat.matrix) == 4
assert all(len(row) == 4 for row in info.proj_mat.matrix)


def depth():
    """Return the planar depth, (height, width) m."""
    return airsim.get_pfm_array(client.simGetImages([airsim.ImageRequest("0", 1, True)])[0]).astype(float)


down = airsim.Pose(airsim.Vector3r(0.3, 0.1, 0), airsim.to_quaternion(-math.pi / 2, 0, 0))
client.simSetCameraPose("0", down)
seen = client.simGetCameraInfo("0").pose
assert np.abs(vector(seen.position) - place - (0.3, 0.1, 0)).max() < 0.02
pitch, _, _ = airsim.to_eularian_angles(seen.orientation)
assert abs(pitch + math.pi / 2) < 0.05
assert np.abs(depth() + place[2]).max() < 0.15, "flat ground is equally far everywhere along the axis"

client.simSetCameraPose("0", airsim.Pose(airsim.Vector3r(0.3, 0, 0), airsim.to_quaternion(0, 0, 0)))
for fov in (60.0, 120.0):
    client.simSetCameraFov("0", fov)
    assert abs(client.simGetCameraInfo("0").fov - fov) < 1e-4
    picture, half = depth(), math.tan(math.radians(fov) / 2)
    row = (2 * 143.5 - 144) / 256 * half
    assert abs(picture[143, 200] * row + place[2]) < 0.15, "the ground at the lower edge comes nearer"
client.simSetCameraFov("0", 90.0)

assert client.simGetDistortionParams("0") == [0.0] * 5
client.simSetDistortionParam("0", "K1", 0.25)
assert client.simGetDistortionParams("0")[0] == 0.25
client.simSetDistortionParam("0", "K1", 0.0)
assert "simGetCameraInfo" in refused(client.simGetCameraInfo, "none such")
client.armDisarm(False)
