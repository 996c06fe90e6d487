"""Fly a box, a velocity a side, with the nose ahead."""

import math

import airsim
import numpy as np
from shared import at, climb, clock, connect

SPEED, SECONDS, HEIGHT = 2.0, 5.0, 5.0
client = connect()
climb(client, HEIGHT)
start, ahead = at(client), airsim.YawMode(is_rate=False, yaw_or_rate=0)
for north, east in ((1, 0), (0, 1), (-1, 0), (0, -1)):
    began, before = clock(client), at(client)
    client.moveByVelocityZAsync(
        SPEED * north, SPEED * east, -HEIGHT, SECONDS, airsim.DrivetrainType.ForwardOnly, ahead
    ).join()
    assert abs(clock(client) - began - SECONDS) < 0.05
    state = client.simGetGroundTruthKinematics()
    velocity = np.array([state.linear_velocity.x_val, state.linear_velocity.y_val])
    assert np.linalg.norm(velocity - SPEED * np.array([north, east])) < 0.35, velocity
    assert 5.5 < (at(client) - before) @ (north, east, 0) < 11, "5 s at 2 m/s, less what it takes to get there"
    yaw = airsim.to_eularian_angles(state.orientation)[2]
    assert abs(math.remainder(yaw - math.atan2(east, north), 2 * math.pi)) < 0.2, yaw
client.hoverAsync().join()
end = at(client)
assert np.linalg.norm((end - start)[:2]) < 4, "the box closes but for the time that each turn takes"
assert abs(end[2] + HEIGHT) < 0.8
client.landAsync().join()
client.armDisarm(False)
