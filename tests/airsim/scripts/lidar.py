"""Measure the ground and a wall with two lidars: one that looks down, one that looks around."""

import airsim
import numpy as np
from shared import at, climb, connect, refused, vector, wait

WALL = 59.0  # m, how far north its near side is
TOWER = ((31.0, 14.0, -20.0), (39.0, 22.0, 0.0))  # m, its lowest and highest corner
client = connect()
climb(client, 4)
place = at(client)


def scan(name):
    """Return what a lidar sees, and its points (n, 3) m."""
    data = client.getLidarData(name)
    points = np.array(data.point_cloud, dtype=np.float32).reshape(-1, 3).astype(float)
    assert len(points) == len(data.segmentation)
    assert np.linalg.norm(vector(data.pose.position) - place) < 0.1
    print(data.time_stamp, points.sum())
    return data, points


_, below = scan("Down")
assert len(below) > 5000, "16 channels, 10 000 points a turn, 15 to 45 degrees down"
ground = np.abs(below[:, 2]) < 0.2
assert ground.mean() > 0.8, "most of what is seen down there is ground, given in the frame of the start"
slant = np.linalg.norm(below[ground] - place, axis=1)
downwards = np.degrees(np.arcsin(np.clip((below[ground, 2] - place[2]) / slant, -1, 1)))
assert downwards.min() > 13
assert downwards.max() < 47
assert np.linalg.norm(below - place, axis=1).max() < 100.1

data, around = scan("Level")
yaw = airsim.to_eularian_angles(data.pose.orientation)[2]
assert abs(yaw) < 0.02
ranges, bearings = np.linalg.norm(around, axis=1), np.arctan2(around[:, 1], around[:, 0])
ahead = np.abs(bearings) < 0.01
assert ahead.any()
assert np.abs(ranges[ahead] - (WALL - place[0])).max() < 0.1, ranges[ahead]
seen = around + place
inside = ((seen > np.array(TOWER[0]) - 0.1) & (seen < np.array(TOWER[1]) + 0.1)).all(axis=1)
assert inside.sum() > 10
nearest = np.clip(place, *TOWER)
assert abs(np.linalg.norm(seen[inside] - place, axis=1).min() - np.linalg.norm(nearest - place)) < 0.3
number = client.simGetSegmentationObjectID("Tower_1")
assert set(np.array(data.segmentation)[inside]) == {number}, "its points carry its number"

stamp = data.time_stamp
assert client.getLidarData("Level").time_stamp == stamp, "no time has passed"
wait(client, 0.25)
assert 0.15e9 < client.getLidarData("Level").time_stamp - stamp < 0.35e9, "it turns ten times a second"
assert "Missing" in refused(client.getLidarData, "Missing")
client.armDisarm(False)
