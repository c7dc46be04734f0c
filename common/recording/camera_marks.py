"""Names the recorded request by which a page registers the camera's picture with the map."""

from collections.abc import Mapping

from common.files.constants import within

VERB = "camera_marks"
MARKS = 4
"""Number of marks. The details of the request have u, v, x and y of each, such as `u1`: its place in the picture, as
parts of width and height from the top left corner, 0..1; and its place on the map, mm."""
_MOST_MM = 10_000.0


def are_marks(details: Mapping[str, object]) -> bool:
    """Return whether the details of a request are the marks of a registration."""
    limits = {"u": (0.0, 1.0), "v": (0.0, 1.0), "x": (-_MOST_MM, _MOST_MM), "y": (-_MOST_MM, _MOST_MM)}
    return all(
        within(details.get(f"{name}{number}"), *between)
        for number in range(1, MARKS + 1)
        for name, between in limits.items()
    )
