"""Decodes pictures of the camera's stream, and writes one as a still picture: a JPEG file.

PyAV (`av`, the extra `camera`) decodes. It is imported with the first decoder, because few processes need it.
"""

from collections.abc import Sequence
from functools import cache
from importlib.util import find_spec
from io import BytesIO
from typing import TYPE_CHECKING

from operator_site.console.camera.camera_picture import Picture

if TYPE_CHECKING:
    import av

_QUALITY = 85


@cache
def can_decode() -> bool:
    """Return whether the library that decodes is installed."""
    return find_spec("av") is not None


class PictureDecoder:
    """Decodes one stream, in one thread."""

    def __init__(self) -> None:
        """Open the codec.

        Raises:
            ModuleNotFoundError: the extra `camera` is not installed.
        """
        import av  # noqa: PLC0415 - an extra

        self._av = av
        self._codec = av.VideoCodecContext.create("vp8", "r")
        self._codec.thread_count = 1

    def decode(self, pictures: Sequence[Picture]) -> "av.VideoFrame":
        """Decode pictures that follow each other, and return the last one.

        Raises:
            ValueError: a picture is damaged or empty, or there is none.
        """
        if not all(picture.content for picture in pictures):  # to the codec, an empty one ends the stream
            raise ValueError("an empty picture")
        frames = [frame for picture in pictures for frame in self._codec.decode(self._av.Packet(picture.content))]
        if not frames:
            raise ValueError("no picture was decoded")
        return frames[-1]


def jpeg_of(frame: "av.VideoFrame") -> bytes:
    """Return a decoded picture as a JPEG file."""
    file = BytesIO()
    frame.to_image().save(file, "JPEG", quality=_QUALITY)  # type: ignore[no-untyped-call]
    return file.getvalue()
