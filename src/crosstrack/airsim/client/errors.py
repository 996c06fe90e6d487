"""What a server answers when it does not do what it was asked."""

from crosstrack.errors import CrosstrackError


class RemoteError(CrosstrackError):
    """The server answered with an error.

    Args:
        method: what was called, as on the wire
        message: what the server says
    """

    def __init__(self, method: str, message: str) -> None:
        self.method = method
        self.message = message
        super().__init__(f"{method}: {message}")
