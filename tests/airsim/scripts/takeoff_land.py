"""Take off, climb, come down and land."""

from shared import at, climb, clock, connect

client = connect()
assert client.getMultirotorState().landed_state == 0
began = clock(client)
client.takeoffAsync().join()
assert 3 < clock(client) - began < 4.5
assert -1.6 < at(client)[2] < -1.4, "it rises by half a metre less than 2 m"
assert client.getMultirotorState().landed_state == 1
climb(client, 6)
height = at(client)
assert abs(height[2] + 6) < 0.6
assert abs(height[:2]).max() < 0.05
began = clock(client)
client.landAsync().join()
assert abs(at(client)[2]) < 0.05
assert 10 < clock(client) - began < 60, "it comes down at a few decimetres a second"
client.armDisarm(False)
assert abs(at(client)[2]) < 0.05
client.enableApiControl(False)
assert not client.isApiControlEnabled()
