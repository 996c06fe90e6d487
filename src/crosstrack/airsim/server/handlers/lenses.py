"""Calls about lenses and films, which change no picture: pictures come from a pinhole of the camera's field of view."""

from crosstrack.airsim.scene.cameras.lens import BLADES, FILMS, LENSES, NEAREST, Lens, told_film, told_lens
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers.cameras import find
from crosstrack.airsim.server.simulator import Simulator


def lens_of(simulator: Simulator, camera: str, vehicle: str, external: bool) -> Lens:
    """Return the lens of a camera."""
    return find(simulator, camera, vehicle, external)[0].lens


def above_zero(value: float, what: str) -> float:
    """Return a value.

    Raises:
        Refused: it is not above zero and finite.
    """
    if not 0.0 < value < 1e9:
        raise Refused(f"{what} is {value}; it must be above 0")
    return value


def preset_lenses(simulator: Simulator, camera: str, vehicle: str, external: bool) -> list[str]:
    """Return what kinds of lenses there are."""
    lens_of(simulator, camera, vehicle, external)
    return [f"{told_lens(name, kind)}" for name, kind in LENSES.items()]


def lens(simulator: Simulator, camera: str, vehicle: str, external: bool) -> str:
    """Return what the lens of a camera is."""
    name = lens_of(simulator, camera, vehicle, external).kind
    more = f"\n\t Diaphragm Blade Count: {BLADES}\n\t Minimum focus distance: {NEAREST}"
    return told_lens(name, LENSES[name]) + more


def set_preset_lens(simulator: Simulator, preset: str, camera: str, vehicle: str, external: bool) -> None:
    """Take another lens; nothing happens where there is none of that name, as in AirSim."""
    found = lens_of(simulator, camera, vehicle, external)
    if preset in LENSES:
        kind = LENSES[preset]
        found.kind = preset
        found.focal_length = min(max(found.focal_length, kind.shortest), kind.longest)
        found.aperture = min(max(found.aperture, kind.widest), kind.narrowest)


def preset_films(simulator: Simulator, camera: str, vehicle: str, external: bool) -> list[str]:
    """Return what films there are."""
    lens_of(simulator, camera, vehicle, external)
    return [told_film(name, *size) for name, size in FILMS.items()]


def film(simulator: Simulator, camera: str, vehicle: str, external: bool) -> str:
    """Return what the film of a camera is."""
    found = lens_of(simulator, camera, vehicle, external)
    return told_film(found.film, found.width, found.height)


def set_preset_film(simulator: Simulator, preset: str, camera: str, vehicle: str, external: bool) -> None:
    """Take another film; nothing happens where there is none of that name, as in AirSim."""
    found = lens_of(simulator, camera, vehicle, external)
    if preset in FILMS:
        found.film = preset
        found.width, found.height = FILMS[preset]


def set_film(simulator: Simulator, width: float, height: float, camera: str, vehicle: str, external: bool) -> float:
    """Set the size of the film (mm); return the ratio of its sides."""
    found = lens_of(simulator, camera, vehicle, external)
    found.width, found.height = above_zero(width, "the width of the film"), above_zero(height, "the height of the film")
    found.film = "Custom..."
    return found.width / found.height


def focal_length(simulator: Simulator, camera: str, vehicle: str, external: bool) -> float:
    """Return the focal length, mm."""
    return lens_of(simulator, camera, vehicle, external).focal_length


def set_focal_length(simulator: Simulator, length: float, camera: str, vehicle: str, external: bool) -> None:
    """Set the focal length (mm)."""
    lens_of(simulator, camera, vehicle, external).focal_length = above_zero(length, "the focal length")


def focus_by_hand(simulator: Simulator, enable: bool, camera: str, vehicle: str, external: bool) -> None:
    """Focus by hand, or not at all."""
    lens_of(simulator, camera, vehicle, external).focuses_by_hand = enable


def focus_distance(simulator: Simulator, camera: str, vehicle: str, external: bool) -> float:
    """Return how far away is sharp, cm."""
    return lens_of(simulator, camera, vehicle, external).focus_distance


def set_focus_distance(simulator: Simulator, far: float, camera: str, vehicle: str, external: bool) -> None:
    """Set how far away is sharp (cm)."""
    lens_of(simulator, camera, vehicle, external).focus_distance = above_zero(far, "the focus distance")


def aperture(simulator: Simulator, camera: str, vehicle: str, external: bool) -> float:
    """Return the f-number."""
    return lens_of(simulator, camera, vehicle, external).aperture


def set_aperture(simulator: Simulator, number: float, camera: str, vehicle: str, external: bool) -> None:
    """Set the f-number."""
    lens_of(simulator, camera, vehicle, external).aperture = above_zero(number, "the aperture")


def show_focus_plane(simulator: Simulator, enable: bool, camera: str, vehicle: str, external: bool) -> None:
    """Draw what is sharp, or not."""
    lens_of(simulator, camera, vehicle, external).focus_plane = enable


def field_of_view(simulator: Simulator, camera: str, vehicle: str, external: bool) -> str:
    """Return the field of view of the lens and the film."""
    found = lens_of(simulator, camera, vehicle, external)
    level = f"Current Field Of View:\n\tHorizontal Field Of View: {found.fov:g}"
    return f"{level};\n\t Vertical Field Of View: {found.fov_upright:g}"


HANDLERS = {
    "simGetPresetLensSettings": preset_lenses,
    "simGetLensSettings": lens,
    "simSetPresetLensSettings": set_preset_lens,
    "simGetPresetFilmbackSettings": preset_films,
    "simGetFilmbackSettings": film,
    "simSetPresetFilmbackSettings": set_preset_film,
    "simSetFilmbackSettings": set_film,
    "simGetFocalLength": focal_length,
    "simSetFocalLength": set_focal_length,
    "simEnableManualFocus": focus_by_hand,
    "simGetFocusDistance": focus_distance,
    "simSetFocusDistance": set_focus_distance,
    "simGetFocusAperture": aperture,
    "simSetFocusAperture": set_aperture,
    "simEnableFocusPlane": show_focus_plane,
    "simGetCurrentFieldOfView": field_of_view,
}
