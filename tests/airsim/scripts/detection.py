"""Detect things by their names."""

import math

import airsim
import numpy as np
from shared import climb, connect, vector

CAMERA, SCENE = "0", airsim.ImageType.Scene
client = connect()
climb(client, 4)
assert client.simGetDetections(CAMERA, SCENE) == []
client.simAddDetectionFilterMeshName(CAMERA, SCENE, "Gate*")
client.simAddDetectionFilterMeshName(CAMERA, SCENE, "Tower_1")
client.simSetDetectionFilterRadius(CAMERA, SCENE, 200 * 100)
found = {one.name: one for one in client.simGetDetections(CAMERA, SCENE)}
assert set(found) == {"Gate_Left", "Gate_Right", "Gate_Top", "Tower_1"}
info = client.simGetCameraInfo(CAMERA)
eye, focal = vector(info.pose.position), 128 / math.tan(math.radians(info.fov) / 2)
home = client.getHomeGeoPoint()
for name, one in found.items():
    middle = vector(client.simGetObjectPose(name).position)
    ahead, right, down = middle - eye
    assert np.abs(vector(one.relative_pose.position) - (ahead, right, down)).max() < 0.3, name
    u, v = 128 + focal * right / ahead, 72 + focal * down / ahead
    low, high = one.box2D.min, one.box2D.max
    assert low.x_val - 2 <= u <= high.x_val + 2, name
    assert low.y_val - 2 <= v <= high.y_val + 2, name
    assert one.box3D.min.x_val < ahead < one.box3D.max.x_val
    assert abs((one.geo_point.latitude - home.latitude) * 111_200 - middle[0]) < 0.5
client.simSetDetectionFilterRadius(CAMERA, SCENE, 30 * 100)
assert {one.name for one in client.simGetDetections(CAMERA, SCENE)} == {"Gate_Left", "Gate_Right", "Gate_Top"}
assert client.simGetDetections(CAMERA, airsim.ImageType.Segmentation) == [], "each type has its own"
client.simClearDetectionMeshNames(CAMERA, SCENE)
assert client.simGetDetections(CAMERA, SCENE) == []
client.armDisarm(False)
