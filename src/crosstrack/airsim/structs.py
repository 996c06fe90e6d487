"""The structs of AirSim's protocol; fields are its keys in its order, world NED, body FRD, quaternions xyzw."""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from crosstrack.airsim.arrays import INTS, PLANE, PROJECTION, QUATERNION, SINGLES, UINTS, VECTOR
from crosstrack.airsim.codec import BINARY, DOUBLE, FLAG, INT32, SINGLE, TEXT, UINT16, UINT64, Listed, record
from crosstrack.types import Array

Flag = Annotated[bool, FLAG]
Single = Annotated[float, SINGLE]
Double = Annotated[float, DOUBLE]
Int = Annotated[int, INT32]
Switches = Annotated[int, UINT16]
Time = Annotated[int, UINT64]
Text = Annotated[str, TEXT]
Bytes = Annotated[bytes, BINARY]
Plane = Annotated[Array, PLANE]
Vector = Annotated[Array, VECTOR]
Quaternion = Annotated[Array, QUATERNION]
Singles = Annotated[NDArray[np.float32], SINGLES]
Ints = Annotated[NDArray[np.int32], INTS]
UInts = Annotated[NDArray[np.uint32], UINTS]
Projection = Annotated[NDArray[np.float32], PROJECTION]


def zero() -> Array:
    """Return a vector of zeros, shape (3,)."""
    return np.zeros(3)


def corner() -> Array:
    """Return a point of a plane, shape (2,), zero."""
    return np.zeros(2)


def level() -> Array:
    """Return the quaternion that turns nothing."""
    return np.array([0.0, 0.0, 0.0, 1.0])


def no_numbers() -> NDArray[np.float32]:
    """Return an empty list of numbers."""
    return np.empty(0, np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Where something is, and how it is turned."""

    position: Vector = field(default_factory=zero)
    """(3,) m"""
    orientation: Quaternion = field(default_factory=level)
    """(4,) xyzw"""


@dataclass(frozen=True, slots=True, eq=False)
class GeoPoint:
    """A point of the earth."""

    latitude: Double = 0.0
    """deg"""
    longitude: Double = 0.0
    """deg"""
    altitude: Single = 0.0
    """m"""


@dataclass(frozen=True, slots=True, eq=False)
class YawMode:
    """What a move does about yaw."""

    is_rate: Flag = True
    """whether it is a rate, not an angle"""
    yaw_or_rate: Single = 0.0
    """deg or deg/s, clockwise seen from above"""


@dataclass(frozen=True, slots=True, eq=False)
class RCData:
    """What a remote control says."""

    timestamp: Time = 0
    """ns"""
    pitch: Single = 0.0
    """-1 to 1"""
    roll: Single = 0.0
    """-1 to 1"""
    throttle: Single = 0.0
    """0 to 1"""
    yaw: Single = 0.0
    """-1 to 1"""
    left_z: Single = 0.0
    """position of a dial"""
    right_z: Single = 0.0
    """position of a dial"""
    switches: Switches = 0
    """a bit for each"""
    vendor_id: Text = ""
    """maker of the remote control"""
    is_initialized: Flag = False
    """whether one is connected"""
    is_valid: Flag = False
    """whether the data are to be used"""


@dataclass(frozen=True, slots=True, eq=False)
class CollisionInfo:
    """The last contact of a vehicle."""

    has_collided: Flag = False
    """whether there was one since it was last asked"""
    penetration_depth: Single = 0.0
    """m"""
    time_stamp: Time = 0
    """ns"""
    normal: Vector = field(default_factory=zero)
    """(3,) unit, out of the obstacle"""
    impact_point: Vector = field(default_factory=zero)
    """(3,) m"""
    position: Vector = field(default_factory=zero)
    """(3,) m, of the vehicle"""
    object_name: Text = ""
    """what was hit"""
    object_id: Int = -1
    """its segmentation number"""


@dataclass(frozen=True, slots=True, eq=False)
class KinematicsState:
    """How a vehicle moves."""

    position: Vector = field(default_factory=zero)
    """(3,) m"""
    orientation: Quaternion = field(default_factory=level)
    """(4,) xyzw, body to world"""
    linear_velocity: Vector = field(default_factory=zero)
    """(3,) m/s, world"""
    angular_velocity: Vector = field(default_factory=zero)
    """(3,) rad/s, body"""
    linear_acceleration: Vector = field(default_factory=zero)
    """(3,) m/s², world"""
    angular_acceleration: Vector = field(default_factory=zero)
    """(3,) rad/s², body"""


@dataclass(frozen=True, slots=True, eq=False)
class EnvironmentState:
    """What the air and gravity are at a vehicle."""

    position: Vector = field(default_factory=zero)
    """(3,) m"""
    geo_point: GeoPoint = field(default_factory=GeoPoint)
    """where on earth"""
    gravity: Vector = field(default_factory=zero)
    """(3,) m/s²"""
    air_pressure: Single = 0.0
    """Pa"""
    temperature: Single = 0.0
    """K"""
    air_density: Single = 0.0
    """kg/m³"""


@dataclass(frozen=True, slots=True, eq=False)
class MultirotorState:
    """All that is known of a multirotor."""

    collision: CollisionInfo = field(default_factory=CollisionInfo)
    """never filled by AirSim"""
    kinematics_estimated: KinematicsState = field(default_factory=KinematicsState)
    """relative to its start"""
    gps_location: GeoPoint = field(default_factory=GeoPoint)
    """where on earth"""
    timestamp: Time = 0
    """ns"""
    landed_state: Int = 0
    """0 landed, 1 flying"""
    rc_data: RCData = field(default_factory=RCData)
    """what the remote control says"""


@dataclass(frozen=True, slots=True, eq=False)
class RotorState:
    """How a rotor turns."""

    thrust: Single = 0.0
    """N"""
    torque_scaler: Single = 0.0
    """N m, signed by its sense"""
    speed: Single = 0.0
    """rad/s"""


@dataclass(frozen=True, slots=True, eq=False)
class RotorStates:
    """How the rotors of a vehicle turn."""

    rotors: Annotated[tuple[RotorState, ...], Listed(record(RotorState))] = ()
    """front right, rear left, front left, rear right"""
    timestamp: Time = 0
    """ns"""


@dataclass(frozen=True, slots=True, eq=False)
class ImageRequest:
    """Which image is wanted, and how."""

    camera_name: Text = "0"
    """name or number"""
    image_type: Int = 0
    """0 scene, 1 depth planar, 2 depth perspective, 3 depth vis, 5 segmentation, 6 surface normals, 7 infrared"""
    pixels_as_float: Flag = False
    """whether as numbers, not bytes"""
    compress: Flag = False
    """whether as PNG"""


@dataclass(frozen=True, slots=True, eq=False)
class ImageResponse:
    """An image, row by row from its upper left."""

    image_data_uint8: Bytes = b""
    """PNG, or height x width x (blue, green, red)"""
    image_data_float: Singles = field(default_factory=no_numbers)
    """(height x width,)"""
    camera_position: Vector = field(default_factory=zero)
    """(3,) m"""
    camera_name: Text = ""
    """as it was asked for"""
    camera_orientation: Quaternion = field(default_factory=level)
    """(4,) xyzw"""
    time_stamp: Time = 0
    """ns"""
    message: Text = ""
    """what went wrong"""
    pixels_as_float: Flag = False
    """whether it came as numbers"""
    compress: Flag = True
    """whether it came as PNG"""
    width: Int = 0
    """pixels"""
    height: Int = 0
    """pixels"""
    image_type: Int = 0
    """as it was asked for"""


@dataclass(frozen=True, slots=True, eq=False)
class LidarData:
    """What a lidar saw."""

    time_stamp: Time = 0
    """ns"""
    point_cloud: Singles = field(default_factory=no_numbers)
    """(3 n,) m, x y z of each point that was hit"""
    pose: Pose = field(default_factory=Pose)
    """of the lidar"""
    segmentation: Ints = field(default_factory=lambda: np.empty(0, np.int32))
    """(n,) number of the object of each point"""


@dataclass(frozen=True, slots=True, eq=False)
class DistanceSensorData:
    """What a distance sensor measured."""

    time_stamp: Time = 0
    """ns"""
    distance: Single = 0.0
    """m"""
    min_distance: Single = 0.0
    """m"""
    max_distance: Single = 0.0
    """m"""
    relative_pose: Pose = field(default_factory=Pose)
    """of the sensor on the vehicle"""


@dataclass(frozen=True, slots=True, eq=False)
class ImuData:
    """What an inertial measurement unit measured."""

    time_stamp: Time = 0
    """ns"""
    orientation: Quaternion = field(default_factory=level)
    """(4,) xyzw"""
    angular_velocity: Vector = field(default_factory=zero)
    """(3,) rad/s, body"""
    linear_acceleration: Vector = field(default_factory=zero)
    """(3,) m/s², body, less gravity: (0, 0, -9.8) at rest"""


@dataclass(frozen=True, slots=True, eq=False)
class BarometerData:
    """What a barometer measured."""

    time_stamp: Time = 0
    """ns"""
    altitude: Single = 0.0
    """m"""
    pressure: Single = 0.0
    """Pa"""
    qnh: Single = 0.0
    """hPa, the pressure at sea level that altitude assumes"""


@dataclass(frozen=True, slots=True, eq=False)
class MagnetometerData:
    """What a magnetometer measured."""

    time_stamp: Time = 0
    """ns"""
    magnetic_field_body: Vector = field(default_factory=zero)
    """(3,) gauss"""
    magnetic_field_covariance: Singles = field(default_factory=no_numbers)
    """(9,) or empty"""


@dataclass(frozen=True, slots=True, eq=False)
class GnssReport:
    """A fix of a satellite receiver."""

    geo_point: GeoPoint = field(default_factory=GeoPoint)
    """where on earth"""
    eph: Single = 0.0
    """horizontal dilution"""
    epv: Single = 0.0
    """vertical dilution"""
    velocity: Vector = field(default_factory=zero)
    """(3,) m/s"""
    fix_type: Int = 0
    """0 none, 1 time only, 2 plane, 3 space"""
    time_utc: Time = 0
    """µs"""


@dataclass(frozen=True, slots=True, eq=False)
class GpsData:
    """What a satellite receiver says."""

    time_stamp: Time = 0
    """ns"""
    gnss: GnssReport = field(default_factory=GnssReport)
    """the last fix"""
    is_valid: Flag = False
    """whether there is one"""


@dataclass(frozen=True, slots=True, eq=False)
class ProjectionMatrix:
    """How a camera projects."""

    matrix: Projection = field(default_factory=lambda: np.zeros((4, 4), np.float32))
    """(4, 4)"""


@dataclass(frozen=True, slots=True, eq=False)
class CameraInfo:
    """Where a camera is, and what it sees."""

    pose: Pose = field(default_factory=Pose)
    """of the camera"""
    fov: Single = 0.0
    """deg, across"""
    proj_mat: ProjectionMatrix = field(default_factory=ProjectionMatrix)
    """how it projects"""


@dataclass(frozen=True, slots=True, eq=False)
class Box2D:
    """A box in an image."""

    min: Plane = field(default_factory=corner)
    """(2,) pixels"""
    max: Plane = field(default_factory=corner)
    """(2,) pixels"""


@dataclass(frozen=True, slots=True, eq=False)
class Box3D:
    """A box in space."""

    min: Vector = field(default_factory=zero)
    """(3,) m"""
    max: Vector = field(default_factory=zero)
    """(3,) m"""


@dataclass(frozen=True, slots=True, eq=False)
class DetectionInfo:
    """An object that a camera sees."""

    name: Text = ""
    """of the object"""
    geo_point: GeoPoint = field(default_factory=GeoPoint)
    """where on earth"""
    box2D: Box2D = field(default_factory=Box2D)  # noqa: N815 - the key on the wire
    """in the image"""
    box3D: Box3D = field(default_factory=Box3D)  # noqa: N815 - the key on the wire
    """in space"""
    relative_pose: Pose = field(default_factory=Pose)
    """of the object as the camera sees it"""


@dataclass(frozen=True, slots=True, eq=False)
class MeshPositionVertexBuffersResponse:
    """The mesh of an object."""

    position: Vector = field(default_factory=zero)
    """(3,) m"""
    orientation: Quaternion = field(default_factory=level)
    """(4,) xyzw"""
    vertices: Singles = field(default_factory=no_numbers)
    """(3 n,) m, x y z of each"""
    indices: UInts = field(default_factory=lambda: np.empty(0, np.uint32))
    """(3 m,) vertices of each triangle"""
    name: Text = ""
    """of the object"""
