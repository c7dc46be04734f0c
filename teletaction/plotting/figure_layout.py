"""Defines width and margins of the report's figures, in inches."""

from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.figure import Figure

WIDTH_IN = 11.5
"""Width of a figure, inches."""


class Margins:
    """Margins in inches, the same at any figure height, with the legend in the top margin."""

    def __init__(
        self, figure: Figure, top_in: float = 0.4, right_in: float = 0.15, between_in: float = 0.12, rows: int = 1
    ) -> None:
        width_in, height_in = figure.get_size_inches()
        self._figure, self._left = figure, 1.05 / width_in
        inner_in = height_in - top_in - 0.5
        row_in = (inner_in - between_in * (rows - 1)) / rows
        self.grid = {
            "left": self._left,
            "right": 1 - right_in / width_in,
            "top": 1 - top_in / height_in,
            "bottom": 0.5 / height_in,
            "hspace": between_in / row_in,
        }

    def legend(self, handles: Sequence[Artist]) -> None:
        """Draw the legend as one line at the top left."""
        self._figure.legend(
            handles=handles,
            loc="upper left",
            bbox_to_anchor=(self._left, 1.0),
            ncols=len(handles),
            borderaxespad=0.2,
            columnspacing=1.4,
            handlelength=1.8,
        )
