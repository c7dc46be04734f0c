"""Solve the table of what a nodule adds to the force: `python -m sim_sensors.tissue.make_contrast FILE.npz`.

It takes some minutes on one processor. The table is part of the repository; make it again after a change of the solver.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim_sensors.tissue.finite_elements import POISSON, Body, punch_compliance
from sim_sensors.tissue.layer import half_space_compliance, layer_share

COVERS = np.geomspace(0.1, 3.75, 9)
"""Tissue over the nodule, diameters."""
BENEATH = (0.15, 0.6, 2.5, 13.5)
"""Tissue between the nodule and the base, diameters."""
RADII = (0.05, 0.11, 0.24, 0.5, 0.85, 1.45)
"""Radii of the punch, diameters."""
RATIOS = (1.0, 1.6, 3.0, 7.0, 20.0)
"""Young's modulus of the nodule over that of its surroundings."""
SPREADS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.3, 1.7, 2.2, 3.0, 4.5)
"""Distance of the punch from the nodule's axis, in half (diameter + cover + radius). At the last one the nodule
is not felt."""
FINENESS = 0.7
"""Density of the mesh. The compliance that a nodule takes away is then 2 to 4 % above that of a mesh three times as
dense."""


def solve() -> dict[str, NDArray[np.float32]]:
    """Return the coordinates and the share of the compliance that the nodule takes away, 0..1."""
    share = np.zeros((len(COVERS), len(BENEATH), len(RADII), len(RATIOS), len(SPREADS)))
    for i, cover in enumerate(COVERS):
        for j, beneath in enumerate(BENEATH):
            body = Body(float(cover), beneath)
            punches = [(a, 0.5 * (1.0 + cover + a) * spread) for a in RADII for spread in SPREADS[:-1]]
            harmonics = 6 if cover < 0.4 else 4
            found = punch_compliance(body, RATIOS, punches, fineness=FINENESS, harmonics=harmonics)
            taken = (found[0] - found).reshape(len(RATIOS), len(RADII), len(SPREADS) - 1)
            whole = [half_space_compliance(a, POISSON) * layer_share(a, body.layer, POISSON) for a in RADII]
            share[i, j, :, :, :-1] = np.moveaxis(taken / np.array(whole)[:, None], 0, 1)
            print(f"cover {cover:.2f}, beneath {beneath}", file=sys.stderr, flush=True)
    named = {"cover": COVERS, "beneath": BENEATH, "radius": RADII, "ratio": RATIOS, "spread": SPREADS, "share": share}
    return {name: np.asarray(values, dtype=np.float32) for name, values in named.items()}


if __name__ == "__main__":
    np.savez_compressed(Path(sys.argv[1]), **solve())  # type: ignore[arg-type]
