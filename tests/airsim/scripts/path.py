"""Fly along a path with the nose ahead, and come back to its start."""

import airsim
import numpy as np
from shared import at, climb, clock, connect, to_lines, watch

HEIGHT, SPEED = 5.0, 3.0
CORNERS = [(15.0, 0.0), (15.0, -8.0), (0.0, -8.0), (0.0, 0.0)]
client = connect()
climb(client, HEIGHT)
start, began = at(client), clock(client)
places = watch(
    client,
    lambda: client.moveOnPathAsync(
        [airsim.Vector3r(north, east, -HEIGHT) for north, east in CORNERS],
        SPEED,
        120,
        airsim.DrivetrainType.ForwardOnly,
        airsim.YawMode(False, 0),
        4,
        1,
    ),
    0.2,
    lambda places: len(places) > 10 and np.linalg.norm(places[-1][:2]) < 1.0,
)
assert 46 / SPEED - 3 < clock(client) - began < 1.3 * 46 / SPEED
lines = np.array([(*start[:2], -HEIGHT), *((*corner, -HEIGHT) for corner in CORNERS)])
far = to_lines(places, lines)
assert far.max() < 2.5, far.max()
assert np.sqrt(np.mean(far**2)) < 1.2
for corner in lines[1:]:
    assert np.linalg.norm(places - corner, axis=1).min() < 2.0, corner
client.moveToPositionAsync(0, 0, -HEIGHT, 1).join()
assert np.linalg.norm(at(client)[:2]) < 1.0
client.landAsync().join()
client.armDisarm(False)
