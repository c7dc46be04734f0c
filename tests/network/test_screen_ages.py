"""The ages of touch and picture on the screen of a session over a network, and their difference."""

import json
import sys
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from common.config.file import load_config
from common.config.page_models import ConsoleConfig
from common.limits import FROZEN_S
from robustness.fault_session import read_figures
from teletaction.session.demo_files import DemoOptions
from tests.browser.conftest import chromium
from tests.network.test_touch_first import NETWORKS
from tests.network.two_host_session import Delays, TwoHostSession

pytestmark = [pytest.mark.netns, pytest.mark.timeout(180)]

MEASURED_S = 20.0
"""Duration of each measurement, s."""
SESSION_S = 90.0
"""Duration of the exploration, which outlasts the measurement, s."""
FINGERS = 2


@pytest.mark.parametrize("network", ["lan", "mobile"])
def test_ages_of_touch_and_picture_on_the_screen(table: list[str], tmp_path: Path, network: str) -> None:
    pytest.importorskip("playwright", reason="playwright is not installed (group browser)")
    if chromium() is None:
        pytest.skip("no chromium: install it, or name it in CHROMIUM")
    (alone_ms, _), alone = watch(tmp_path / "alone", network, camera=False)
    (touch_ms, picture_ms), beside = watch(tmp_path / "beside", network, camera=True)
    shown = {
        "touch alone": alone_ms,
        "touch beside a picture": touch_ms,
        "picture": picture_ms,
        "picture less touch": picture_ms - touch_ms,
    }
    table.append(
        f"{network}, at 50 / 95 %, ms: "
        + ", ".join(f"{name} {np.percentile(of, 50):.0f} / {np.percentile(of, 95):.0f}" for name, of in shown.items())
    )
    late = ", ".join(f"{loop['late_p50_us']} / {loop['late_p99_us']}" for loop in (alone, beside))
    rung = read_figures(tmp_path / "beside", "camera")["rung"]
    table.append(f"{len(touch_ms) / MEASURED_S:.0f} repaints/s, camera's step {rung}; operator's loop late: {late} us")
    assert len(touch_ms) > MEASURED_S
    assert np.isfinite(picture_ms).all()
    assert np.percentile(picture_ms, 50) < 1e3 * FROZEN_S


def watch(out: Path, network: str, *, camera: bool) -> tuple[np.ndarray, dict[str, float]]:
    """Return the ages of touch and picture on the screen, ms, and the figures of the operator's loop."""
    out.mkdir()
    options = DemoOptions(seconds=SESSION_S, fingers=FINGERS, console=True, camera=camera)
    with ExitStack() as ends:
        session = TwoHostSession(ends, out, Delays(0.0, 0.0), options=options)
        session.hosts.impair(*NETWORKS[network])
        session.wait_for_script(1.0)
        port = load_config(out / "config" / "console.toml", ConsoleConfig).port
        address = f"http://127.0.0.1:{port}/"
        run = (sys.executable, "-m", "tests.network.screen_end", address, str(MEASURED_S), str(int(camera)))
        screen = session.hosts.operator.start(*run)
        assert screen.hear() == "shown"
        ages_ms = np.array(json.loads(screen.hear()), dtype=float).T
        session.end()
    return ages_ms, read_figures(out, "operator")["loop"]
