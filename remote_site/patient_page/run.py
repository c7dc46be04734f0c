"""Runs the process of the patient's page."""

import logging
from collections.abc import Callable
from contextlib import ExitStack
from importlib import resources
from pathlib import Path

from common.config.page_models import PatientPageConfig
from common.runtime.containment import Containment
from common.runtime.status_file import StatusFile
from common.runtime.systemd_notify import Supervisor
from common.web.access import Access
from common.web.guarded_page import GuardedPage
from common.web.page_server import Work, address_of, bound, serve_page
from remote_site.patient_page.patient_tablets import PatientTablets
from remote_site.patient_page.switch_line import SwitchLine
from remote_site.patient_page.tablet_switch import TabletSwitch

log = logging.getLogger(__name__)

PAGE = Path(str(resources.files("remote_site"))) / "patient_page" / "page"

_STEP_S = 0.004
"""Time between two looks at the site's line, s; less than half a report's time, so that no report is left out."""


def run_patient_page(config: PatientPageConfig, stop: Callable[[], bool]) -> None:
    """Serve the patient's page until `stop()`.

    Raises:
        ValueError, OSError: the access settings are unsafe, or a port is in use.
    """
    access, switch = Access(config), TabletSwitch(slider=config.slider)
    with ExitStack() as opened:
        line = SwitchLine(config.switch_port)
        opened.callback(line.close)
        socket = opened.enter_context(bound(config))
        tablets = PatientTablets(switch, lambda: line.connected, Containment())
        page = GuardedPage(access, PAGE)
        app = page.application(page.websocket("/patient", tablets.serve))
        status = StatusFile(config.status, "patient-page")
        about = {"address": address_of(config, socket), "switch": f"socket://127.0.0.1:{line.port}"}
        log.info("the page is at %s, the switch at %s", about["address"], about["switch"])

        def each_second() -> None:
            figures = {"pages": tablets.present, "site": line.connected, "counts": dict(tablets.counts)}
            status.write(0.0, {**about, **figures, "contained": dict(tablets.contain.places)})
            supervisor.alive(f"{tablets.present} pages")

        with Supervisor() as supervisor:
            supervisor.ready()
            work = Work(stop, lambda now_s: line.step(now_s, switch.report(now_s)), _STEP_S, each_second)
            serve_page(app, config, socket, tablets.contain, work)
