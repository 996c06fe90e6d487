"""What the scripts share: connecting, and where and when it is."""

import sys
from itertools import pairwise

import airsim
import numpy as np


def connect(*vehicles):
    """Return a client of the port given first on the command line, with its vehicles reset, armed and its own."""
    client = airsim.MultirotorClient(port=int(sys.argv[1]))
    client.confirmConnection()
    client.reset()
    client.simSetWind(airsim.Vector3r(0, 0, 0))
    for name in vehicles or ("",):
        client.enableApiControl(True, name)
        assert client.isApiControlEnabled(name)
        assert client.armDisarm(True, name)
    return client


def at(client, vehicle=""):
    """Return where a vehicle is, (3,) m, NED from its start; print it, for a trace to compare."""
    place = client.simGetGroundTruthKinematics(vehicle).position
    print(vehicle, place.x_val, place.y_val, place.z_val)
    return vector(place)


def vector(value):
    """Return a vector of the client as an array (3,)."""
    return np.array([value.x_val, value.y_val, value.z_val])


def clock(client):
    """Return the simulated time, s."""
    return client.getMultirotorState().timestamp * 1e-9


def wait(client, seconds):
    """Let simulated time pass."""
    client.simContinueForTime(seconds)
    client.simPause(False)


def climb(client, height, vehicle=""):
    """Take off and climb to a height (m); wait until it hangs still there."""
    client.takeoffAsync(vehicle_name=vehicle).join()
    client.moveToZAsync(-height, 2, vehicle_name=vehicle).join()
    client.hoverAsync(vehicle_name=vehicle).join()
    wait(client, 4)


def watch(client, start, step, arrived):
    """Start a move, look where the vehicle is after every step (s) until it has arrived; return that, (n, 3)."""
    client.simPause(True)
    move, places = start(), []
    while not places or not arrived(places):
        client.simContinueForTime(step)
        places.append(at(client))
    client.simPause(False)
    move.join()
    return np.array(places)


def refused(call, *arguments):
    """Return with which words a call is refused."""
    try:
        call(*arguments)
    except Exception as error:  # the client has two classes of errors, by the version of its transport
        return str(error)
    raise AssertionError("it was not refused")


def to_lines(points, corners):
    """Return how far points (n, 3) are from the nearest of the lines between corners, (n,) m."""
    best = np.full(len(points), np.inf)
    for one, two in pairwise(corners):
        along = np.clip((points - one) @ (two - one) / ((two - one) @ (two - one)), 0, 1)
        best = np.minimum(best, np.linalg.norm(points - (one + along[:, None] * (two - one)), axis=1))
    return best
