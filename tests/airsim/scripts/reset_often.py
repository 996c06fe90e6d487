"""Fly and reset, many times: every flight is like the first, and control is lost each time."""

from shared import at, connect, wait

client = connect()
ends = []
for _ in range(8):
    wait(client, 0.5)
    client.enableApiControl(True)
    client.armDisarm(True)
    client.moveToPositionAsync(2, 3, -5, 3).join()
    ends.append(tuple(at(client)))
    client.reset()
    assert not client.isApiControlEnabled()
    assert client.getMultirotorState().landed_state == 0
    assert abs(at(client)).max() < 1e-6
assert abs(ends[0][2] + 5) < 1
assert len(set(ends)) == 1, ends
