"""settings.json: AirSim's defaults, its comments, and every problem at once."""

import json
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.airsim.scene.poses import matrix
from crosstrack.airsim.scene.sensors.lidar import LidarSettings
from crosstrack.airsim.server.settings import Settings, parse, read, uncommented
from crosstrack.errors import InputError

FULL = """
// what AirSim's documentation has
{
  "SeeDocsAt": "https://github.com/Microsoft/AirSim/blob/main/docs/settings.md", /* not a // comment */
  "SettingsVersion": 1.2,
  "SimMode": "Multirotor",
  "ClockSpeed": 2.5,
  "LocalHostIp": "0.0.0.0",
  "ApiServerPort": 41452,
  "OriginGeopoint": {"Latitude": 10, "Longitude": -20.5, "Altitude": 3},
  "Wind": {"X": 4},
  "CameraDefaults": {"CaptureSettings": [{"ImageType": 0, "Width": 640, "Height": 480, "FOV_Degrees": 60}]},
  "Recording": {"RecordInterval": 0.5, "Cameras": [{"CameraName": "low", "ImageType": 1, "PixelsAsFloat": true}]},
  "SubWindows": [{"WindowID": 0, "CameraName": "0", "ImageType": 3, "Visible": true}],
  "Vehicles": {
    "Two": {"VehicleType": "simpleflight", "AutoCreate": false},
    "One": {
      "VehicleType": "SimpleFlight",
      "X": 4, "Y": -2, "Z": -1, "Yaw": 90,
      "Cameras": {"low": {"X": 0.1, "Pitch": -45, "CaptureSettings": [{"ImageType": 1, "Width": 32, "Height": 24}]}},
      "Sensors": {
        "Barometer": {"SensorType": 1, "Enabled": false},
        "Lidar1": {"SensorType": 6, "Enabled": true, "NumberOfChannels": 4, "VerticalFOVLower": -3, "X": 0.5,
                   "DataFrame": "SensorLocalFrame", "DrawDebugPoints": true}
      }
    }
  }
}
"""


def problems(text: str) -> dict[str, str]:
    """Return what is wrong with a text, by place."""
    with pytest.raises(InputError) as caught:
        parse(text)
    return {one.place: one.message for one in caught.value.problems}


def test_defaults_are_those_of_airsim() -> None:
    made = parse("{}")
    assert list(made.fleet()) == ["SimpleFlight"]
    assert (made.api_server_port, made.clock_speed, made.address) == (41451, 1.0, "127.0.0.1")
    assert (made.origin.latitude, made.origin.longitude, made.origin.altitude) == (47.641468, -122.140165, 122.0)
    start = made.fleet()["SimpleFlight"].start
    assert start.position.tolist() == [0, 0, 0]
    sensors = made.sensors(made.fleet()["SimpleFlight"])
    assert {one.sensor_type for one in sensors.values()} == {1, 2, 3, 4}
    assert all(one.enabled for one in sensors.values())
    lidar = LidarSettings(sensor_type=6)
    assert (lidar.number_of_channels, lidar.points_per_second, lidar.range) == (16, 100_000, 100.0)
    assert (lidar.vertical_fov_upper, lidar.vertical_fov_lower, lidar.horizontal_fov_end) == (-15, -45, 359)
    assert lidar.data_frame == "VehicleInertialFrame"


def test_a_full_file(tmp_path: Path) -> None:
    path = tmp_path / "settings.json"
    path.write_text(FULL, encoding="utf-8-sig")
    made = read(path)
    assert made.text == FULL
    assert (made.clock_speed, made.address, made.api_server_port) == (2.5, "0.0.0.0", 41452)
    assert (made.origin.latitude, made.origin.longitude, made.origin.altitude) == (10, -20.5, 3)
    assert (made.wind.x, made.wind.y) == (4, 0)
    assert list(made.fleet()) == ["One"]
    one = made.fleet()["One"]
    np.testing.assert_allclose(one.start.position, [4, -2, -1])
    np.testing.assert_allclose(matrix(one.start.orientation) @ [1, 0, 0], [0, 1, 0], atol=1e-12)
    sensors = made.sensors(one)
    assert sorted(sensors) == ["Barometer", "Lidar1", "gps", "imu", "magnetometer"]
    lidar = sensors["Lidar1"]
    assert isinstance(lidar, LidarSettings)
    assert (lidar.number_of_channels, lidar.vertical_fov_lower, lidar.x) == (4, -3, 0.5)
    low = one.cameras["low"]
    assert (low.captures[1].width, low.captures[0].width, low.captures[0].fov_degrees) == (32, 640, 60)
    assert low.pitch == -45
    recorded = made.recording.cameras
    assert recorded is not None
    assert (recorded[0].name, recorded[0].image_type, made.recording.record_interval) == ("low", 1, 0.5)


def test_every_problem_is_told_at_once() -> None:
    found = problems(
        """{"ClockSpeed": "fast", "ApiServerPort": 0, "OriginGeopoint": {"Latitude": 100}, "SimMode": "Car",
        "Recording": {"Cameras": [{}, {"ImageType": 99}]},
        "Vehicles": {
            "A": {"VehicleType": "PX4Multirotor"},
            "B": {"VehicleType": "SimpleFlight", "X": "1",
                  "Cameras": {"c": {"CaptureSettings": [{}, {"Width": 0, "ImageType": 3}]}},
                  "Sensors": {"L": {"SensorType": 6, "Range": -1, "DataFrame": "Body"},
                              "M": {"SensorType": 9}, "N": {}}},
            "C": {}}}"""
    )
    assert set(found) == {
        "ClockSpeed",
        "ApiServerPort",
        "OriginGeopoint.Latitude",
        "SimMode",
        "Recording.Cameras[1].ImageType",
        "Vehicles.A.VehicleType",
        "Vehicles.B.X",
        "Vehicles.B.Cameras.c.CaptureSettings[1].Width",
        "Vehicles.B.Sensors.L.Range",
        "Vehicles.B.Sensors.L.DataFrame",
        "Vehicles.B.Sensors.M",
        "Vehicles.B.Sensors.N",
        "Vehicles.C.VehicleType",
    }
    assert '"fast"' in found["ClockSpeed"]
    assert "1 to 6" in found["Vehicles.B.Sensors.M"]
    assert "SimpleFlight" in found["Vehicles.A.VehicleType"]


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "3", '{"Wind": {"X": NaN}}', '{"Vehicles": 3}', '{"Vehicles": {"A": 1}}']
)
def test_what_is_no_settings(text: str) -> None:
    assert problems(text)


def test_the_line_of_a_mistake() -> None:
    with pytest.raises(InputError, match="line 3"):
        parse('// one\n{ /* two\n*/ "a" 1}')


def test_deep_nesting_is_refused() -> None:
    assert problems("[" * 100_000)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read(tmp_path / "none.json")
    with pytest.raises(InputError, match="cannot be read"):
        read(tmp_path)


@given(st.dictionaries(st.text(), st.one_of(st.text(), st.integers(), st.lists(st.text()))))
def test_texts_keep_what_looks_like_a_comment(value: dict[str, object]) -> None:
    text = json.dumps(value, indent=1)
    assert json.loads(uncommented(text)) == value
    assert json.loads(uncommented(text.replace(",\n", ", // a comment\n/* b */"))) == value


@given(
    st.recursive(
        st.one_of(st.none(), st.booleans(), st.integers(), st.floats(allow_nan=False), st.text()),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(
                    [
                        "Vehicles",
                        "A",
                        "Sensors",
                        "Cameras",
                        "CaptureSettings",
                        "ImageType",
                        "X",
                        "SensorType",
                        "CameraDefaults",
                        "ExternalCameras",
                        "Recording",
                        "Wind",
                        "DefaultSensors",
                        "VehicleType",
                    ]
                ),
                inner,
                max_size=4,
            )
        ),
        max_leaves=12,
    )
)
def test_any_json_is_read_or_refused(value: object) -> None:
    with suppress(InputError):
        made = parse(json.dumps(value))
        assert isinstance(made, Settings)
        assert all(isinstance(one.start.position, np.ndarray) for one in made.fleet().values())
