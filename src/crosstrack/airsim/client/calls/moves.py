"""Calls about moves, which are over when they are done, superseded or out of time."""

from numpy.typing import ArrayLike

from crosstrack.airsim.client.call import Call, move
from crosstrack.airsim.structs import YawMode

FOREVER = 3e38
"""s, as long as it takes"""
FREE = YawMode()
"""no turning about: a yaw rate of 0"""


class Moves:
    """Calls about moves, which are over when they are done, superseded or out of time."""

    @move
    def takeoff(self, timeout: float = 20.0, vehicle: str = "") -> Call[bool]:
        """Rise by 2 m. It answers false even where that went well, and an error where the vehicle moves already."""
        return Call("takeoff", timeout, vehicle)

    @move
    def land(self, timeout: float = 60.0, vehicle: str = "") -> Call[bool]:
        """Descend until nothing moves any more; called while it still climbs, that is at once."""
        return Call("land", timeout, vehicle)

    @move
    def go_home(self, timeout: float = FOREVER, vehicle: str = "") -> Call[bool]:
        """Fly straight to the start at 0.5 m/s, without landing."""
        return Call("goHome", timeout, vehicle)

    @move
    def hover(self, vehicle: str = "") -> Call[bool]:
        """Stay here."""
        return Call("hover", vehicle)

    @move
    def move_by_velocity(
        self,
        vx: float,
        vy: float,
        vz: float,
        duration: float,
        drivetrain: int = 0,
        yaw_mode: YawMode = FREE,
        vehicle: str = "",
    ) -> Call[bool]:
        """Fly with a velocity (m/s, world) for so long (s)."""
        return Call("moveByVelocity", vx, vy, vz, duration, drivetrain, yaw_mode, vehicle)

    @move
    def move_by_velocity_z(
        self,
        vx: float,
        vy: float,
        z: float,
        duration: float,
        drivetrain: int = 0,
        yaw_mode: YawMode = FREE,
        vehicle: str = "",
    ) -> Call[bool]:
        """Fly with a level velocity (m/s, world) at a height z (m) for so long (s)."""
        return Call("moveByVelocityZ", vx, vy, z, duration, drivetrain, yaw_mode, vehicle)

    @move
    def move_by_velocity_body_frame(
        self,
        vx: float,
        vy: float,
        vz: float,
        duration: float,
        drivetrain: int = 0,
        yaw_mode: YawMode = FREE,
        vehicle: str = "",
    ) -> Call[bool]:
        """Fly with a velocity (m/s, turned by the yaw at the call) for so long (s)."""
        return Call("moveByVelocityBodyFrame", vx, vy, vz, duration, drivetrain, yaw_mode, vehicle)

    @move
    def move_by_velocity_z_body_frame(
        self,
        vx: float,
        vy: float,
        z: float,
        duration: float,
        drivetrain: int = 0,
        yaw_mode: YawMode = FREE,
        vehicle: str = "",
    ) -> Call[bool]:
        """Fly with a level velocity (m/s, turned by the yaw at the call) at a height z (m) for so long (s)."""
        return Call("moveByVelocityZBodyFrame", vx, vy, z, duration, drivetrain, yaw_mode, vehicle)

    @move
    def move_by_manual(
        self,
        vx_max: float,
        vy_max: float,
        z_min: float,
        duration: float,
        drivetrain: int = 0,
        yaw_mode: YawMode = FREE,
        vehicle: str = "",
    ) -> Call[bool]:
        """Fly as the remote control says, within limits (m/s, m), for so long (s)."""
        return Call("moveByManual", vx_max, vy_max, z_min, duration, drivetrain, yaw_mode, vehicle)

    @move
    def move_on_path(
        self,
        path: ArrayLike,
        speed: float,
        timeout: float = FOREVER,
        drivetrain: int = 0,
        yaw_mode: YawMode = FREE,
        lookahead: float = -1.0,
        adaptive_lookahead: float = 1.0,
        vehicle: str = "",
    ) -> Call[bool]:
        """Follow points (n, 3) m at a speed (m/s); a lookahead (m) of -1 is chosen by the server."""
        return Call("moveOnPath", path, speed, timeout, drivetrain, yaw_mode, lookahead, adaptive_lookahead, vehicle)

    @move
    def move_to_position(
        self,
        x: float,
        y: float,
        z: float,
        speed: float,
        timeout: float = FOREVER,
        drivetrain: int = 0,
        yaw_mode: YawMode = FREE,
        lookahead: float = -1.0,
        adaptive_lookahead: float = 1.0,
        vehicle: str = "",
    ) -> Call[bool]:
        """Fly straight to a point (m) at a speed (m/s)."""
        return Call(
            "moveToPosition", x, y, z, speed, timeout, drivetrain, yaw_mode, lookahead, adaptive_lookahead, vehicle
        )

    @move
    def move_to_gps(
        self,
        latitude: float,
        longitude: float,
        altitude: float,
        speed: float,
        timeout: float = FOREVER,
        drivetrain: int = 0,
        yaw_mode: YawMode = FREE,
        lookahead: float = -1.0,
        adaptive_lookahead: float = 1.0,
        vehicle: str = "",
    ) -> Call[bool]:
        """Fly straight to a point of the earth (deg, deg, m), single on the wire: to half a metre or so."""
        return Call(
            "moveToGPS",
            latitude,
            longitude,
            altitude,
            speed,
            timeout,
            drivetrain,
            yaw_mode,
            lookahead,
            adaptive_lookahead,
            vehicle,
        )

    @move
    def move_to_z(
        self,
        z: float,
        speed: float,
        timeout: float = FOREVER,
        yaw_mode: YawMode = FREE,
        lookahead: float = -1.0,
        adaptive_lookahead: float = 1.0,
        vehicle: str = "",
    ) -> Call[bool]:
        """Climb or descend to a height z (m) at a speed (m/s)."""
        return Call("moveToZ", z, speed, timeout, yaw_mode, lookahead, adaptive_lookahead, vehicle)

    @move
    def rotate_to_yaw(self, yaw: float, timeout: float = FOREVER, margin: float = 5.0, vehicle: str = "") -> Call[bool]:
        """Turn to a yaw (deg), to within a margin (deg)."""
        return Call("rotateToYaw", yaw, timeout, margin, vehicle)

    @move
    def rotate_by_yaw_rate(self, yaw_rate: float, duration: float, vehicle: str = "") -> Call[bool]:
        """Turn at a rate (deg/s) for so long (s)."""
        return Call("rotateByYawRate", yaw_rate, duration, vehicle)

    @move
    def move_by_motor_pwms(
        self,
        front_right: float,
        rear_left: float,
        front_left: float,
        rear_right: float,
        duration: float,
        vehicle: str = "",
    ) -> Call[bool]:
        """Run the motors at levels from 0 to 1 for so long (s)."""
        return Call("moveByMotorPWMs", front_right, rear_left, front_left, rear_right, duration, vehicle)

    @move
    def move_by_roll_pitch_yaw_z(
        self, roll: float, pitch: float, yaw: float, z: float, duration: float, vehicle: str = ""
    ) -> Call[bool]:
        """Hold angles (rad, nose up and clockwise; the package `airsim` turns these two round) and a height z (m)."""
        return Call("moveByRollPitchYawZ", roll, pitch, yaw, z, duration, vehicle)

    @move
    def move_by_roll_pitch_yaw_throttle(
        self, roll: float, pitch: float, yaw: float, throttle: float, duration: float, vehicle: str = ""
    ) -> Call[bool]:
        """Hold angles (rad, nose up and clockwise) and a throttle from 0 to 1 for so long (s)."""
        return Call("moveByRollPitchYawThrottle", roll, pitch, yaw, throttle, duration, vehicle)

    @move
    def move_by_roll_pitch_yawrate_throttle(
        self, roll: float, pitch: float, yaw_rate: float, throttle: float, duration: float, vehicle: str = ""
    ) -> Call[bool]:
        """Hold roll, pitch (rad, nose up), yaw rate (rad/s, clockwise) and a throttle from 0 to 1 for so long (s)."""
        return Call("moveByRollPitchYawrateThrottle", roll, pitch, yaw_rate, throttle, duration, vehicle)

    @move
    def move_by_roll_pitch_yawrate_z(
        self, roll: float, pitch: float, yaw_rate: float, z: float, duration: float, vehicle: str = ""
    ) -> Call[bool]:
        """Hold roll and pitch (rad, nose up), a yaw rate (rad/s, clockwise) and a height z (m) for so long (s)."""
        return Call("moveByRollPitchYawrateZ", roll, pitch, yaw_rate, z, duration, vehicle)

    @move
    def move_by_angle_rates_z(
        self, roll_rate: float, pitch_rate: float, yaw_rate: float, z: float, duration: float, vehicle: str = ""
    ) -> Call[bool]:
        """Hold rates (rad/s, nose up and clockwise) and a height z (m) for so long (s)."""
        return Call("moveByAngleRatesZ", roll_rate, pitch_rate, yaw_rate, z, duration, vehicle)

    @move
    def move_by_angle_rates_throttle(
        self, roll_rate: float, pitch_rate: float, yaw_rate: float, throttle: float, duration: float, vehicle: str = ""
    ) -> Call[bool]:
        """Hold rates (rad/s, nose up and clockwise) and a throttle from 0 to 1 for so long (s)."""
        return Call("moveByAngleRatesThrottle", roll_rate, pitch_rate, yaw_rate, throttle, duration, vehicle)
