"""Put things into the world, look at them, move them, and take them away."""

import math

import airsim
import numpy as np
from shared import climb, connect, vector

client = connect()
climb(client, 3)
towers = client.simListSceneObjects("Tower.*")
assert sorted(towers) == ["Tower_1", "Tower_2", "Tower_3", "Tower_4"]
assert np.allclose(vector(client.simGetObjectPose("Tower_1").position), (35, 18, -10), atol=1e-3)
assert math.isnan(client.simGetObjectPose("Nothing").position.x_val)
assert client.simListSceneObjects("Nothing") == []


def ahead():
    """Return how far it is to what is right ahead, m."""
    picture = airsim.get_pfm_array(client.simGetImages([airsim.ImageRequest("0", 1, True)])[0])
    return float(picture[picture.shape[0] // 2, picture.shape[1] // 2])


eye, free = vector(client.simGetCameraInfo("0").pose.position), ahead()
assert free > 50


def pose(north):
    """Return where to put the thing."""
    return airsim.Pose(airsim.Vector3r(north, 0, float(eye[2])), airsim.to_quaternion(0, 0, 0))


assert "Cube" in client.simListAssets()
name = client.simSpawnObject("Thing", "Cube", pose(10), airsim.Vector3r(2, 2, 2))
assert name in client.simListSceneObjects()
side = vector(client.simGetObjectScale(name))[0]
assert abs(ahead() - (10 - side / 2 - eye[0])) < 0.05
assert client.simSetObjectPose(name, pose(15))
assert abs(vector(client.simGetObjectPose(name).position)[0] - 15) < 1e-4
assert abs(ahead() - (15 - side / 2 - eye[0])) < 0.05
assert client.simSetObjectScale(name, airsim.Vector3r(6, 6, 6))
assert abs(ahead() - (15 - 3 * side / 2 - eye[0])) < 0.05
assert client.simDestroyObject(name)
assert not client.simDestroyObject(name)
assert name not in client.simListSceneObjects()
assert abs(ahead() - free) < 1e-3

lower, upper = client.simGetWorldExtents()
assert lower.latitude < upper.latitude
assert lower.longitude < upper.longitude
home = client.getHomeGeoPoint()
high, behind = airsim.GeoPoint(), airsim.GeoPoint()
high.latitude, high.longitude, high.altitude = home.latitude, home.longitude, home.altitude + 20
behind.latitude, behind.longitude, behind.altitude = home.latitude + 70 / 111_200, home.longitude, home.altitude + 2
assert client.simTestLineOfSightToPoint(high)
assert not client.simTestLineOfSightToPoint(behind), "a wall is in between"
meshes = client.simGetMeshPositionVertexBuffers()
assert {mesh.name for mesh in meshes} >= {tower.lower() for tower in towers}
assert all(len(mesh.vertices) % 3 == 0 and len(mesh.indices) % 3 == 0 for mesh in meshes)

client.moveToPositionAsync(0, 0, -2.5, 1).join()
wall = client.simSpawnObject("Barrier", "Cube", pose(6), airsim.Vector3r(1, 8, 8))
client.simGetCollisionInfo()  # the ground that it stood on is forgotten when it is read
assert not client.simGetCollisionInfo().has_collided
client.moveByVelocityAsync(3, 0, 0, 4).join()
hit = client.simGetCollisionInfo()
assert hit.has_collided
assert wall in hit.object_name
assert client.simGetGroundTruthKinematics().position.x_val < 6, "it does not fly through"
assert not client.simGetCollisionInfo().has_collided, "reading it clears it"
client.simDestroyObject(wall)
client.armDisarm(False)
