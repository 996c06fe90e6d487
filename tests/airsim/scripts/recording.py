"""Record a flight; read what was written, in the folder given second on the command line."""

import sys
from pathlib import Path

import airsim
import numpy as np
from shared import at, clock, connect

client = connect()
client.takeoffAsync().join()
assert not client.isRecording()
before = set(Path(sys.argv[2]).glob("*"))
client.startRecording()
assert client.isRecording()
began = clock(client)
client.moveByVelocityAsync(2, 0, 0, 2).join()
ended, end = clock(client), at(client)
client.stopRecording()
assert not client.isRecording()
(folder,) = set(Path(sys.argv[2]).glob("*")) - before
header, *lines = (folder / "airsim_rec.txt").read_text().splitlines()
columns = header.split("\t")
assert columns[:5] == ["VehicleName", "TimeStamp", "POS_X", "POS_Y", "POS_Z"]
rows = [dict(zip(columns, line.split("\t"), strict=True)) for line in lines]
times = np.array([float(row["TimeStamp"]) for row in rows]) * 1e-3
assert len(rows) > 10
assert (np.diff(times) > 0.04).all()
assert began - 0.1 < times[0] < times[-1] < ended + 0.1
north = np.array([float(row["POS_X"]) for row in rows])
assert (np.diff(north) > -1e-3).all(), "it flew north"
assert 0 <= end[0] - north[-1] < 0.3
for row in rows:
    for name in row["ImageFile"].split(";"):
        assert (folder / "images" / name).read_bytes().startswith(b"\x89PNG"), name
client.simPrintLogMessage("recorded ", str(len(rows)), 0)
assert client.simGetVehiclePose().position.x_val == airsim.Vector3r(end[0]).x_val
