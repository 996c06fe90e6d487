"""Colours, the same in the report and in the pictures."""

INK = "#1e293b"
GRID = "#e2e8f0"
ROUTE = "#64748b"
OBSTACLE = "#b6c2d1"
PALETTE = ("#2563eb", "#ea580c", "#059669", "#9333ea", "#dc2626", "#0891b2", "#ca8a04", "#db2777")
"""of flights, in their order"""
FOOTPRINT = "#94a3b8"
"""obstacles from above, where even a thin wall has to stand out from the grid"""
UNMAPPED = "#f2bd75"
"""obstacles that the vehicle is not told of"""
UNMAPPED_FOOTPRINT = "#e09a3c"
MOVING = "#c026d3"
"""obstacles that move"""
SEEN = "#0e7490"
"""points that the sensors saw"""
AVOIDERS = ("#7c3aed", "#be123c", "#4d7c0f")
"""where avoiders stepped in, in their order; those there for safety alone are as dark as ink"""
PLANNED = "#0f766e"
"""a trajectory beside what was flown of it"""
ALARM = "#dc2626"
ROTORS = ("#1e293b", "#2563eb", "#ea580c", "#059669", "#9333ea", "#dc2626", "#0891b2", "#ca8a04", "#db2777")
"""of the mean and of the rotors"""
LEAST_TOP = {"error": 0.1, "speed": 0.1}
"""m and m/s, what the end of the scale stands for at least: errors of a few centimetres stay blue"""
SCALE = ((0.0, "#2563eb"), (0.5, "#f59e0b"), (1.0, "#dc2626"))
"""from the least to the largest, in [0, 1], of what a path is coloured by"""
