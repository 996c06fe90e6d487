import numpy as np

from crosstrack.flight.scene import Scene
from crosstrack.show.sight import hidden, towards
from crosstrack.world.shapes import Sphere

BALL = Sphere(center=(1.0, 2.0, 3.0), radius=2.0)


def test_a_ball_hides_what_lies_behind_it() -> None:
    """Against the closed form: hidden is what the line to the viewer meets the ball from."""
    mesh = BALL.mesh()
    solid = Scene(np.zeros((2, 3)), np.zeros((2, 3)), (("ball", mesh.vertices, mesh.triangles),)).solid()
    assert solid is not None
    vertices, triangles = solid
    viewer = towards(32.0, -122.0)
    points = np.array(BALL.center) + np.random.default_rng(4).uniform(-4, 4, (3000, 3))
    away = points - BALL.center
    along = away @ viewer
    beside = np.linalg.norm(away - along[:, None] * viewer, axis=1)
    outside = np.linalg.norm(away, axis=1) > 2.0
    clear = np.abs(beside - 2.0) > 0.1  # where the flat faces lie inside the ball
    expected = (beside < 2.0) & (along < 0.0)
    found = hidden(points, vertices[triangles], viewer)
    np.testing.assert_array_equal(found[outside & clear], expected[outside & clear])
    assert expected[outside & clear].sum() > 100


def test_what_lies_on_a_face_is_seen() -> None:
    corners = np.array([[[0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0]]])
    points = np.array([[1.0, 1.0, 5.0], [1.0, 1.0, 4.9], [1.0, 1.0, 5.1]])
    viewer = towards(89.9, 0.0)
    assert hidden(points, corners, viewer).tolist() == [False, True, False]
