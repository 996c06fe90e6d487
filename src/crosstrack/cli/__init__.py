"""The command `crosstrack`."""

from crosstrack.cli.app import main

__all__ = ["main"]
