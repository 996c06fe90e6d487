"""Chase a carrot along a path, one short velocity after another, and say how well: carrot.py PORT SPEED.

The law is the carrot chasing of Bhadani, "Path Planning of Unmanned System using Carrot-chasing Algorithm"
(arXiv:2012.13227), as a tutorial flies it in AirSim: the carrot is some way ahead of the nearest point of the leg, the
heading goes to it, and an extra sideways speed is in proportion to how far the heading had to change.
"""

import json
import math
import sys
from itertools import pairwise

import airsim
import numpy as np
from shared import to_lines

HEIGHT, AHEAD, GAIN, STEP = -3.0, 0.8, 0.8, 0.02
CORNERS = [(5.0, 0.0), (5.0, 8.0), (8.0, 12.0), (4.0, 9.0)]
BLUE, RED, GREEN = [0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]


def bearing(one, two):
    """Return the direction from a point to another, from -90 to 270 degrees as the tutorial has it, rad."""
    north, east = two[0] - one[0], two[1] - one[1]
    angle = math.atan2(east, north)
    return angle + 2 * math.pi if north < 0 and angle <= -math.pi / 2 else angle


def beyond(point, leg):
    """Return whether a point is beyond the end of a leg, in either of its components."""
    (a, b), (c, d) = leg
    return (point[0] - c) * (c - a) > 0 or (point[1] - d) * (d - b) > 0


def chase(client, speed, corners):
    """Fly along corners; return the way flown, (n, 2) m."""
    state = client.simGetGroundTruthKinematics()
    heading = airsim.to_eularian_angles(state.orientation)[2]
    way = [(state.position.x_val, state.position.y_val)]
    for leg in pairwise([way[0], *corners]):
        last = leg[1] == corners[-1]
        course = bearing(*leg)
        while True:
            here = way[-1]
            along = math.cos(course) * (here[0] - leg[0][0]) + math.sin(course) * (here[1] - leg[0][1])
            carrot = [leg[0][k] + (along + AHEAD) * (math.cos(course), math.sin(course))[k] for k in (0, 1)]
            if beyond(here if last else carrot, leg):
                break
            wanted = bearing(here, carrot)
            sideways = min(GAIN * (wanted - heading) * speed, 1.0)
            heading = wanted
            east = speed * math.sin(heading) + sideways * STEP
            if abs(east) >= speed:
                north, east = 0.0, speed
            else:
                north = math.copysign(math.sqrt(speed**2 - east**2), math.cos(heading))
            client.moveByVelocityZAsync(north, east, HEIGHT, STEP).join()
            place = client.simGetGroundTruthKinematics().position
            way.append((place.x_val, place.y_val))
            one, two = ([airsim.Vector3r(*map(float, point), HEIGHT)] for point in way[-2:])
            client.simPlotArrows(one, two, arrow_size=8.0, color_rgba=BLUE)
            client.simPlotLineList(one + two, color_rgba=RED, is_persistent=True)
    return np.array(way)


client = airsim.MultirotorClient(port=int(sys.argv[1]))
client.confirmConnection()
client.reset()
client.enableApiControl(True)
client.armDisarm(True)
client.takeoffAsync().join()
client.moveToZAsync(HEIGHT, 1).join()
client.simSetTraceLine([1, 0, 0, 1], thickness=5)
client.simFlushPersistentMarkers()
client.simPlotPoints(
    [airsim.Vector3r(*corner, HEIGHT) for corner in CORNERS], color_rgba=GREEN, size=30, is_persistent=True
)
flown = chase(client, float(sys.argv[2]), CORNERS)
errors = to_lines(flown, np.array([(0.0, 0.0), *CORNERS]))
client.goHomeAsync().join()
client.landAsync().join()
client.armDisarm(False)
client.enableApiControl(False)
with open(sys.argv[3], "w") as file:
    json.dump(
        {
            "way": flown.tolist(),
            "root_mean_square": float(np.sqrt(np.mean(errors**2))),
            "miss_at_end": float(np.linalg.norm(flown[-1] - CORNERS[-1])),
        },
        file,
    )
