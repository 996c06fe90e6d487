"""Pause in the middle of a move, go on for a while, and let the rest of it happen."""

import numpy as np
from shared import at, climb, clock, connect

client = connect()
climb(client, 4)
for speed in (1.0, 2.0, 3.0):
    client.simPause(True)
    assert client.simIsPause()
    began, start = clock(client), at(client)
    move = client.moveByVelocityZAsync(-speed, 0, -4, 6)
    for step in (1.0, 0.5, 1.5, 0.03):
        before = clock(client)
        client.simContinueForTime(step)
        assert abs(clock(client) - before - step) < 0.0031
        assert client.simIsPause()
        held = at(client)
        assert np.array_equal(held, at(client)), "it stands still while paused"
        assert clock(client) == clock(client)
    assert clock(client) - began < 3.1
    client.simPause(False)
    move.join()
    assert abs(clock(client) - began - 6) < 0.05
    assert 0.4 * 6 * speed < (start - at(client))[0] < 6 * speed
    client.moveToPositionAsync(0, 0, -4, 3).join()
    client.simPause(True)
    before = clock(client)
    client.simContinueForFrames(30)
    assert abs(clock(client) - before - 0.5) < 0.0031
    client.simPause(False)
client.armDisarm(False)
