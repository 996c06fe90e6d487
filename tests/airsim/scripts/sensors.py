"""Read every sensor, on the ground and in flight."""

import math

import airsim
import numpy as np
from shared import at, climb, clock, connect, vector, wait

WALL = 59.0  # m, how far north its near side is
client = connect()
wait(client, 2)


def many(read, count=100, step=0.02):
    """Return a reading (count, n) after every step (s)."""
    rows = []
    for _ in range(count):
        wait(client, step)
        rows.append(np.atleast_1d(read()))
    rows = np.array(rows, dtype=float)
    print(rows.sum(axis=0).tolist())
    return rows


force = many(lambda: vector(client.getImuData().linear_acceleration))
assert np.allclose(force.mean(axis=0), (0, 0, -9.807), atol=0.05), force.mean(axis=0)
assert 1e-5 < force.std() / 9.8 < 1
turning = many(lambda: vector(client.getImuData().angular_velocity))
assert np.abs(turning.mean(axis=0)).max() < 0.01
assert client.getImuData().time_stamp <= clock(client) * 1e9 + 1000

field = many(lambda: vector(client.getMagnetometerData().magnetic_field_body))
strength = np.linalg.norm(field.mean(axis=0))
assert 0.3 < strength < 0.7, "gauss, at 48 degrees north"
assert field.mean(axis=0)[2] > 0.3, "it points down there"
assert 0.002 < field.std(axis=0).mean() < 0.01

air = client.simGetGroundTruthEnvironment()
pressure = many(lambda: client.getBarometerData().pressure)
assert abs(pressure.mean() - air.air_pressure) < 30
assert 1 < pressure.std() < 6, "Pa"
altitude = many(lambda: client.getBarometerData().altitude).mean()

receiver = client.getGpsData()
assert receiver.is_valid
assert receiver.gnss.fix_type == 3
assert receiver.gnss.eph < 3
home = client.getHomeGeoPoint()
assert abs(receiver.gnss.geo_point.latitude - home.latitude) < 1e-6

climb(client, 10)
client.moveToPositionAsync(20, 0, -10, 5).join()
client.hoverAsync().join()
wait(client, 5)
place = at(client)
risen = many(lambda: client.getBarometerData().altitude).mean() - altitude
assert abs(risen + place[2]) < 1.0, risen
gnss = client.getGpsData().gnss
metres = (gnss.geo_point.latitude - home.latitude) * math.pi / 180 * 6_378_137
assert abs(metres - place[0]) < 0.2, "one per cent: the earth is no sphere"
assert abs(gnss.geo_point.altitude - home.altitude + place[2]) < 0.2
assert np.abs(vector(gnss.velocity)).max() < 0.3

client.moveToZAsync(-2, 2).join()
client.hoverAsync().join()
wait(client, 4)
place = at(client)
ahead = many(lambda: client.getDistanceSensorData("Ahead").distance)
assert abs(ahead.mean() - (WALL - place[0])) < 0.2, (ahead.mean(), place)
assert 0.1 < ahead.std() < 0.4
below = many(lambda: client.getDistanceSensorData("Below").distance)
assert abs(below.mean() + place[2]) < 0.2, (below.mean(), place)
up = client.getDistanceSensorData("Above")
assert abs(up.distance - up.max_distance) < 1, "nothing is up there"
north = field.mean(axis=0)
client.rotateToYawAsync(90).join()
wait(client, 3)
yaw = airsim.to_eularian_angles(client.getImuData().orientation)[2]
turned = many(lambda: vector(client.getMagnetometerData().magnetic_field_body)).mean(axis=0)
bearing = math.atan2(-turned[1], turned[0]) - math.atan2(-north[1], north[0])
assert abs(math.remainder(bearing - yaw, 2 * math.pi)) < 0.03, "the field turns the other way"
client.armDisarm(False)
