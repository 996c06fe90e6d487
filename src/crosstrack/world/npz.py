"""Points of npz files: the array `points`."""

from crosstrack.npz import arrays
from crosstrack.types import Array
from crosstrack.world.columns import floats
from crosstrack.world.files import MOST_BYTES, refuse


def points(name: str, data: bytes) -> Array:
    """Return the array `points` of an npz file, (n, 3); further columns are left out.

    Raises:
        InputError: it is not an npz file, has no such array, or the array is not (n, 3 or more) numbers.
    """
    table = arrays(name, data, MOST_BYTES, ["points"])["points"]
    if table.ndim != 2 or table.shape[1] < 3:
        raise refuse(name, "points", f"numbers of shape (n, 3) are needed; found {table.shape}")
    return floats(table[:, :3])
