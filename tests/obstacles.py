"""Obstacles of every shape, side by side."""

import numpy as np

from crosstrack.world.shapes import Box, Cylinder, Prism, Shape, Sphere


def mixed(count: int, seed: int) -> tuple[Shape, ...]:
    """Return boxes, cylinders, spheres and prisms in turn, within 10 m of the origin and up to 4 m long."""
    rng = np.random.default_rng(seed)
    shapes: list[Shape] = []
    for x, y, z in rng.uniform(-10, 10, size=(count, 3)).tolist():
        a, b, c = rng.uniform(0.2, 2.0, size=3).tolist()
        ell = ((x, y), (x + 2 * a, y), (x + 2 * a, y + b), (x + a, y + b), (x + a, y + 2 * b), (x, y + 2 * b))
        choice: list[Shape] = [
            Box((x, y, z), (x + a, y + b, z + c)),
            Cylinder((x, y), a, (z, z + c)),
            Sphere((x, y, z), a),
            Prism(ell, (z, z + c)),
        ]
        shapes.append(choice[len(shapes) % 4])
    return tuple(shapes)
