"""A console with a camera: it relays and records the pictures, names a frozen one, and pauses where it is required."""

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from common.config.page_models import ConsoleCameraConfig, ConsoleConfig
from common.config.recording_models import ConsentConfig
from common.recording.reader import RecordingReader
from common.wire.camera_messages import CameraAsk
from operator_site.console import texts
from operator_site.console.alarms.alarm_rules import Surroundings
from operator_site.console.camera.camera import Camera
from operator_site.console.camera.camera_now import CameraNow, Seen
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.examination.journal import Journal
from operator_site.console.live import LiveConsole
from operator_site.console.web.page_state import refusal
from operator_site.session.console_feed import Fed
from tests.unit.operator_site.console.camera.made_pictures import message
from tests.unit.operator_site.console.fed import figures, rendered
from tests.unit.operator_site.console.page_room import STUDENT, AnsweringSite, Socket, settled

S = 1_000_000_000
AHEAD_S = 5.0
"""Lead of the site's clock, s."""


class Line:
    """A connection on which the test puts messages."""

    refused = False

    def __init__(self) -> None:
        self.waiting: list[list[bytes]] = []
        self.asked_ns = 0

    def receive(self) -> list[bytes]:
        return self.waiting.pop(0) if self.waiting else []

    def send(self, packet: bytes) -> None:
        self.asked_ns = CameraAsk.decode(packet).time_ns

    def reconnect(self) -> None:
        pass

    def close(self) -> None:
        pass


class Work:
    """A console on a clock of the test, an engaged site, and a camera whose clock is the console's."""

    def __init__(self, path: Path | None = None, **camera: Any) -> None:
        self.now_s, self.sequence, self.line, self.site = 100.0, 0, Line(), AnsweringSite()
        self.remote_consent: dict[str, list[str]] | None = {}
        self.site.answer = lambda: {"state": "engaged", "session": 7}
        consent = ConsentConfig(touch=True, pain=False, picture=True)
        config = ConsoleConfig(keys=Path(), record=path, consent=consent, camera=ConsoleCameraConfig(**camera))
        self.journal = Journal(path, {})
        required = bool(camera.get("required"))
        camera_seen = Camera(self.line, required=required, clock_ns=lambda: round(self.now_s * S))
        self.live = LiveConsole(config, self, self.site, self.journal, lambda: self.now_s, camera_seen)
        self.console = self.live.console

    def receive(self) -> Iterator[Fed]:
        site_ns = round((self.now_s + AHEAD_S) * S)
        yield Fed("operator/figures", site_ns, figures(remote_consent=self.remote_consent))
        yield Fed("operator/rendered", site_ns, rendered())

    async def go(self, seconds: float, *, films: bool = True) -> None:
        """Let time pass in steps of 20 ms, each with a picture that was captured 50 ms ago if the camera `films`."""
        for _ in range(round(seconds / 0.02)):
            self.now_s += 0.02
            if films and self.line.asked_ns:
                self.sequence += 1
                now_ns = round(self.now_s * S)
                asked_ns = self.line.asked_ns
                asked = {"asked_ns": asked_ns, "heard_ns": asked_ns + 10_000_000, "sent_ns": now_ns - 9_000_000}
                is_key = self.sequence % 30 == 1
                self.line.waiting.append(message(self.sequence, now_ns - 50_000_000, is_key=is_key, **asked))
            self.live.step(self.now_s)
            await asyncio.sleep(0.0)

    @property
    def alarms(self) -> dict[str, tuple[str, str]]:
        active = [alarm for alarm in self.console.alarms.listed if alarm.gone_s is None]
        return {alarm.ident: (alarm.cause.priority.name, alarm.text) for alarm in active}


def test_pictures_reach_pages_in_the_sites_time() -> None:
    async def watch() -> None:
        work, page = Work(), Socket()
        sent: list[bytes] = []

        async def keep(packed: bytes) -> None:
            sent.append(packed)

        page.send_bytes = keep  # type: ignore[method-assign]
        watching = asyncio.create_task(work.live.camera_pages.serve(page, STUDENT))
        await work.go(1.0)
        await settled(lambda: len(sent) == 4)  # the page draws none
        captured_s = work.live.console.site.heard_s - 1.0
        assert abs(memoryview(sent[0])[8:16].cast("d")[0] - captured_s) < 0.2
        assert work.console.around.camera is not None
        assert work.console.around.camera.seen is Seen.LIVE
        assert "camera" not in work.alarms
        assert work.site.asked.count("disengage") == 0
        watching.cancel()

    asyncio.run(watch())


@pytest.mark.parametrize("required", [False, True])
def test_a_frozen_picture_is_an_alarm_and_pauses_where_it_is_required(required: bool) -> None:
    async def watch() -> None:
        work = Work(required=required)
        await work.go(1.0)
        await work.go(0.35, films=False)
        assert "camera" not in work.alarms
        await work.go(0.27, films=False)
        act = "Session pauses." if required else "Do not rely on it."
        assert work.alarms["camera"] == ("MEDIUM" if required else "LOW", f"Picture frozen for 0.7 s. {act}")
        assert work.site.asked.count("disengage") == int(required)
        assert "estop" not in work.site.asked
        await work.go(1.0, films=False)
        assert work.site.asked.count("disengage") == (3 if required else 0)  # until the site has paused
        assert "No picture for" in work.alarms["camera"][1]
        work.site.answer = lambda: {"state": "connected", "session": 7}
        await work.go(0.2)
        assert "camera" not in work.alarms

    asyncio.run(watch())


@pytest.mark.parametrize("record", [False, True])
def test_pictures_are_recorded_only_where_the_configuration_says_so(tmp_path: Path, record: bool) -> None:
    async def watch() -> None:
        work = Work(tmp_path / "console.mcap", record=record)
        await work.go(1.0)
        work.journal.close()
        assert work.journal.unsaved == 0 or not record
        with (tmp_path / "console.mcap").open("rb") as file:
            reader = RecordingReader(tmp_path / "console.mcap", file)
            found = [
                (kept.log_time, Picture.of_record(kept.data)) for _, _, kept in reader.messages(["console/camera"])
            ]
        assert bool(found) == record
        for time_ns, picture in found:
            # Half of the way of 19 ms is unknown; the picture was 50 ms old.
            assert time_ns * 1e-9 - picture.captured_s == pytest.approx(0.05, abs=picture.uncertainty_s + 1e-6)
            assert picture.content == b"vp8"
        assert [picture.sequence for _, picture in found] == [*range(1, len(found) + 1)]

    asyncio.run(watch())


@pytest.mark.parametrize("consented", [None, {"consented": ["touch"]}])
def test_no_picture_is_recorded_against_the_remote_sites_answer_or_before_it(
    tmp_path: Path, consented: dict[str, list[str]] | None
) -> None:
    async def watch() -> None:
        work = Work(tmp_path / "console.mcap", record=True)
        work.remote_consent = consented
        await work.go(1.0)
        work.journal.close()
        with (tmp_path / "console.mcap").open("rb") as file:
            assert not [*RecordingReader(tmp_path / "console.mcap", file).messages(["console/camera"])]

    asyncio.run(watch())


@pytest.mark.parametrize("seen", Seen)
def test_engaging_waits_for_a_required_picture(seen: Seen) -> None:
    work = Work()
    work.console.around = Surroundings(sound="heard", camera=CameraNow(seen, 0.1, required=True))
    assert refusal(work.console) == ("" if seen is Seen.LIVE else texts.CAMERA_NEEDED)
    work.console.around = Surroundings(sound="heard", camera=CameraNow(seen, 0.1))
    assert refusal(work.console) == ""


@pytest.mark.parametrize("pauses", [False, True])
def test_every_text_of_the_picture_fits_into_an_alarm(pauses: bool) -> None:
    for seen in set(Seen) - {Seen.LIVE}:
        assert len(texts.camera(seen, 3599.9, pauses=pauses)) <= texts.LONGEST_ALARM
