"""The lens and the film of a camera, as Unreal has them: what is set is told again, and changes no picture."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """A kind of lens."""

    shortest: float
    """mm, focal length"""
    longest: float
    """mm, focal length"""
    widest: float
    """f-number"""
    narrowest: float
    """f-number"""


LENSES = {
    "12mm Prime f/2.8": Kind(12, 12, 2.8, 22),
    "30mm Prime f/1.4": Kind(30, 30, 1.4, 22),
    "50mm Prime f/1.8": Kind(50, 50, 1.8, 22),
    "85mm Prime f/1.8": Kind(85, 85, 1.8, 22),
    "105mm Prime f/2": Kind(105, 105, 2, 22),
    "200mm Prime f/2": Kind(200, 200, 2, 22),
    "24-70mm Zoom f/2.8": Kind(24, 70, 2.8, 22),
    "70-200mm Zoom f/2.8": Kind(70, 200, 2.8, 22),
    "Universal Zoom": Kind(4, 1000, 1.2, 22),
}
FILMS = {
    "16:9 Film": (24.0, 13.5),
    "16:9 Digital Film": (23.76, 13.365),
    "16:9 DSLR": (36.0, 20.25),
    "Super 8mm": (5.79, 4.01),
    "Super 16mm": (12.52, 7.58),
    "Super 35mm": (24.89, 18.66),
    "35mm Academy": (21.946, 16.002),
    "Full Frame DSLR": (36.0, 24.0),
    "Micro Four Thirds": (17.3, 13.0),
}
"""width and height, mm"""
BLADES, NEAREST = 7, 15
"""of the diaphragm of every lens, and how near (in Unreal's units) it focuses"""


@dataclass
class Lens:
    """The lens and the film of one camera."""

    kind: str = "Universal Zoom"
    film: str = "16:9 Digital Film"
    width: float = 23.76
    """mm, of the film"""
    height: float = 13.365
    """mm, of the film"""
    focal_length: float = 11.9
    """mm"""
    focus_distance: float = 100_000.0
    """in Unreal's units, cm"""
    aperture: float = 2.8
    """f-number"""
    focuses_by_hand: bool = False
    focus_plane: bool = False
    """whether it is drawn"""

    @property
    def fov(self) -> float:
        """Degrees, from the left to the right edge."""
        return math.degrees(2 * math.atan(self.width / 2 / self.focal_length))

    @fov.setter
    def fov(self, degrees: float) -> None:
        self.focal_length = self.width / 2 / math.tan(math.radians(degrees) / 2)

    @property
    def fov_upright(self) -> float:
        """Degrees, from the lower to the upper edge."""
        return math.degrees(2 * math.atan(self.height / 2 / self.focal_length))


def told_lens(name: str, kind: Kind) -> str:
    """Return what AirSim tells of a kind of lens."""
    lengths = f"Name: {name};\n\t MinFocalLength: {kind.shortest:g}; \t MaxFocalLength: {kind.longest:g}"
    return f"{lengths}\n\t Min FStop: {kind.widest:g}; \t Max Fstop: {kind.narrowest:g}"


def told_film(name: str, width: float, height: float) -> str:
    """Return what AirSim tells of a film."""
    sides = f"Name: {name};\n\t Sensor Width: {width:g}; \t Sensor Height: {height:g}"
    return f"{sides}\n\t Sensor Aspect Ratio: {width / height:g}"
