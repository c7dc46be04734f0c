"""Messages as the camera's process sends them."""

from common.wire.camera_messages import CameraState, PictureHeader

CONTENT = b"vp8"


def header(sequence: int, time_ns: int, **changed: object) -> PictureHeader:
    """The header of a key picture that answers nothing."""
    usual: dict[str, object] = {
        "sent_ns": time_ns, "asked_ns": 0, "heard_ns": 0, "state": CameraState.SHOWING, "rung": 0, "is_key": True,
        "width": 160, "height": 96,
    }  # fmt: skip
    return PictureHeader(0, sequence, time_ns, **(usual | changed))  # type: ignore[arg-type]


def message(sequence: int, time_ns: int, content: bytes = CONTENT, **changed: object) -> list[bytes]:
    """A picture with its header."""
    return [header(sequence, time_ns, **changed).encode(), content]
