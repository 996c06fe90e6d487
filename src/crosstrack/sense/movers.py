"""What moves, from scans alone: where it is, how fast, and how large.

Points of a scan that lie where earlier scans saw through, see `crosstrack.sense.views`, are put into clusters, a ball
or an upright roll is laid around each cluster, and a Kalman filter for a constant velocity follows each of them. What
moves faster than the filter's own uncertainty is reported, by balls that hold it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crosstrack.protocols import Map
from crosstrack.sense.clusters import Blob, blobs_of
from crosstrack.sense.pose import axes, hits, turned_all
from crosstrack.sense.views import View, surprises, view_of
from crosstrack.types import ALONE, Array, Others, Scan, State

MARGIN = 0.2
"""m, how far beyond a point rays must have gone for it to have been free"""
MAPPED = 0.2
"""m, from an obstacle that is known or from the ground, within which a point belongs to it"""
AGES = (0.35, 1.0)
"""s, how old the scans that a scan is compared with should be"""
OLDEST = 1.1
"""s, how old they may be"""
SPACING = 0.09
"""s, at least between two of a sensor that are kept"""
GATE = 0.8
"""m, at most between where a thing is expected and where it is seen"""
UNREST = 1.5
"""m/s², standard deviation of the acceleration of what moves"""
FASTEST = 2.0
"""m/s, standard deviation of the velocity of what was seen once"""
SLOWEST = 0.4
"""m/s, what is slower counts as standing still"""
SIGNIFICANCE = 3.0
"""standard deviations by which a velocity must exceed 0"""
SIGHTINGS = 4
"""scans that must have seen a thing before it is reported"""
FORGOTTEN = 0.6
"""s without a sighting, after which a thing is dropped"""


@dataclass(frozen=True, eq=False)
class Track:
    """One thing followed from scan to scan, as estimated at one instant."""

    time: float
    """s"""
    position: Array
    """(3,) m, world"""
    velocity: Array
    """(3,) m/s, world"""
    variance: tuple[float, float, float]
    """m², m²/s, m²/s², of position, both, and velocity, the same along every axis"""
    radius: float
    """m"""
    rise: float
    """m, half of the height beyond that of a ball"""
    seen: float
    """s, when it was seen last"""
    sightings: int = 1
    """scans that saw it"""
    moving: bool = False
    """whether it has been found to move"""


@dataclass(frozen=True, eq=False)
class Memory:
    """What is kept from scan to scan."""

    views: tuple[View, ...] = ()
    """of the last second, in order of time"""
    tracks: tuple[Track, ...] = ()


@dataclass(frozen=True, eq=False)
class Movers:
    """Find what moves in the scans of a vehicle that knows where it is itself."""

    told: Map
    """what it knows of the world, which stands still"""

    def start(self) -> Memory:
        """Return the memory to begin with."""
        return Memory()

    def step(self, memory: Memory, scan: Scan, state: State) -> Memory:
        """Take in a scan that was made in a state."""
        turned = axes(state.attitude)
        origin, directions = state.position + turned @ scan.origin, turned_all(turned, scan.directions)
        views = tuple(view for view in memory.views if scan.time - view.time <= OLDEST)
        points = hits(scan.ranges, directions, origin, self.told.ground + MAPPED)
        points = surprises(points, compared(views, scan.time), MARGIN)
        blobs = blobs_of(points[self.told.distance(points) > MAPPED], origin)
        tracks = followed([ahead(track, scan.time) for track in memory.tracks], blobs, scan.time)
        view = view_of(scan, origin, directions)
        if all(scan.time - old.time >= SPACING for old in views if old.beams == view.beams):
            views = (*views, view)
        return Memory(views, tracks)

    def others(self, memory: Memory, time: float) -> Others:
        """Return what moves at a time (s) soon after the last scan, as balls that hold it."""
        found = [balls(ahead(track, time)) for track in memory.tracks if track.moving]
        if not found:
            return ALONE
        position, velocity, radius = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return Others(position, velocity, radius, np.zeros(len(radius), dtype=bool))


def compared(views: Sequence[View], time: float) -> list[View]:
    """Return the views of each sensor nearest to `AGES` before a time (s), none younger than half of the first."""
    old = [view for view in views if time - view.time >= AGES[0] / 2]
    chosen = [
        min((view for view in old if view.beams == beams), key=lambda view: abs(time - view.time - age))
        for beams in {view.beams for view in old}
        for age in AGES
    ]
    return list({(view.beams, view.time): view for view in chosen}.values())


def ahead(track: Track, time: float) -> Track:
    """Return a track as expected at a later time (s), its uncertainty grown by white acceleration."""
    t = time - track.time
    pp, pv, vv = track.variance
    q = UNREST**2 * 0.1
    grown = (pp + 2 * t * pv + t * t * vv + q * t**3 / 3, pv + t * vv + q * t * t / 2, vv + q * t)
    return replace(track, time=time, position=track.position + t * track.velocity, variance=grown)


def followed(tracks: Sequence[Track], blobs: Sequence[Blob], time: float) -> tuple[Track, ...]:
    """Return the tracks after what was seen at a time (s): nearest pairs first, the rest begin or fade."""
    gaps = sorted(
        (float(np.linalg.norm(track.position - blob.position)), i, j)
        for i, track in enumerate(tracks)
        for j, blob in enumerate(blobs)
    )
    pairs: dict[int, int] = {}
    for gap, i, j in gaps:
        if gap <= GATE and i not in pairs and j not in pairs.values():
            pairs[i] = j
    kept = [
        corrected(track, blobs[pairs[i]]) if i in pairs else track
        for i, track in enumerate(tracks)
        if i in pairs or time - track.seen <= FORGOTTEN
    ]
    new = [begun(blob, time) for j, blob in enumerate(blobs) if j not in pairs.values()]
    return (*kept, *new)


def begun(blob: Blob, time: float) -> Track:
    """Return the track of what was seen once."""
    variance = (blob.noise**2, 0.0, FASTEST**2)
    return Track(time, blob.position, np.zeros(3), variance, blob.radius, blob.rise, time)


def corrected(track: Track, blob: Blob) -> Track:
    """Return a track after it was seen: the Kalman filter of position and velocity, and an average of the size."""
    pp, pv, vv = track.variance
    total = pp + blob.noise**2
    one, two = pp / total, pv / total
    off = blob.position - track.position
    velocity = track.velocity + two * off
    variance = ((1 - one) * pp, (1 - one) * pv, vv - two * pv)
    speed, sightings = float(np.linalg.norm(velocity)), track.sightings + 1
    sure = speed > max(SLOWEST, SIGNIFICANCE * math.sqrt(variance[2])) and sightings >= SIGHTINGS
    return replace(
        track,
        position=track.position + one * off,
        velocity=velocity,
        variance=variance,
        radius=track.radius + 0.3 * (blob.radius - track.radius),
        rise=track.rise + 0.3 * (blob.rise - track.rise),
        seen=track.time,
        sightings=sightings,
        moving=sure or (track.moving and speed > SLOWEST / 2),
    )


def balls(track: Track) -> tuple[Array, Array, Array]:
    """Return centres (n, 3), velocities (n, 3) and radii (n,) of balls one above another that hold a thing."""
    radius = track.radius + 2 * math.sqrt(track.variance[0])
    if track.rise < radius / 2:
        return track.position[None], track.velocity[None], np.array([radius + track.rise])
    count = 1 + math.ceil(track.rise / radius)
    heights = track.rise * np.linspace(-1, 1, count)
    position = track.position + heights[:, None] * np.array([0.0, 0.0, 1.0])
    return position, np.tile(track.velocity, (count, 1)), np.full(count, radius)
