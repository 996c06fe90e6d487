"""Reset and fly, many times: every flight is the same as the first, and control is lost each time."""

from shared import at, connect, wait

client = connect()
ends = []
for _ in range(8):
    client.reset()
    assert not client.isApiControlEnabled()
    assert client.getMultirotorState().landed_state == 0
    wait(client, 0.5)
    assert abs(at(client)).max() < 1e-3
    client.enableApiControl(True)
    client.armDisarm(True)
    client.moveToPositionAsync(2, 3, -5, 3).join()
    ends.append(tuple(at(client)))
assert abs(ends[0][2] + 5) < 1
assert len(set(ends)) == 1, ends
