"""What a camera of an AirSim vehicle sees on the server: picture, depth, segmentation, surface normals, side by side.

Run: python examples/airsim_views.py [FILE.png]
"""

import io
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from crosstrack.airsim import Client, ImageRequest, Server, Settings, simulator_of

SCENE, DEPTH, SEGMENTATION, NORMALS = 0, 3, 5, 6
"""AirSim's kinds of images; depth as a picture, from near, black, to 100 m, white"""


def main(out: Path) -> None:
    """Take off, look ahead, and write the pictures."""
    with Server(simulator_of(Settings(), lockstep=True)) as server, Client(port=server.port, timeout=60.0) as client:
        client.enable_api_control(True)
        client.takeoff().join()
        client.move_to_position(4, 4, -6, 3).join()
        client.hover().join()
        kinds = (SCENE, DEPTH, SEGMENTATION, NORMALS)
        images = client.get_images([ImageRequest("front_center", kind, False, True) for kind in kinds])
        place = client.get_multirotor_state().kinematics_estimated.position
    pictures = [np.asarray(Image.open(io.BytesIO(image.image_data_uint8)).convert("RGB")) for image in images]
    rows = [np.hstack(pictures[:2]), np.hstack(pictures[2:])]
    out.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.vstack(rows)).resize((1024, 576), Image.Resampling.LANCZOS).save(out)
    print(f"Seen from {np.round(place, 2)} (north, east, down, m): {out}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs/airsim_views.png"))
