"""Calls that record: a table of where vehicles were, and pictures, in a folder for each recording."""

import logging
import time
from pathlib import Path
from typing import TextIO

import numpy as np

from crosstrack.airsim.scene.markers import Trace
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers.aboard import equipment, settings_of
from crosstrack.airsim.server.handlers.cameras import find
from crosstrack.airsim.server.handlers.images import pictures
from crosstrack.airsim.server.settings import RecordedCamera
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import ImageRequest, ImageResponse, Pose
from crosstrack.errors import InputError, Problem

log = logging.getLogger(__name__)
COLUMNS = ("VehicleName", "TimeStamp", "POS_X", "POS_Y", "POS_Z", "Q_W", "Q_X", "Q_Y", "Q_Z", "ImageFile")
TABLE, PICTURES = "airsim_rec.txt", "images"
DEFAULT_FOLDER = "recordings"
TRACE_COLOR, TRACE_THICKNESS = (0.216, 0.007, 0.565, 1.0), 3.0
"""of vehicles whose way is drawn from the start on"""


def folder(simulator: Simulator) -> Path:
    """Return the folder of all recordings."""
    return Path(settings_of(simulator).recording.folder or DEFAULT_FOLDER).expanduser().resolve()


def folders(simulator: Simulator) -> tuple[Path, ...]:
    """Return the folders in which clients may have files written: the working folder first."""
    return Path.cwd(), folder(simulator)


class Recorder:
    """A recording under way; it looks at the vehicles after every batch of steps."""

    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator
        self.settings = settings_of(simulator).recording
        for name in simulator.vehicles:
            for one in self.requests(name):
                find(simulator, one.camera_name, name, external=False)
        self.interval = round(self.settings.record_interval * 1e9)
        self.folder = fresh(folder(simulator) / time.strftime("%Y-%m-%d-%H-%M-%S"))
        (self.folder / PICTURES).mkdir()
        self.table: TextIO = (self.folder / TABLE).open("w", encoding="utf-8", newline="\n")
        self.table.write("\t".join(COLUMNS) + "\n")
        self.last: int | None = None
        self.poses: dict[str, Pose] = {}

    def close(self) -> None:
        """End the recording."""
        self.table.close()

    def observe(self) -> None:
        """Record all vehicles where it is time to."""
        now = self.simulator.now
        if self.last is not None and now - self.last <= self.interval:
            return
        self.last = now
        try:
            for name in self.simulator.vehicles:
                self.record(name)
            self.table.flush()
        except (OSError, Refused, ValueError) as error:
            log.warning("the recording ends: %s", error)
            stop(self.simulator)

    def record(self, name: str) -> None:
        """Write a line and the pictures of a vehicle, unless it stands still and that is not wanted."""
        state, before = self.simulator.vehicles[name].kinematics(), self.poses.get(name)
        pose = Pose(state.position, state.orientation)
        if self.settings.record_on_move and before is not None and same(before, pose):
            return
        self.poses[name] = pose
        x, y, z, w = state.orientation
        numbers = "\t".join(f"{part:g}" for part in (*state.position, w, x, y, z))
        files = ";".join(self.save(name, one) for one in pictures(self.simulator, self.requests(name), name, False))
        self.table.write(f"{name}\t{self.simulator.now // 1_000_000}\t{numbers}\t{files}\n")

    def requests(self, name: str) -> list[ImageRequest]:
        """Return the pictures to take of a vehicle."""
        cameras = self.settings.cameras
        if cameras is None:
            return [ImageRequest("", 0, pixels_as_float=False, compress=True)]
        first = next(iter(self.simulator.vehicles))
        return [request(one) for one in cameras if (one.vehicle_name or first) == name]

    def save(self, vehicle: str, picture: ImageResponse) -> str:
        """Write a picture; return the name of its file."""
        ending, data = encoded(picture)
        stem = f"img_{vehicle}_{picture.camera_name}_{picture.image_type}_{picture.time_stamp}{ending}"
        name = "".join(letter if letter.isalnum() or letter in "-_. " else "_" for letter in stem)
        (self.folder / PICTURES / name).write_bytes(data)
        return name


def request(camera: RecordedCamera) -> ImageRequest:
    """Return the request of a picture to record."""
    return ImageRequest(camera.name, camera.image_type, camera.pixels_as_float, camera.compress)


def same(one: Pose, two: Pose) -> bool:
    """Return whether two poses are equal."""
    return np.array_equal(one.position, two.position) and np.array_equal(one.orientation, two.orientation)


def encoded(picture: ImageResponse) -> tuple[str, bytes]:
    """Return the ending and the contents of the file of a picture: PFM, PNG or PPM."""
    size = f"{picture.width} {picture.height}\n".encode()
    if picture.pixels_as_float:
        rows = picture.image_data_float.reshape(picture.height, picture.width)[::-1]
        return ".pfm", b"Pf\n" + size + b"-1\n" + rows.astype("<f4").tobytes()
    if picture.compress:
        return ".png", picture.image_data_uint8
    colours = np.frombuffer(picture.image_data_uint8, dtype=np.uint8).reshape(-1, 3)
    return ".ppm", b"P6\n" + size + b"255\n" + colours[:, ::-1].tobytes()


def fresh(path: Path) -> Path:
    """Make a folder that is not there yet, with a number where the name is taken."""
    for number in range(1, 10_000):
        found = path if number == 1 else path.with_name(f"{path.name}-{number}")
        try:
            found.mkdir(parents=True)
        except FileExistsError:
            continue
        return found
    raise FileExistsError(str(path))


def prepare(simulator: Simulator) -> None:
    """Let sensors run, and record where the settings say so: to be called once before the simulator runs.

    Raises:
        InputError: a camera to record is not there, or the folder cannot be written.
    """
    equipment(simulator)
    for vehicle in simulator.vehicles.values():
        if vehicle.settings is not None and vehicle.settings.enable_trace:
            simulator.scene.markers.traces.setdefault(vehicle.name, Trace(TRACE_COLOR, TRACE_THICKNESS))
    if settings_of(simulator).recording.enabled:
        try:
            start(simulator)
        except Refused as error:
            raise InputError("settings.json", [Problem("Recording", str(error))]) from None


def start(simulator: Simulator) -> None:
    """Record from now on, anew where that is done already.

    Raises:
        Refused: a camera to record is not there, or the folder cannot be written.
    """
    stop(simulator)
    try:
        equipment(simulator).recorder = Recorder(simulator)
    except OSError as error:
        raise Refused(f"no recording: {error}") from error


def stop(simulator: Simulator) -> None:
    """Record no more."""
    recorder, equipment(simulator).recorder = equipment(simulator).recorder, None
    if recorder is not None:
        recorder.close()


def is_recording(simulator: Simulator) -> bool:
    """Return whether a recording is under way."""
    return equipment(simulator).recorder is not None


HANDLERS = {"startRecording": start, "stopRecording": stop, "isRecording": is_recording}
