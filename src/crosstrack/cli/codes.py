"""The exit codes of every verb."""

DONE, BAD_INPUT, NOT_ARRIVED, COLLIDED, LINK_LOST, INTERRUPTED = 0, 2, 3, 4, 5, 130
