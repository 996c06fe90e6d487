"""Draw everything that can be drawn."""

import airsim
from shared import climb, connect

client = connect()
climb(client, 3)
client.simFlushPersistentMarkers()
points = [airsim.Vector3r(5, east, -3) for east in range(-4, 5)]
red, green = [1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]
client.simPlotPoints(points, color_rgba=red, size=25, is_persistent=True)
client.simPlotLineStrip(points, color_rgba=green, thickness=5, duration=30.0)
client.simPlotLineList(points[:8], thickness=3, is_persistent=True)
client.simPlotArrows(points[:3], points[3:6], color_rgba=green, thickness=3, arrow_size=20, duration=20.0)
client.simPlotStrings([f"point {k}" for k in range(9)], points, scale=3, color_rgba=red, duration=60.0)
poses = [airsim.Pose(point, airsim.to_quaternion(0, 0, 0.1 * k)) for k, point in enumerate(points)]
client.simPlotTransforms(poses, scale=50, thickness=3, is_persistent=True)
client.simPlotTransformsWithNames(poses, [f"pose {k}" for k in range(9)], tf_scale=20, duration=40.0)
client.simSetTraceLine([0.0, 0.0, 1.0, 0.5], thickness=4)
client.moveToPositionAsync(4, 0, -3, 2).join()
client.armDisarm(False)
