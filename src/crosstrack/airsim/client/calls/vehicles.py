"""Calls about vehicles and what is known of them."""

from numpy.typing import ArrayLike

from crosstrack.airsim.client.call import Call, query
from crosstrack.airsim.structs import (
    CollisionInfo,
    EnvironmentState,
    GeoPoint,
    KinematicsState,
    MultirotorState,
    Pose,
    RCData,
    RotorStates,
)


class Vehicles:
    """Calls about vehicles and what is known of them."""

    @query
    def list_vehicles(self) -> Call[tuple[str, ...]]:
        """Return the names of the vehicles."""
        return Call("listVehicles")

    @query
    def add_vehicle(self, vehicle: str, kind: str, pose: Pose, pawn_path: str = "") -> Call[bool]:
        """Add a vehicle of a kind, as `simpleflight`, and return whether it is there."""
        return Call("simAddVehicle", vehicle, kind, pose, pawn_path)

    @query
    def enable_api_control(self, is_enabled: bool = True, vehicle: str = "") -> Call[None]:
        """Take control of a vehicle, without which no move is obeyed, or give it back."""
        return Call("enableApiControl", is_enabled, vehicle)

    @query
    def is_api_control_enabled(self, vehicle: str = "") -> Call[bool]:
        """Return whether moves are obeyed."""
        return Call("isApiControlEnabled", vehicle)

    @query
    def arm_disarm(self, arm: bool = True, vehicle: str = "") -> Call[bool]:
        """Let the motors run, or stop them, in flight too; return whether that was possible."""
        return Call("armDisarm", arm, vehicle)

    @query
    def cancel_last_task(self, vehicle: str = "") -> Call[None]:
        """Cancel the move on its way, which then answers false."""
        return Call("cancelLastTask", vehicle)

    @query
    def get_home_geo_point(self, vehicle: str = "") -> Call[GeoPoint]:
        """Return where on earth the vehicle started."""
        return Call("getHomeGeoPoint", vehicle)

    @query
    def get_multirotor_state(self, vehicle: str = "") -> Call[MultirotorState]:
        """Return how the vehicle moves, and whether it flies."""
        return Call("getMultirotorState", vehicle)

    @query
    def get_rotor_states(self, vehicle: str = "") -> Call[RotorStates]:
        """Return how its rotors turn."""
        return Call("getRotorStates", vehicle)

    @query
    def get_collision_info(self, vehicle: str = "") -> Call[CollisionInfo]:
        """Return the last contact; asked again, there was none since."""
        return Call("simGetCollisionInfo", vehicle)

    @query
    def get_vehicle_pose(self, vehicle: str = "") -> Call[Pose]:
        """Return the true pose relative to the start."""
        return Call("simGetVehiclePose", vehicle)

    @query
    def set_vehicle_pose(self, pose: Pose, ignore_collision: bool = True, vehicle: str = "") -> Call[None]:
        """Put the vehicle somewhere."""
        return Call("simSetVehiclePose", pose, ignore_collision, vehicle)

    @query
    def get_ground_truth_kinematics(self, vehicle: str = "") -> Call[KinematicsState]:
        """Return how the vehicle truly moves."""
        return Call("simGetGroundTruthKinematics", vehicle)

    @query
    def set_kinematics(self, state: KinematicsState, ignore_collision: bool = True, vehicle: str = "") -> Call[None]:
        """Have the vehicle move so from now on."""
        return Call("simSetKinematics", state, ignore_collision, vehicle)

    @query
    def get_ground_truth_environment(self, vehicle: str = "") -> Call[EnvironmentState]:
        """Return what the air and gravity are at the vehicle."""
        return Call("simGetGroundTruthEnvironment", vehicle)

    @query
    def set_trace_line(self, color: ArrayLike, thickness: float = 1.0, vehicle: str = "") -> Call[None]:
        """Set the color (4,), 0 to 1, and the thickness of the line that the vehicle leaves behind."""
        return Call("simSetTraceLine", color, thickness, vehicle)

    @query
    def move_by_rc(self, data: RCData, vehicle: str = "") -> Call[None]:
        """Fly as a remote control says."""
        return Call("moveByRC", data, vehicle)

    @query
    def set_angle_level_controller_gains(
        self, kp: ArrayLike, ki: ArrayLike, kd: ArrayLike, vehicle: str = ""
    ) -> Call[None]:
        """Set the gains (3,) from angle to rate: roll, pitch, yaw."""
        return Call("setAngleLevelControllerGains", kp, ki, kd, vehicle)

    @query
    def set_angle_rate_controller_gains(
        self, kp: ArrayLike, ki: ArrayLike, kd: ArrayLike, vehicle: str = ""
    ) -> Call[None]:
        """Set the gains (3,) from rate to torque: roll, pitch, yaw."""
        return Call("setAngleRateControllerGains", kp, ki, kd, vehicle)

    @query
    def set_velocity_controller_gains(
        self, kp: ArrayLike, ki: ArrayLike, kd: ArrayLike, vehicle: str = ""
    ) -> Call[None]:
        """Set the gains (3,) from velocity to angle and throttle: x, y, z."""
        return Call("setVelocityControllerGains", kp, ki, kd, vehicle)

    @query
    def set_position_controller_gains(
        self, kp: ArrayLike, ki: ArrayLike, kd: ArrayLike, vehicle: str = ""
    ) -> Call[None]:
        """Set the gains (3,) from position to velocity: x, y, z."""
        return Call("setPositionControllerGains", kp, ki, kd, vehicle)

    @query
    def set_safety(
        self,
        reasons: int,
        clearance: float,
        strategy: int,
        avoidance_speed: float,
        origin: ArrayLike,
        width: float,
        z_max: float,
        z_min: float,
        vehicle: str = "",
    ) -> Call[bool]:
        """Set the limits of AirSim's safety evaluator, which multirotors do not have: it answers with an error."""
        return Call("setSafety", reasons, clearance, strategy, avoidance_speed, origin, width, z_max, z_min, vehicle)
