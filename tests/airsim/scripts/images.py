"""Take pictures of every type: as floats, raw, and as PNG."""

import struct
import zlib

import airsim
import numpy as np
from shared import at, climb, connect, vector

FLOATS = range(1, 5)
COLOURED = (0, 5, 6, 7)
WALL = 59.0  # m, how far north its near side is
FAR = 65504.0  # m, of the sky
client = connect()
climb(client, 4)
place = at(client)
assert client.simSetSegmentationObjectID("Wall_North", 42)
assert client.simGetSegmentationObjectID("wall_north") == 42

numbers = client.simGetImages([airsim.ImageRequest("0", one, True, False) for one in FLOATS])
assert {one.time_stamp for one in numbers} == {numbers[0].time_stamp}
planar, perspective, shade, disparity = (airsim.get_pfm_array(one).astype(float) for one in numbers)
height, width = planar.shape
assert (height, width) == (144, 256)
middle = height // 2, width // 2
eye = vector(numbers[0].camera_position)
assert np.linalg.norm(eye - place) < 0.7
assert abs(planar[middle] - (WALL - eye[0])) < 0.2, planar[middle]
v, u = np.mgrid[:height, :width] + 0.5
slant = np.sqrt(1 + (2 * u / width - 1) ** 2 + ((2 * v - height) / width) ** 2)
hit = planar < FAR
assert 0.3 < hit.mean() < 1
assert np.allclose(perspective[hit], (planar * slant)[hit], rtol=1e-3), "a field of view of 90 degrees"
assert np.allclose(shade, np.minimum(planar / 100, 1), atol=1e-6)
near = hit & (disparity < 1)
assert np.allclose((disparity * planar)[near], disparity[middle] * planar[middle], rtol=1e-3)
rows = (2 * v - height) / width
ground = rows > 0.45
assert np.median(np.abs((planar * rows)[ground] + eye[2])) < 0.1, "the ground is as far down as the camera is high"

raw = client.simGetImages([airsim.ImageRequest("0", one, False, False) for one in COLOURED])
scene, segments, normals, infrared = (
    np.frombuffer(one.image_data_uint8, np.uint8).reshape(one.height, one.width, 3) for one in raw
)
assert (infrared[middle] == 42).all()
wall = (infrared == 42).all(axis=2)
assert wall.sum() > 300
assert len(np.unique(segments[wall], axis=0)) == 1, "one colour for one number"
assert (segments[~wall] != segments[middle]).any(axis=1).all()
assert (np.abs(normals[middle].astype(int) - (127, 127, 0)) <= 3).all(), "it faces south: blue, green, red"
top = scene[0].astype(int)
assert (top[:, 0] > top[:, 2]).mean() > 0.9, "a blue sky"
assert scene.std() > 10
assert len(np.unique(scene.reshape(-1, 3), axis=0)) > 100

for kind, compressed in enumerate(
    client.simGetImages([airsim.ImageRequest("0", one, False, True) for one in range(8)])
):
    data = compressed.image_data_uint8
    assert compressed.compress
    assert compressed.image_type == kind
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    assert struct.unpack(">II", data[16:24]) == (width, height)
    assert data.endswith(b"IEND\xaeB`\x82")
    start = data.index(b"IDAT")
    if data.count(b"IDAT") == 1:
        (size,) = struct.unpack(">I", data[start - 4 : start])
        assert len(zlib.decompress(data[start + 4 : start + 4 + size])) == height * (4 * width + 1)
single = client.simGetImage("0", airsim.ImageType.Scene)
assert single.startswith(b"\x89PNG")
assert single == client.simGetImage("front_center", airsim.ImageType.Scene), "0 is another name of front_center"

below = airsim.get_pfm_array(client.simGetImages([airsim.ImageRequest("3", 1, True)])[0])
assert abs(below[middle] + place[2]) < 0.5, "the bottom camera sees the ground"
behind = client.simGetImages([airsim.ImageRequest("back_center", 2, True)])[0]
assert min(behind.image_data_float) > 0
(absent,) = client.simGetImages([airsim.ImageRequest("0", 8, False, False)])
assert absent.message
assert absent.width == 0, "optical flow is not offered, which is said"
client.armDisarm(False)
