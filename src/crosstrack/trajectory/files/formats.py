"""Reading the file of a trajectory by the ending of its name."""

from crosstrack.errors import InputError, Problem
from crosstrack.trajectory.files.csv_file import from_csv
from crosstrack.trajectory.files.json_file import from_json
from crosstrack.trajectory.files.sound import MOST_BYTES
from crosstrack.trajectory.polynomial import PiecewisePolynomial

READERS = {".json": from_json, ".csv": from_csv}


def from_bytes(name: str, data: bytes) -> PiecewisePolynomial:
    """Read a trajectory from the contents of a file that is named `.json` or `.csv`.

    Raises:
        InputError: everything that is wrong with it, each with its place.
    """
    read = next((reader for ending, reader in READERS.items() if name.lower().endswith(ending)), None)
    if read is None:
        raise InputError(name, [Problem("", f"the name of a trajectory must end in {' or '.join(READERS)}")])
    if len(data) > MOST_BYTES:
        raise InputError(name, [Problem("", f"it is {len(data)} bytes; at most {MOST_BYTES} are read")])
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(name, [Problem("", f"is not UTF-8 text: byte {error.start}")]) from None
    return read(name, text)
