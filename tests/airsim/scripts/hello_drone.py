"""Say hello: read every state and sensor, fly somewhere, turn, look around, and go home."""

import math

import airsim
from shared import at, clock, connect, vector, wait

client = connect()
assert client.ping()
state = client.getMultirotorState()
print(state.timestamp, state.landed_state, state.gps_location.altitude)
assert state.landed_state == airsim.LandedState.Landed
home = client.getHomeGeoPoint()
assert abs(home.latitude - 47.641468) < 1e-9
assert abs(home.longitude + 122.140165) < 1e-9
assert abs(state.gps_location.latitude - home.latitude) < 1e-6
print(client.getImuData(), client.getBarometerData(), client.getMagnetometerData(), client.getGpsData())
assert "SimMode" in client.getSettingsString() or client.getSettingsString() == "{}"

client.takeoffAsync().join()
client.simGetCollisionInfo()  # the ground that it stood on is forgotten when it is read
began = clock(client)
client.moveToPositionAsync(-5, 5, -8, 4).join()
assert clock(client) - began < 6
client.hoverAsync().join()
wait(client, 3)
there = at(client)
assert abs(there - (-5, 5, -8)).max() < 2.5, there
state = client.getMultirotorState()
assert vector(state.kinematics_estimated.position).tolist() == there.tolist()
assert abs(state.gps_location.altitude - home.altitude + there[2]) < 0.01
assert not client.simGetCollisionInfo().has_collided

client.rotateToYawAsync(90).join()
wait(client, 3)
yaw = airsim.to_eularian_angles(client.simGetVehiclePose().orientation)[2]
assert abs(math.degrees(yaw) - 90) < 6, yaw
client.rotateByYawRateAsync(30, 2).join()
turned = math.degrees(airsim.to_eularian_angles(client.simGetVehiclePose().orientation)[2]) - math.degrees(yaw)
assert 30 < turned < 70, turned
rotors = client.getRotorStates().rotors
assert len(rotors) == 4
assert abs(sum(rotor["thrust"] for rotor in rotors) - 9.80665) < 0.5, "they carry one kilogramme"

pictures = client.simGetImages(
    [
        airsim.ImageRequest("0", airsim.ImageType.DepthVis),
        airsim.ImageRequest("1", airsim.ImageType.DepthPlanar, True),
        airsim.ImageRequest("1", airsim.ImageType.Scene),
        airsim.ImageRequest("1", airsim.ImageType.Scene, False, False),
    ]
)
assert [len(picture.image_data_float) > 1 for picture in pictures] == [False, True, False, False]
assert len(airsim.get_pfm_array(pictures[1])) == pictures[1].height
assert len(pictures[3].image_data_uint8) == 3 * pictures[3].width * pictures[3].height

client.goHomeAsync().join()
assert abs(at(client)[:2]).max() < 1
client.armDisarm(False)
client.reset()
client.enableApiControl(False)
