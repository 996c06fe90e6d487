"""Point clouds as obstacles: every voxel that holds a point is occupied."""

from dataclasses import dataclass
from pathlib import PurePath

import numpy as np

from crosstrack.types import Array, Positive
from crosstrack.world import npz, pcd, ply
from crosstrack.world.files import Files, read, refuse
from crosstrack.world.grids import MOST_CELLS, Voxels

READERS = {".ply": ply.points, ".pcd": pcd.points, ".npz": npz.points}
MARGIN = 4


@dataclass(frozen=True)
class Cloud:
    """A point cloud in metres, east, north, up; points that are not finite are left out."""

    file: str
    """PLY, PCD (viewpoint not applied) or npz with `points` (n, 3), relative to the mission's folder"""
    voxel: Positive = 0.2
    """m, edge of a voxel"""

    def build(self, files: Files) -> Voxels:
        """Read the cloud and return its voxels.

        Raises:
            InputError: the file is missing, of another kind, broken or empty, or needs too many voxels.
        """
        ending = PurePath(self.file).suffix.lower()
        if ending not in READERS:
            raise refuse(self.file, "", f"a cloud ends in {', '.join(READERS)}; found {ending!r}")
        points = READERS[ending](self.file, read(files, self.file))
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            raise refuse(self.file, "", "it holds no finite point")
        return voxelise(self.file, points, self.voxel)


def voxelise(name: str, points: Array, voxel: float) -> Voxels:
    """Return the voxels that hold at least one of the points (n, 3), m, with a margin around them.

    Raises:
        InputError: more than 16 million voxels are needed.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        first = np.floor(points.min(axis=0) / voxel) - MARGIN
        counts = np.floor(points.max(axis=0) / voxel) - first + MARGIN + 1
        total, extents = float(np.prod(counts)), np.ptp(points, axis=0)
    if not total <= MOST_CELLS:
        extent = " x ".join(f"{size:.6g}" for size in extents)
        message = f"{extent} m in voxels of {voxel} m are {total:.3g} voxels; at most {MOST_CELLS}"
        raise refuse(name, "voxel", message)
    occupied = np.zeros(counts.astype(np.int64), dtype=bool)
    x, y, z = (np.floor(points / voxel) - first).astype(np.int64).T
    occupied[x, y, z] = True
    ox, oy, oz = (first * voxel).tolist()
    return Voxels(occupied, (ox, oy, oz), voxel)
