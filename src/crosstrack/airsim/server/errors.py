"""What a handler raises, so that its client is told."""


class Refused(Exception):  # noqa: N818 - the caller is told no, the server is well
    """A call that cannot be done; the message is what AirSim says then."""
