"""Circle a point with the nose towards it, a velocity every tenth of a second."""

import math

import airsim
import numpy as np
from shared import at, climb, connect

RADIUS, SPEED, HEIGHT, AHEAD = 6.0, 2.0, 3.0, 1.0
client = connect()
climb(client, HEIGHT)
centre = at(client)[:2] + (RADIUS, 0)
turned, before, radii, misses = 0.0, math.pi, [], []
for _ in range(300):
    place = at(client)[:2] - centre
    angle = math.atan2(place[1], place[0])
    turned, before = turned + math.remainder(angle - before, 2 * math.pi), angle
    if turned >= 2 * math.pi:
        break
    aim = RADIUS * np.array([math.cos(angle + AHEAD / RADIUS), math.sin(angle + AHEAD / RADIUS)]) - place
    north, east = SPEED * aim / np.linalg.norm(aim)
    inwards = math.degrees(angle - math.pi)
    client.moveByVelocityZAsync(
        float(north),
        float(east),
        -HEIGHT,
        0.1,
        airsim.DrivetrainType.MaxDegreeOfFreedom,
        airsim.YawMode(False, inwards),
    ).join()
    yaw = airsim.to_eularian_angles(client.simGetGroundTruthKinematics().orientation)[2]
    radii.append(np.linalg.norm(place))
    misses.append(abs(math.remainder(yaw - math.radians(inwards), 2 * math.pi)))
assert turned >= 2 * math.pi, "the circle is closed"
steady = len(radii) // 4
assert np.abs(np.array(radii[steady:]) - RADIUS).max() < 0.8, (min(radii[steady:]), max(radii[steady:]))
assert max(misses[steady:]) < 0.4, max(misses[steady:])
assert abs(at(client)[2] + HEIGHT) < 0.6
client.armDisarm(False)
