"""The tactile map of a recorded session, for Python programs."""

from typing import TYPE_CHECKING

from operator_site.console.map.tactile_map import QUANTITIES
from teletaction.api.recording import Recording
from teletaction.report.examination import Examination
from teletaction.report.map_figure import map_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_map(recording: Recording, quantity: str = "temperature") -> "Figure | None":
    """Draw the tactile map at the end of a session, with its findings.

    Args:
        recording: a recording of the operator site, or a merged `session.mcap`.
        quantity: `temperature` (C), `roughness` (V), `stiffness` (N/m) or `material`.

    Returns:
        The figure, in mm on the remote bench; None if the quantity was never measured.

    Raises:
        OSError: the file cannot be read.
        ValueError: there is no such quantity, or the recording is damaged.
    """
    if quantity not in QUANTITIES:
        raise ValueError(f"no quantity {quantity!r}; there are {', '.join(QUANTITIES)}")
    examination = Examination.read(recording.path)
    return map_figure(examination.felt, quantity, examination.findings.values())
