"""Calls about the server, its clock and its world."""

from numpy.typing import ArrayLike

from crosstrack.airsim.client.call import Call, move, query


class Server:
    """Calls about the server, its clock and its world."""

    @query
    def ping(self) -> Call[bool]:
        """Return true: the server is there."""
        return Call("ping")

    @query
    def get_server_version(self) -> Call[int]:
        """Return 1 for AirSim and Colosseum, more for Cosys-AirSim."""
        return Call("getServerVersion")

    @query
    def get_min_required_client_version(self) -> Call[int]:
        """Return the lowest version of a client that the server knows."""
        return Call("getMinRequiredClientVersion")

    @query
    def reset(self) -> Call[None]:
        """Put everything back to where it started; API control is lost, and moves on their way are cancelled."""
        return Call("reset")

    @query
    def pause(self, is_paused: bool = True) -> Call[None]:
        """Stop the clock, or let it run on."""
        return Call("simPause", is_paused)

    @query
    def is_paused(self) -> Call[bool]:
        """Return whether the clock stands still."""
        return Call("simIsPaused")

    @move
    def continue_for_time(self, seconds: float) -> Call[None]:
        """Let the clock run for so long (s), then stop it; AirSim counts the wall's seconds."""
        return Call("simContinueForTime", seconds)

    @move
    def continue_for_frames(self, frames: int) -> Call[None]:
        """Let the clock run for so many frames, then stop it."""
        return Call("simContinueForFrames", frames)

    @query
    def set_time_of_day(
        self,
        is_enabled: bool,
        start_datetime: str = "",
        is_start_datetime_dst: bool = False,
        celestial_clock_speed: float = 1.0,
        update_interval: float = 60.0,
        move_sun: bool = True,
    ) -> Call[None]:
        """Set the time of day, as `2018-02-12 15:20:00`, how fast it goes by, and how often (s) the sun follows."""
        return Call(
            "simSetTimeOfDay",
            is_enabled,
            start_datetime,
            is_start_datetime_dst,
            celestial_clock_speed,
            update_interval,
            move_sun,
        )

    @query
    def enable_weather(self, enable: bool) -> Call[None]:
        """Let there be weather, or none."""
        return Call("simEnableWeather", enable)

    @query
    def set_weather_parameter(self, parameter: int, value: float) -> Call[None]:
        """Set 0 rain, 1 wet roads, 2 snow, 3 snowy roads, 4 leaves, 5 leaves on roads, 6 dust or 7 fog, from 0 to 1."""
        return Call("simSetWeatherParameter", parameter, value)

    @query
    def set_wind(self, wind: ArrayLike) -> Call[None]:
        """Set the wind (3,), m/s."""
        return Call("simSetWind", wind)

    @query
    def set_ext_force(self, force: ArrayLike) -> Call[None]:
        """Push every vehicle with a force (3,), N; Colosseum alone knows it."""
        return Call("simSetExtForce", force)

    @query
    def run_console_command(self, command: str) -> Call[bool]:
        """Run a command of Unreal's console, and return whether it was taken."""
        return Call("simRunConsoleCommand", command)

    @query
    def print_log_message(self, message: str, parameter: str = "", severity: int = 0) -> Call[None]:
        """Show a message on the screen of the simulator; 0 is news, 1 well, 2 a warning, 3 an error."""
        return Call("simPrintLogMessage", message, parameter, severity)

    @query
    def get_settings_string(self) -> Call[str]:
        """Return the settings that the server runs with, as JSON."""
        return Call("getSettingsString")

    @query
    def start_recording(self) -> Call[None]:
        """Begin to record."""
        return Call("startRecording")

    @query
    def stop_recording(self) -> Call[None]:
        """End the recording."""
        return Call("stopRecording")

    @query
    def is_recording(self) -> Call[bool]:
        """Return whether it records."""
        return Call("isRecording")
