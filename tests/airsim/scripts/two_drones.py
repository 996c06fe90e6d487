"""Two drones at once, and a third that is added."""

import airsim
import numpy as np
from shared import at, clock, connect, vector

ONE, TWO = "Drone1", "Drone2"
client = connect(ONE, TWO)
assert sorted(client.listVehicles())[:2] == [ONE, TWO]
apart = vector(client.simGetObjectPose(TWO).position) - vector(client.simGetObjectPose(ONE).position)
assert np.allclose(apart, (0, 8, 0), atol=1e-3), apart


def together(*starts):
    """Start moves at the same instant, and wait for all."""
    client.simPause(True)
    moves = [start() for start in starts]
    client.simPause(False)
    for move in moves:
        move.join()


began = clock(client)
together(lambda: client.takeoffAsync(vehicle_name=ONE), lambda: client.takeoffAsync(vehicle_name=TWO))
assert clock(client) - began < 5, "they take off at the same time"
assert np.allclose(at(client, ONE), at(client, TWO), atol=1e-6), "each counts from its own start"
began = clock(client)
together(
    lambda: client.moveToPositionAsync(8, 2, -4, 3, vehicle_name=ONE),
    lambda: client.moveToPositionAsync(-6, 3, -6, 2, vehicle_name=TWO),
)
assert clock(client) - began < 8
assert np.linalg.norm(at(client, ONE) - (8, 2, -4)) < 1.5
assert np.linalg.norm(at(client, TWO) - (-6, 3, -6)) < 1.5
seen = client.getMultirotorState(TWO).kinematics_estimated.position
assert np.array_equal(vector(seen), at(client, TWO))
client.reset()
assert abs(at(client, ONE)).max() < 1e-6
assert abs(at(client, TWO)).max() < 1e-6
if "Added" not in client.listVehicles():
    pose = airsim.Pose(airsim.Vector3r(-4, -4, 0), airsim.to_quaternion(0, 0, 0))
    assert client.simAddVehicle("Added", "simpleflight", pose)
client.enableApiControl(True, "Added")
client.armDisarm(True, "Added")
client.takeoffAsync(vehicle_name="Added").join()
assert -1.7 < at(client, "Added")[2] < -1.4
