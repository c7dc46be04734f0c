"""Margins in inches and the axes that the report's figures share."""

from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from teletaction.session_curves import SessionCurves

WIDTH_IN = 11.5
_TIME = "time since both sites engaged (s)"


class Margins:
    """Margins in inches, which a figure of any height keeps, and the legend in the upper one."""

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
        """One line of keys at the top left."""
        self._figure.legend(
            handles=handles,
            loc="upper left",
            bbox_to_anchor=(self._left, 1.0),
            ncols=len(handles),
            borderaxespad=0.2,
            columnspacing=1.4,
            handlelength=1.8,
        )


def end_time_axis(axes: Axes, session: SessionCurves) -> None:
    """The session's time below the lowest panel."""
    axes.set_xlim(*session.shown_s)
    axes.set_xlabel(_TIME)


def nothing_recorded(session: SessionCurves, *fields: tuple[str, str]) -> bool:
    """Whether none of these fields (series, name) has a value for a finger in use."""
    return all(
        session.curve(getattr(session.data, series), name, finger) is None
        for series, name in fields
        for finger in session.fingers
    )
