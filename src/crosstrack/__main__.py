"""Run the command as `python -m crosstrack`."""

from crosstrack.cli import main

main()
