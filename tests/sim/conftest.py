"""Compiled functions compile in the first example, so examples are not timed."""

from hypothesis import settings

settings.register_profile("sim", deadline=None)
settings.load_profile("sim")
