"""AirSim's generic quadrotor: the one airframe that its own autopilot flies, in the body frame forward-right-down."""

import math

MASS = 1.0
"""kg"""
MOTOR_MASS = 0.055
"""kg, of each of four, at the rotor"""
BOX = (0.18, 0.11, 0.04)
"""m, length, width and height of the body"""
ARM = 0.2275
"""m, from the centre to a rotor, seen from above"""
ROTOR_Z = 0.025
"""m, of the rotors, down"""
PROPELLER_DIAMETER = 0.2286
"""m"""
PROPELLER_HEIGHT = 0.01
"""m, of the disc that a turning propeller is taken for"""
ROTOR_LAG = 0.005
"""s, time constant from the signal of a motor to its thrust"""

THRUST_COEFFICIENT = 0.109919
"""at full speed; the propeller is a GWS 9x5, measured by the University of Illinois"""
POWER_COEFFICIENT = 0.040164
"""at full speed"""
FULL_SPEED = 6396.667 / 60
"""revolutions a second"""
NOMINAL_DENSITY = 1.225
"""kg/m³, that thrust and torque are stated for"""

ROTOR_SPEED_MAX = 2 * math.pi * FULL_SPEED
"""rad/s"""
THRUST_MAX = THRUST_COEFFICIENT * NOMINAL_DENSITY * FULL_SPEED**2 * PROPELLER_DIAMETER**4
"""N, of one rotor; C_T times density, squared speed and diameter to the fourth"""
TORQUE_MAX = POWER_COEFFICIENT * NOMINAL_DENSITY * FULL_SPEED**2 * PROPELLER_DIAMETER**5 / (2 * math.pi)
"""N m, of one rotor; C_P times density, squared speed and diameter to the fifth over a full turn"""

HALF_TRACK = ARM * math.sqrt(0.5)
"""m, from the centre to a rotor along x and along y"""
ROTOR_X = (HALF_TRACK, -HALF_TRACK, HALF_TRACK, -HALF_TRACK)
"""m: front right, rear left, front left, rear right"""
ROTOR_Y = (HALF_TRACK, -HALF_TRACK, -HALF_TRACK, HALF_TRACK)
SPIN = (-1.0, -1.0, 1.0, 1.0)
"""of the propeller: +1 clockwise seen from above; the drag torque turns the body the other way"""

BOX_MASS = MASS - 4 * MOTOR_MASS
INERTIA = (
    BOX_MASS / 12 * (BOX[1] ** 2 + BOX[2] ** 2) + 4 * MOTOR_MASS * (HALF_TRACK**2 + ROTOR_Z**2),
    BOX_MASS / 12 * (BOX[0] ** 2 + BOX[2] ** 2) + 4 * MOTOR_MASS * (HALF_TRACK**2 + ROTOR_Z**2),
    BOX_MASS / 12 * (BOX[0] ** 2 + BOX[1] ** 2) + 4 * MOTOR_MASS * ARM**2,
)
"""kg m², a box and four points"""

DRAG_COEFFICIENT = 1.3 / 4
DISC = math.pi * PROPELLER_DIAMETER**2
DISC_EDGE = math.pi * PROPELLER_DIAMETER * PROPELLER_HEIGHT
DRAG = (
    DRAG_COEFFICIENT / 2 * (BOX[1] * BOX[2] + 4 * DISC_EDGE),
    DRAG_COEFFICIENT / 2 * (BOX[0] * BOX[2] + 4 * DISC_EDGE),
    DRAG_COEFFICIENT / 2 * (BOX[0] * BOX[1] + 4 * DISC),
)
"""m², of the two faces of the box across x, y and z: half the drag coefficient times the area, propellers included"""
DRAG_SPEED_MIN = 0.1
"""m/s, of a face against the air, below which it has no drag"""

RESTITUTION = 0.55
FRICTION = 0.5
RADIUS = ARM + PROPELLER_DIAMETER / 2
"""m, of the ball that holds the vehicle: what hits obstacles"""
