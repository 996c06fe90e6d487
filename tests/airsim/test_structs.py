"""Every struct against AirSim's keys, their order and their types, packed by another packer."""

from dataclasses import fields
from typing import Any

import msgpack
import numpy as np
import pytest

from crosstrack.airsim import structs
from crosstrack.airsim.codec import BadCast, record

KEYS = {
    "Vector2r": "x_val:f y_val:f",
    "Vector3r": "x_val:f y_val:f z_val:f",
    "Quaternionr": "w_val:f x_val:f y_val:f z_val:f",
    "Pose": "position:Vector3r orientation:Quaternionr",
    "GeoPoint": "latitude:d longitude:d altitude:f",
    "YawMode": "is_rate:b yaw_or_rate:f",
    "RCData": "timestamp:u pitch:f roll:f throttle:f yaw:f left_z:f right_z:f switches:h vendor_id:s "
    "is_initialized:b is_valid:b",
    "CollisionInfo": "has_collided:b penetration_depth:f time_stamp:u normal:Vector3r impact_point:Vector3r "
    "position:Vector3r object_name:s object_id:i",
    "KinematicsState": "position:Vector3r orientation:Quaternionr linear_velocity:Vector3r angular_velocity:Vector3r "
    "linear_acceleration:Vector3r angular_acceleration:Vector3r",
    "EnvironmentState": "position:Vector3r geo_point:GeoPoint gravity:Vector3r air_pressure:f temperature:f "
    "air_density:f",
    "MultirotorState": "collision:CollisionInfo kinematics_estimated:KinematicsState gps_location:GeoPoint timestamp:u "
    "landed_state:i rc_data:RCData",
    "RotorState": "thrust:f torque_scaler:f speed:f",
    "RotorStates": "rotors:[RotorState timestamp:u",
    "ImageRequest": "camera_name:s image_type:i pixels_as_float:b compress:b",
    "ImageResponse": "image_data_uint8:y image_data_float:[f camera_position:Vector3r camera_name:s "
    "camera_orientation:Quaternionr time_stamp:u message:s pixels_as_float:b compress:b width:i height:i image_type:i",
    "LidarData": "time_stamp:u point_cloud:[f pose:Pose segmentation:[i",
    "DistanceSensorData": "time_stamp:u distance:f min_distance:f max_distance:f relative_pose:Pose",
    "ImuData": "time_stamp:u orientation:Quaternionr angular_velocity:Vector3r linear_acceleration:Vector3r",
    "BarometerData": "time_stamp:u altitude:f pressure:f qnh:f",
    "MagnetometerData": "time_stamp:u magnetic_field_body:Vector3r magnetic_field_covariance:[f",
    "GnssReport": "geo_point:GeoPoint eph:f epv:f velocity:Vector3r fix_type:i time_utc:u",
    "GpsData": "time_stamp:u gnss:GnssReport is_valid:b",
    "ProjectionMatrix": "matrix:[[f",
    "CameraInfo": "pose:Pose fov:f proj_mat:ProjectionMatrix",
    "Box2D": "min:Vector2r max:Vector2r",
    "Box3D": "min:Vector3r max:Vector3r",
    "DetectionInfo": "name:s geo_point:GeoPoint box2D:Box2D box3D:Box3D relative_pose:Pose",
    "MeshPositionVertexBuffersResponse": "position:Vector3r orientation:Quaternionr vertices:[f indices:[h name:s",
}
"""AirSim's keys; f single, d double, b bool, i and h and u integers, s text, y bytes, [ a list"""
PACKER = msgpack.Packer()
SINGLE = msgpack.Packer(use_single_float=True)
STRUCTS = [name for name in KEYS if hasattr(structs, name)]


def invent(kind: str, rng: np.random.Generator) -> Any:
    """Return a value of a kind, as msgpack would decode it."""
    match kind:
        case "f":
            return float(np.float32(rng.normal() * 100))
        case "d":
            return float(rng.normal() * 100)
        case "b":
            return bool(rng.integers(2))
        case "i":
            return int(rng.integers(-(1 << 31), 1 << 31))
        case "h":
            return int(rng.integers(1 << 16))
        case "u":
            return int(rng.integers(1 << 63))
        case "s":
            return "name" * int(rng.integers(0, 20))
        case "y":
            return rng.bytes(int(rng.integers(300)))
        case "[[f":
            return [[invent("f", rng) for _ in range(4)] for _ in range(4)]
    if kind.startswith("["):
        return [invent(kind[1:], rng) for _ in range(rng.integers(0, 40))]
    return {key: invent(of, rng) for key, of in (field.split(":") for field in KEYS[kind].split())}


def pack(kind: str, value: Any) -> bytes:
    """Return a value of a kind as another packer packs it, map by map."""
    if kind.startswith("["):
        parts = [PACKER.pack_array_header(len(value)), *(pack(kind[1:], each) for each in value)]
    elif kind in KEYS:
        kinds = [field.split(":") for field in KEYS[kind].split()]
        parts = [PACKER.pack_map_header(len(kinds))]
        parts += [PACKER.pack(key) + pack(of, value[key]) for key, of in kinds]
    else:
        parts = [(SINGLE if kind == "f" else PACKER).pack(value)]
    return b"".join(parts)


def test_every_struct_is_known() -> None:
    made = {
        name for name, kind in vars(structs).items() if isinstance(kind, type) and kind.__module__ == structs.__name__
    }
    assert made == set(STRUCTS)
    for name in STRUCTS:
        keys = [field.partition(":")[0] for field in KEYS[name].split()]
        assert [field.name for field in fields(getattr(structs, name))] == keys


@pytest.mark.parametrize("name", STRUCTS)
@pytest.mark.parametrize("seed", range(5))
def test_structs_are_byte_for_byte_those_of_airsim(name: str, seed: int) -> None:
    wire = invent(name, np.random.default_rng(seed))
    codec = record(getattr(structs, name))
    value = codec.unpack(wire)
    assert codec.pack(value) == pack(name, wire)


@pytest.mark.parametrize("name", STRUCTS)
def test_missing_keys_keep_the_default_and_unknown_ones_are_passed_over(name: str) -> None:
    kind = getattr(structs, name)
    assert record(kind).pack(record(kind).unpack({"unheard_of": {"x": 1}})) == record(kind).pack(kind())
    with pytest.raises(BadCast):
        record(kind).unpack([])


def test_what_a_python_client_sends_of_a_remote_control_is_taken() -> None:
    sent = {
        "timestamp": 3,
        "pitch": 0.25,
        "roll": 0,
        "throttle": 1,
        "yaw": 0.0,
        "is_initialized": True,
        "is_valid": True,
    }
    sent |= {f"switch{k}": 0 for k in range(1, 9)}
    data = record(structs.RCData).unpack(sent)
    assert (data.timestamp, data.pitch, data.throttle, data.switches, data.is_valid) == (3, 0.25, 1.0, 0, True)


def test_defaults_are_not_shared() -> None:
    first, second = structs.Pose(), structs.Pose()
    first.position[0] = 5
    assert second.position.tolist() == [0, 0, 0]
