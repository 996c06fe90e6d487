"""Hang in the wind: the controller has no integral term, so it is pushed away as far as its gains let it."""

import airsim
import numpy as np
from shared import at, climb, connect, wait

WIND, GRAVITY = 8.0, 9.80665
AREA = 0.11 * 0.04 + 4 * np.pi * 0.2286 * 0.01  # m², of the body and the rims of the rotors, seen from the front
GAIN = 0.25 * 6 * 0.2 * np.pi / 5.5  # rad/m, of the tilt by which it goes back to where it should be

client = connect()
climb(client, 4)
before = at(client)
client.simSetWind(airsim.Vector3r(WIND, 0, 0))
wait(client, 25)
air = client.simGetGroundTruthEnvironment().air_density
offset = at(client) - before
push = 0.5 * 0.325 * AREA * air * WIND**2
expected = np.arctan(push / GRAVITY) / GAIN
assert abs(offset[0] - expected) < 0.15 * expected, (offset, expected)
assert abs(offset[1]) < 0.02
client.simSetWind(airsim.Vector3r(0, 0, 0))
wait(client, 25)
assert abs(at(client) - before)[:2].max() < 0.02
client.armDisarm(False)
