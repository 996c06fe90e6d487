"""Survey a square in stripes, above all that stands around."""

import airsim
import numpy as np
from shared import at, climb, connect, to_lines, wait, watch

HALF, STRIPE, HEIGHT, SPEED = 15.0, 10.0, 30.0, 5.0
client = connect()
climb(client, HEIGHT)
client.moveToPositionAsync(-HALF, -HALF, -HEIGHT, SPEED).join()
client.hoverAsync().join()
wait(client, 4)
stripes, side = [], 1.0
for north in np.arange(-HALF, HALF + 1, STRIPE):
    stripes += [(north, -side * HALF), (north, side * HALF)]
    side = -side
first, corners = at(client), [np.array([north, east, -HEIGHT]) for north, east in stripes]
assert np.linalg.norm(first - corners[0]) < 3
places = watch(
    client,
    lambda: client.moveOnPathAsync(
        [airsim.Vector3r(*map(float, corner)) for corner in corners[1:]],
        SPEED,
        200,
        airsim.DrivetrainType.ForwardOnly,
        airsim.YawMode(False, 0),
        1.5 * SPEED,
        1,
    ),
    0.25,
    lambda places: len(places) > 40 and np.linalg.norm(places[-1] - corners[-1]) < 2.5,
)
assert to_lines(places, corners).max() < 5, "half a stripe"
for north in np.arange(-HALF, HALF + 1, STRIPE):
    stripe = places[np.abs(places[:, 1]) < HALF / 2]
    assert np.abs(stripe[:, 0] - north).min() < 1, "it flew over the middle of every stripe"
client.moveToPositionAsync(0, 0, -HEIGHT, SPEED).join()
client.moveToZAsync(-3, 3).join()
client.hoverAsync().join()
wait(client, 3)
client.landAsync().join()
assert abs(at(client)[2]) < 0.1
client.armDisarm(False)
