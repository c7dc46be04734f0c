"""Figures of panels: each function gets its axes and the data, line by line."""

from pathlib import Path

from matplotlib.axes import Axes

from studies.drawing import Data, draw_panels


def test_panels_are_drawn_line_by_line(tmp_path: Path) -> None:
    drawn: list[tuple[int, str]] = []

    def left(axes: Axes, data: Data) -> None:
        drawn.append((axes.get_subplotspec().num1, data["name"]))  # type: ignore[union-attr]

    def right(axes: Axes, data: Data) -> None:
        drawn.append((axes.get_subplotspec().num1, data["name"] + ", right"))  # type: ignore[union-attr]

    draw_panels({"name": "made"}, tmp_path / "figure.png", (2.0, 1.0), ((left, right), (left, right)))
    assert drawn == [(0, "made"), (1, "made, right"), (2, "made"), (3, "made, right")]
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")
