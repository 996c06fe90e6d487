"""Every method of the protocol: what it takes, in which order, and what it answers.

AirSim's methods, the three that Colosseum adds, and the arguments that Cosys-AirSim leaves out of AirSim's, or adds.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from crosstrack.airsim.arrays import SINGLES, VECTOR, VECTORS
from crosstrack.airsim.codec import (
    BINARY,
    DOUBLE,
    FLAG,
    INT32,
    NOTHING,
    SINGLE,
    TEXT,
    TEXTS,
    UINT8,
    UINT32,
    BadCast,
    Codec,
    Flag,
    Listed,
    record,
)
from crosstrack.airsim.structs import (
    BarometerData,
    CameraInfo,
    CollisionInfo,
    DetectionInfo,
    DistanceSensorData,
    EnvironmentState,
    GeoPoint,
    GpsData,
    ImageRequest,
    ImageResponse,
    ImuData,
    KinematicsState,
    LidarData,
    MagnetometerData,
    MeshPositionVertexBuffersResponse,
    MultirotorState,
    Pose,
    RCData,
    RotorStates,
    YawMode,
)


class External(Flag):
    """Whether a camera belongs to no vehicle; Cosys-AirSim has the name of an annotation layer in its place."""

    def unpack(self, wire: object) -> bool:
        """Return the bool, false for a name."""
        return False if type(wire) is str else super().unpack(wire)


class Ned(Flag):
    """Whether Cosys-AirSim is to answer in north, east and down: only that is to be had."""

    def unpack(self, wire: object) -> bool:
        """Return true."""
        if super().unpack(wire):
            return True
        raise BadCast("poses are north, east and down only")


class WrongArity(Exception):  # noqa: N818 - not of the server's making
    """A call with too few arguments, or too many."""


@dataclass(frozen=True, slots=True)
class Method:
    """What a method takes and answers."""

    result: Codec
    """of what it answers"""
    parameters: dict[str, Codec]
    """of its arguments by AirSim's names, in order"""
    cosys: dict[str, Codec] | None = None
    """those of Cosys-AirSim, where they are others"""
    forms: dict[int, tuple[Codec, ...]] = field(init=False)
    """codecs of the arguments by how many there are"""

    def __post_init__(self) -> None:
        known = [self.parameters] if self.cosys is None else [self.cosys, self.parameters]
        object.__setattr__(self, "forms", {len(form): tuple(form.values()) for form in known})

    def unpack(self, arguments: Sequence[object]) -> list[Any]:
        """Return the arguments of a call, in AirSim's order and number.

        Raises:
            WrongArity: no dialect has so many.
            BadCast: one is of the wrong type.
        """
        codecs = self.forms.get(len(arguments))
        if codecs is None:
            raise WrongArity
        values = [codec.unpack(wire) for codec, wire in zip(codecs, arguments, strict=True)]
        wanted = len(self.parameters)
        return values if len(values) == wanted else (values + [False])[:wanted]

    def arranged(self, arguments: Sequence[Any], cosys: bool) -> list[tuple[str, Codec, Any]]:
        """Return names, codecs and values of the arguments of a call, as AirSim or Cosys-AirSim wants them."""
        values = COSYS_ONLY | dict(zip(self.parameters, arguments, strict=True))
        form = self.cosys if cosys and self.cosys is not None else self.parameters
        return [(name, codec, values[name]) for name, codec in form.items()]


def method(result: Codec, /, **parameters: Codec) -> Method:
    """Return a method of the same parameters everywhere."""
    return Method(result, parameters)


def of_vehicle(result: Codec, /, **parameters: Codec) -> Method:
    """Return a method whose last parameter is a vehicle."""
    return Method(result, parameters | {"vehicle_name": TEXT})


def of_camera(result: Codec, /, **parameters: Codec) -> Method:
    """Return a method of a camera, which Cosys-AirSim never looks for outside the vehicles."""
    of_both = parameters | {"vehicle_name": TEXT}
    return Method(result, of_both | {"external": EXTERNAL}, of_both)


def of_image(result: Codec, /, **parameters: Codec) -> Method:
    """Return a method of a kind of image."""
    image: dict[str, Codec] = {"camera_name": TEXT, "image_type": INT32}
    of_both = image | parameters | {"vehicle_name": TEXT}
    return Method(result, of_both | {"external": EXTERNAL}, of_both | {"annotation_name": TEXT})


def of_gains() -> Method:
    """Return a method that sets the gains of three axes."""
    return of_vehicle(NOTHING, kp=SINGLES, ki=SINGLES, kd=SINGLES)


EXTERNAL = External()
COSYS_ONLY: dict[str, Any] = {"annotation_name": "", "ned": True}
"""what Cosys-AirSim is told where it asks for more than AirSim"""
POSE, GEO_POINT, YAW_MODE = record(Pose), record(GeoPoint), record(YawMode)
KINEMATICS = record(KinematicsState)
STEERED: dict[str, Codec] = {"drivetrain": INT32, "yaw_mode": YAW_MODE}
CHASED: dict[str, Codec] = {"lookahead": SINGLE, "adaptive_lookahead": SINGLE}
PLOTTED: dict[str, Codec] = {"duration": SINGLE, "is_persistent": FLAG}

METHODS: dict[str, Method] = {
    # the server, its clock and its world
    "ping": method(FLAG),
    "getServerVersion": method(INT32),
    "getMinRequiredClientVersion": method(INT32),
    "reset": method(NOTHING),
    "simPause": method(NOTHING, is_paused=FLAG),
    "simIsPaused": method(FLAG),
    "simContinueForTime": method(NOTHING, seconds=DOUBLE),
    "simContinueForFrames": method(NOTHING, frames=UINT32),
    "simSetTimeOfDay": method(
        NOTHING,
        is_enabled=FLAG,
        start_datetime=TEXT,
        is_start_datetime_dst=FLAG,
        celestial_clock_speed=SINGLE,
        update_interval_secs=SINGLE,
        move_sun=FLAG,
    ),
    "simEnableWeather": method(NOTHING, enable=FLAG),
    "simSetWeatherParameter": method(NOTHING, param=INT32, val=SINGLE),
    "simSetWind": method(NOTHING, wind=VECTOR),
    "simSetExtForce": method(NOTHING, ext_force=VECTOR),
    "simRunConsoleCommand": method(FLAG, command=TEXT),
    "simPrintLogMessage": method(NOTHING, message=TEXT, message_param=TEXT, severity=UINT8),
    "getSettingsString": method(TEXT),
    "startRecording": method(NOTHING),
    "stopRecording": method(NOTHING),
    "isRecording": method(FLAG),
    # vehicles
    "listVehicles": method(TEXTS),
    "simAddVehicle": method(FLAG, vehicle_name=TEXT, vehicle_type=TEXT, pose=POSE, pawn_path=TEXT),
    "enableApiControl": of_vehicle(NOTHING, is_enabled=FLAG),
    "isApiControlEnabled": of_vehicle(FLAG),
    "armDisarm": of_vehicle(FLAG, arm=FLAG),
    "cancelLastTask": of_vehicle(NOTHING),
    "getHomeGeoPoint": of_vehicle(GEO_POINT),
    "getMultirotorState": of_vehicle(record(MultirotorState)),
    "getRotorStates": of_vehicle(record(RotorStates)),
    "simGetCollisionInfo": of_vehicle(record(CollisionInfo)),
    "simGetVehiclePose": of_vehicle(POSE),
    "simSetVehiclePose": of_vehicle(NOTHING, pose=POSE, ignore_collision=FLAG),
    "simGetGroundTruthKinematics": of_vehicle(KINEMATICS),
    "simSetKinematics": of_vehicle(NOTHING, state=KINEMATICS, ignore_collision=FLAG),
    "simGetGroundTruthEnvironment": of_vehicle(record(EnvironmentState)),
    "simSetTraceLine": of_vehicle(NOTHING, color_rgba=SINGLES, thickness=SINGLE),
    # moves
    "takeoff": of_vehicle(FLAG, timeout_sec=SINGLE),
    "land": of_vehicle(FLAG, timeout_sec=SINGLE),
    "goHome": of_vehicle(FLAG, timeout_sec=SINGLE),
    "hover": of_vehicle(FLAG),
    "moveByVelocity": of_vehicle(FLAG, vx=SINGLE, vy=SINGLE, vz=SINGLE, duration=SINGLE, **STEERED),
    "moveByVelocityZ": of_vehicle(FLAG, vx=SINGLE, vy=SINGLE, z=SINGLE, duration=SINGLE, **STEERED),
    "moveByVelocityBodyFrame": of_vehicle(FLAG, vx=SINGLE, vy=SINGLE, vz=SINGLE, duration=SINGLE, **STEERED),
    "moveByVelocityZBodyFrame": of_vehicle(FLAG, vx=SINGLE, vy=SINGLE, z=SINGLE, duration=SINGLE, **STEERED),
    "moveByManual": of_vehicle(FLAG, vx_max=SINGLE, vy_max=SINGLE, z_min=SINGLE, duration=SINGLE, **STEERED),
    "moveOnPath": of_vehicle(FLAG, path=VECTORS, velocity=SINGLE, timeout_sec=SINGLE, **STEERED, **CHASED),
    "moveToPosition": of_vehicle(
        FLAG, x=SINGLE, y=SINGLE, z=SINGLE, velocity=SINGLE, timeout_sec=SINGLE, **STEERED, **CHASED
    ),
    "moveToGPS": of_vehicle(
        FLAG,
        latitude=SINGLE,
        longitude=SINGLE,
        altitude=SINGLE,
        velocity=SINGLE,
        timeout_sec=SINGLE,
        **STEERED,
        **CHASED,
    ),
    "moveToZ": of_vehicle(FLAG, z=SINGLE, velocity=SINGLE, timeout_sec=SINGLE, yaw_mode=YAW_MODE, **CHASED),
    "rotateToYaw": of_vehicle(FLAG, yaw=SINGLE, timeout_sec=SINGLE, margin=SINGLE),
    "rotateByYawRate": of_vehicle(FLAG, yaw_rate=SINGLE, duration=SINGLE),
    "moveByMotorPWMs": of_vehicle(
        FLAG,
        front_right_pwm=SINGLE,
        rear_left_pwm=SINGLE,
        front_left_pwm=SINGLE,
        rear_right_pwm=SINGLE,
        duration=SINGLE,
    ),
    "moveByRollPitchYawZ": of_vehicle(FLAG, roll=SINGLE, pitch=SINGLE, yaw=SINGLE, z=SINGLE, duration=SINGLE),
    "moveByRollPitchYawThrottle": of_vehicle(
        FLAG, roll=SINGLE, pitch=SINGLE, yaw=SINGLE, throttle=SINGLE, duration=SINGLE
    ),
    "moveByRollPitchYawrateThrottle": of_vehicle(
        FLAG, roll=SINGLE, pitch=SINGLE, yaw_rate=SINGLE, throttle=SINGLE, duration=SINGLE
    ),
    "moveByRollPitchYawrateZ": of_vehicle(FLAG, roll=SINGLE, pitch=SINGLE, yaw_rate=SINGLE, z=SINGLE, duration=SINGLE),
    "moveByAngleRatesZ": of_vehicle(
        FLAG, roll_rate=SINGLE, pitch_rate=SINGLE, yaw_rate=SINGLE, z=SINGLE, duration=SINGLE
    ),
    "moveByAngleRatesThrottle": of_vehicle(
        FLAG, roll_rate=SINGLE, pitch_rate=SINGLE, yaw_rate=SINGLE, throttle=SINGLE, duration=SINGLE
    ),
    "moveByRC": of_vehicle(NOTHING, rcdata=record(RCData)),
    "setAngleLevelControllerGains": of_gains(),
    "setAngleRateControllerGains": of_gains(),
    "setVelocityControllerGains": of_gains(),
    "setPositionControllerGains": of_gains(),
    "setSafety": of_vehicle(
        FLAG,
        enable_reasons=UINT32,
        obs_clearance=SINGLE,
        obs_strategy=INT32,
        obs_avoidance_vel=SINGLE,
        origin=VECTOR,
        xy_length=SINGLE,
        max_z=SINGLE,
        min_z=SINGLE,
    ),
    # sensors
    "getLidarData": of_vehicle(record(LidarData), lidar_name=TEXT),
    "getImuData": of_vehicle(record(ImuData), imu_name=TEXT),
    "getBarometerData": of_vehicle(record(BarometerData), barometer_name=TEXT),
    "getMagnetometerData": of_vehicle(record(MagnetometerData), magnetometer_name=TEXT),
    "getGpsData": of_vehicle(record(GpsData), gps_name=TEXT),
    "getDistanceSensorData": of_vehicle(record(DistanceSensorData), distance_sensor_name=TEXT),
    "simTestLineOfSightToPoint": of_vehicle(FLAG, point=GEO_POINT),
    "simTestLineOfSightBetweenPoints": method(FLAG, point1=GEO_POINT, point2=GEO_POINT),
    # images and cameras
    "simGetImages": of_camera(Listed(record(ImageResponse)), requests=Listed(record(ImageRequest))),
    "simGetImage": of_image(BINARY),
    "simGetCameraInfo": of_camera(record(CameraInfo), camera_name=TEXT),
    "simSetCameraPose": of_camera(NOTHING, camera_name=TEXT, pose=POSE),
    "simSetCameraFov": of_camera(NOTHING, camera_name=TEXT, fov_degrees=SINGLE),
    "simGetDistortionParams": of_camera(SINGLES, camera_name=TEXT),
    "simSetDistortionParam": of_camera(NOTHING, camera_name=TEXT, param_name=TEXT, value=SINGLE),
    "simAddDetectionFilterMeshName": of_image(NOTHING, mesh_name=TEXT),
    "simSetDetectionFilterRadius": of_image(NOTHING, radius_cm=SINGLE),
    "simClearDetectionMeshNames": of_image(NOTHING),
    "simGetDetections": of_image(Listed(record(DetectionInfo))),
    "simGetPresetLensSettings": of_camera(TEXTS, camera_name=TEXT),
    "simGetLensSettings": of_camera(TEXT, camera_name=TEXT),
    "simSetPresetLensSettings": of_camera(NOTHING, preset_lens_settings=TEXT, camera_name=TEXT),
    "simGetPresetFilmbackSettings": of_camera(TEXTS, camera_name=TEXT),
    "simSetPresetFilmbackSettings": of_camera(NOTHING, preset_filmback_settings=TEXT, camera_name=TEXT),
    "simGetFilmbackSettings": of_camera(TEXT, camera_name=TEXT),
    "simSetFilmbackSettings": of_camera(SINGLE, sensor_width=SINGLE, sensor_height=SINGLE, camera_name=TEXT),
    "simGetFocalLength": of_camera(SINGLE, camera_name=TEXT),
    "simSetFocalLength": of_camera(NOTHING, focal_length=SINGLE, camera_name=TEXT),
    "simEnableManualFocus": of_camera(NOTHING, enable=FLAG, camera_name=TEXT),
    "simGetFocusDistance": of_camera(SINGLE, camera_name=TEXT),
    "simSetFocusDistance": of_camera(NOTHING, focus_distance=SINGLE, camera_name=TEXT),
    "simGetFocusAperture": of_camera(SINGLE, camera_name=TEXT),
    "simSetFocusAperture": of_camera(NOTHING, focus_aperture=SINGLE, camera_name=TEXT),
    "simEnableFocusPlane": of_camera(NOTHING, enable=FLAG, camera_name=TEXT),
    "simGetCurrentFieldOfView": of_camera(TEXT, camera_name=TEXT),
    # objects
    "simListSceneObjects": method(TEXTS, name_regex=TEXT),
    "simListSceneObjectsByTag": method(TEXTS, tag_regex=TEXT),
    "simListAssets": method(TEXTS),
    "simLoadLevel": method(FLAG, level_name=TEXT),
    "simSpawnObject": method(
        TEXT, object_name=TEXT, asset_name=TEXT, pose=POSE, scale=VECTOR, physics_enabled=FLAG, is_blueprint=FLAG
    ),
    "simDestroyObject": method(FLAG, object_name=TEXT),
    "simGetObjectPose": Method(POSE, {"object_name": TEXT}, {"object_name": TEXT, "ned": Ned()}),
    "simSetObjectPose": method(FLAG, object_name=TEXT, pose=POSE, teleport=FLAG),
    "simGetObjectScale": method(VECTOR, object_name=TEXT),
    "simSetObjectScale": method(FLAG, object_name=TEXT, scale=VECTOR),
    "simFindLookAtRotation": method(VECTOR, vehicle_name=TEXT, object_name=TEXT),
    "simSetSegmentationObjectID": method(FLAG, mesh_name=TEXT, object_id=INT32, is_name_regex=FLAG),
    "simGetSegmentationObjectID": method(INT32, mesh_name=TEXT),
    "simGetMeshPositionVertexBuffers": method(Listed(record(MeshPositionVertexBuffersResponse))),
    "simGetWorldExtents": method(Listed(GEO_POINT)),
    "simCreateVoxelGrid": method(FLAG, position=VECTOR, x=INT32, y=INT32, z=INT32, res=SINGLE, output_file=TEXT),
    "simSetLightIntensity": method(FLAG, light_name=TEXT, intensity=SINGLE),
    "simSwapTextures": method(TEXTS, tags=TEXT, tex_id=INT32, component_id=INT32, material_id=INT32),
    "simSetObjectMaterial": method(FLAG, object_name=TEXT, material_name=TEXT, component_id=INT32),
    "simSetObjectMaterialFromTexture": method(FLAG, object_name=TEXT, texture_path=TEXT, component_id=INT32),
    # markers
    "simFlushPersistentMarkers": method(NOTHING),
    "simPlotPoints": method(NOTHING, points=VECTORS, color_rgba=SINGLES, size=SINGLE, **PLOTTED),
    "simPlotLineStrip": method(NOTHING, points=VECTORS, color_rgba=SINGLES, thickness=SINGLE, **PLOTTED),
    "simPlotLineList": method(NOTHING, points=VECTORS, color_rgba=SINGLES, thickness=SINGLE, **PLOTTED),
    "simPlotArrows": method(
        NOTHING,
        points_start=VECTORS,
        points_end=VECTORS,
        color_rgba=SINGLES,
        thickness=SINGLE,
        arrow_size=SINGLE,
        **PLOTTED,
    ),
    "simPlotStrings": method(
        NOTHING, strings=TEXTS, positions=VECTORS, scale=SINGLE, color_rgba=SINGLES, duration=SINGLE
    ),
    "simPlotTransforms": method(NOTHING, poses=Listed(POSE), scale=SINGLE, thickness=SINGLE, **PLOTTED),
    "simPlotTransformsWithNames": method(
        NOTHING,
        poses=Listed(POSE),
        names=TEXTS,
        tf_scale=SINGLE,
        tf_thickness=SINGLE,
        text_scale=SINGLE,
        text_color_rgba=SINGLES,
        duration=SINGLE,
    ),
}
