"""The table of methods against what AirSim, Colosseum and Cosys-AirSim bind."""

import msgpack
import pytest

from crosstrack.airsim.client import calls
from crosstrack.airsim.client.call import Call
from crosstrack.airsim.codec import BadCast
from crosstrack.airsim.methods import METHODS, WrongArity

ARITY = """
ping:0 getServerVersion:0 getMinRequiredClientVersion:0 simPause:1 simIsPaused:0 simContinueForTime:1
simContinueForFrames:1 simSetTimeOfDay:6 simEnableWeather:1 simSetWeatherParameter:2 enableApiControl:2
isApiControlEnabled:1 armDisarm:2 simRunConsoleCommand:1 simGetImages:3 simGetImage:4 simGetPresetLensSettings:3
simGetLensSettings:3 simGetPresetFilmbackSettings:3 simGetFilmbackSettings:3 simGetFocalLength:3 simGetFocusDistance:3
simGetFocusAperture:3 simGetCurrentFieldOfView:3 simSetPresetLensSettings:4 simSetPresetFilmbackSettings:4
simSetFilmbackSettings:5 simSetFocalLength:4 simSetFocusDistance:4 simSetFocusAperture:4 simEnableManualFocus:4
simEnableFocusPlane:4 simTestLineOfSightToPoint:2 simTestLineOfSightBetweenPoints:2 simGetWorldExtents:0
simGetMeshPositionVertexBuffers:0 simAddVehicle:4 simSetVehiclePose:3 simGetVehiclePose:1 simSetTraceLine:3
simSetSegmentationObjectID:3 simGetSegmentationObjectID:1 simAddDetectionFilterMeshName:5
simSetDetectionFilterRadius:5 simClearDetectionMeshNames:4 simGetDetections:4 reset:0 simPrintLogMessage:3
getHomeGeoPoint:1 getLidarData:2 getImuData:2 getBarometerData:2 getMagnetometerData:2 getGpsData:2
getDistanceSensorData:2 simGetCameraInfo:3 simSetDistortionParam:5 simGetDistortionParams:3 simSetCameraPose:4
simSetCameraFov:4 simGetCollisionInfo:1 simListSceneObjects:1 simLoadLevel:1 simSpawnObject:6 simDestroyObject:1
simListAssets:0 simGetObjectPose:1 simGetObjectScale:1 simSetObjectPose:3 simSetObjectScale:2
simFlushPersistentMarkers:0 simPlotPoints:5 simPlotLineStrip:5 simPlotLineList:5 simPlotArrows:7 simPlotStrings:5
simPlotTransforms:5 simPlotTransformsWithNames:7 simGetGroundTruthKinematics:1 simSetKinematics:3
simGetGroundTruthEnvironment:1 simCreateVoxelGrid:6 simSetLightIntensity:2 simSwapTextures:4 simSetObjectMaterial:3
simSetObjectMaterialFromTexture:3 cancelLastTask:1 startRecording:0 stopRecording:0 isRecording:0 simSetWind:1
listVehicles:0 getSettingsString:0 takeoff:2 land:2 goHome:2 moveByVelocityBodyFrame:7 moveByVelocityZBodyFrame:7
moveByVelocity:7 moveByVelocityZ:7 moveByMotorPWMs:6 moveByRollPitchYawZ:6 moveByRollPitchYawThrottle:6
moveByRollPitchYawrateThrottle:6 moveByRollPitchYawrateZ:6 moveByAngleRatesZ:6 moveByAngleRatesThrottle:6 moveOnPath:8
moveToPosition:10 moveToGPS:10 moveToZ:7 moveByManual:7 rotateToYaw:4 rotateByYawRate:3 hover:1 moveByRC:2
setAngleLevelControllerGains:4 setAngleRateControllerGains:4 setVelocityControllerGains:4 setPositionControllerGains:4
setSafety:9 getRotorStates:1 getMultirotorState:1
"""
"""parameters of what AirSim binds"""
COLOSSEUM = {"simFindLookAtRotation": 2, "simListSceneObjectsByTag": 1, "simSetExtForce": 1}
COSYS = {
    **dict.fromkeys(("simGetImages", "simGetCameraInfo", "simGetDistortionParams"), 2),
    **{f"simGet{what}": 2 for what in ("LensSettings", "PresetLensSettings", "FilmbackSettings", "FocalLength")},
    **{f"simGet{what}": 2 for what in ("PresetFilmbackSettings", "FocusDistance", "FocusAperture")},
    **{f"simSet{what}": 3 for what in ("PresetLensSettings", "PresetFilmbackSettings", "FocalLength", "FocusDistance")},
    **dict.fromkeys(("simSetFocusAperture", "simEnableManualFocus", "simEnableFocusPlane"), 3),
    **dict.fromkeys(("simSetCameraPose", "simSetCameraFov"), 3),
    "simGetCurrentFieldOfView": 2,
    "simSetFilmbackSettings": 4,
    "simSetDistortionParam": 4,
    "simGetObjectPose": 2,
}


def test_all_methods_take_as_many_arguments_as_airsim_binds() -> None:
    bound = {name: int(count) for name, count in (pair.split(":") for pair in ARITY.split())}
    assert len(bound) == 123
    assert {name: len(method.parameters) for name, method in METHODS.items()} == bound | COLOSSEUM


def test_cosys_airsim_leaves_out_what_it_does_not_know() -> None:
    others = {name: [n for n in method.forms if n != len(method.parameters)] for name, method in METHODS.items()}
    assert {name: counts[0] for name, counts in others.items() if counts} == COSYS
    assert max(map(len, others.values())) == 1


def test_arguments_arrive_in_the_order_of_airsim_whatever_the_dialect() -> None:
    method = METHODS["simGetCameraInfo"]
    assert method.unpack(["0", "Drone", True]) == ["0", "Drone", True]
    assert method.unpack(["0", "Drone"]) == ["0", "Drone", False]
    assert METHODS["simGetImage"].unpack(["0", 1, "", "layer"]) == ["0", 1, "", False]
    assert METHODS["simGetObjectPose"].unpack(["box", True]) == ["box"]
    with pytest.raises(BadCast):
        METHODS["simGetObjectPose"].unpack(["box", False])
    with pytest.raises(WrongArity):
        method.unpack(["0"])
    request = {"camera_name": "0", "image_type": 0, "pixels_as_float": False, "compress": True, "annotation_name": ""}
    (images, vehicle, external) = METHODS["simGetImages"].unpack([[request], ""])
    assert (images[0].camera_name, images[0].compress, vehicle, external) == ("0", True, "", False)


def test_a_client_speaks_the_dialect_of_its_server() -> None:
    def sent(call: Call[object], cosys: bool) -> list[object]:
        return [msgpack.unpackb(packed) for packed in call.pack(cosys)]

    image = Call[object]("simGetImage", "0", 1, "Drone", False)
    assert sent(image, cosys=False) == ["0", 1, "Drone", False]
    assert sent(image, cosys=True) == ["0", 1, "Drone", ""]
    info = Call[object]("simGetCameraInfo", "0", "Drone", False)
    assert (sent(info, cosys=False), sent(info, cosys=True)) == (["0", "Drone", False], ["0", "Drone"])
    pose = Call[object]("simGetObjectPose", "box")
    assert (sent(pose, cosys=False), sent(pose, cosys=True)) == (["box"], ["box", True])


def test_every_method_can_be_called_from_the_client() -> None:
    called = {
        make.__code__.co_consts[1]
        for part in calls.Calls.__mro__
        for name, value in vars(part).items()
        if not name.startswith("_") and (make := getattr(value, "make", None)) is not None
    }
    assert called == set(METHODS)
