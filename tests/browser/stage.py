"""A stage for the page: a server that speaks the console's websocket with made-up data, and does what a test says."""

import asyncio
import itertools
import json
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import uvicorn
from starlette.types import Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from common.config.page_models import ConsoleConfig
from common.runtime.containment import Containment
from common.web.access import Access, Visitor
from common.web.guarded_page import REFUSED
from common.wire.voice_messages import FRAME_S
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.state.frame import Kind
from operator_site.console.state.signals import BINS, SPAN_S
from operator_site.console.texts import looks_like_a_name
from operator_site.console.voice.voice_sound import VoiceSound
from operator_site.console.web.camera_pages import CameraPages
from operator_site.console.web.clients import CREDIT
from operator_site.console.web.clients import Client as ConsoleClient
from operator_site.console.web.pages import Pages
from operator_site.console.web.server import application
from operator_site.console.web.voice_pages import VoicePages
from tests.browser import synthetic
from tests.browser.synthetic import SCENARIOS, Scenario
from tests.vp8_stream import HEIGHT, HZ, WIDTH, pictures

STATE_S = 0.09
TILES_A_PICTURE = 4


class Client:
    """What the stage knows of one page."""

    def __init__(self, socket: WebSocket):
        self.socket = socket
        self.sent = 0
        self.drawn = 0
        self.most_under_way = 0
        self.sent_at: dict[int, float] = {}
        self.delays_s: list[float] = []
        self.tiles: list[tuple[int, int, int]] = []
        self.alive: list[dict[str, Any]] = []
        self.skipped = 0
        self.stops: set[int] = set()

    def ask_for_tiles(self, quantities: list[str]) -> None:
        """Whole maps of quantities, tile by tile."""
        numbers = [synthetic.QUANTITIES.index(quantity) for quantity in quantities]
        self.tiles = [(number, column, row) for number in numbers for row in range(8) for column in range(8)]


class Stage:
    """The server, in a thread of its own, on a free port of loopback."""

    def __init__(self, scenario: str = "connected"):
        self.scenario: Scenario = SCENARIOS[scenario]()
        self.clients: list[Client] = []
        self.connections = 0
        self.asks: list[dict[str, Any]] = []
        self.shown: list[dict[str, Any]] = []
        """Requests for quantities of the map."""
        self.answers: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {}
        self.accepts = True
        self.refuses = False
        """Whether connections are closed for want of a token."""
        self._started = time.monotonic()
        access = Access(ConsoleConfig(keys=Path()))
        self.camera = CameraPages(Containment())
        self.said: list[VoiceSound] = []
        """Sounds of the page in control."""
        holder = ConsoleClient(Visitor("console", "act"), "console", 0.0)
        self.voice = VoicePages(Containment(), lambda: holder, self.said.append)
        self.tone: list[bytes] = []
        """Sounds that the remote site says again and again while the scenario has a voice."""
        self.tone_old_s = 0.0
        """Delay of these sounds before they are relayed, s."""
        self.films = True
        """Whether the camera takes pictures while the scenario has one."""
        self._filming: asyncio.Task[None] | None = None
        self._speaking: asyncio.Task[None] | None = None
        self._app = application(access, cast(Pages, self), self.camera, self.voice, None)
        config = uvicorn.Config(
            self._serve,
            interface="asgi3",
            host="127.0.0.1",
            port=0,
            log_level="error",
            lifespan="off",
            ws="websockets-sansio",
            timeout_graceful_shutdown=1,
        )
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._server.run, daemon=True)

    def __enter__(self) -> "Stage":
        self._thread.start()
        while not self._server.started:
            time.sleep(0.01)
        return self

    def __exit__(self, *_: object) -> None:
        self._server.should_exit = True
        self._server.force_exit = True
        self._thread.join()
        self.camera.close()

    @property
    def url(self) -> str:
        """Where the page is."""
        port = self._server.servers[0].sockets[0].getsockname()[1]
        return f"http://127.0.0.1:{port}/"

    @property
    def now_s(self) -> float:
        """The site's clock, s."""
        return 24_000 * SPAN_S + time.monotonic() - self._started

    def show(self, scenario: str | Scenario) -> Scenario:
        """Send another state to all pages from now on."""
        self.scenario = SCENARIOS[scenario]() if isinstance(scenario, str) else scenario
        return self.scenario

    def cut(self) -> None:
        """Close every connection and accept none."""
        self.accepts = False
        self.close_all()

    def close_all(self) -> None:
        """Close every connection; the pages may come back."""
        self._on_loop(self._close_all())

    def mend(self) -> None:
        """Accept connections again."""
        self.accepts = True

    def answer_late(self, ask: dict[str, Any], details: dict[str, Any]) -> None:
        """Answer a request of the first page that had no answer yet."""
        answer = {"kind": "answer", "id": ask["id"], "ok": True, "text": "", "details": details}
        self._on_loop(self.clients[0].socket.send_text(json.dumps(answer)))

    def _on_loop(self, todo: Any) -> None:
        asyncio.run_coroutine_threadsafe(todo, self._loop).result(5)

    async def _close_all(self) -> None:
        for client in list(self.clients):
            await client.socket.close(REFUSED if self.refuses else 1001)

    async def _serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "websocket" and not self.accepts:
            await send({"type": "websocket.close"})
        else:
            await self._app(scope, receive, send)

    async def serve(self, socket: WebSocket, _: Visitor) -> None:
        """Serve one page, as `Pages.serve` does."""
        self._loop = asyncio.get_running_loop()
        self._filming = self._filming or asyncio.create_task(self._film())
        self._speaking = self._speaking or asyncio.create_task(self._speak())
        client = Client(socket)
        client.ask_for_tiles(["temperature"])
        self.clients.append(client)
        self.connections += 1
        sender = asyncio.create_task(self._send(client))
        try:
            while True:
                await self._take(client, json.loads(await socket.receive_text()))
        except (WebSocketDisconnect, RuntimeError):
            pass
        finally:
            sender.cancel()
            self.clients.remove(client)

    async def _film(self) -> None:
        """Show the test stream again and again, each picture captured when it is sent."""
        coded = pictures()
        for number in itertools.count(1):
            await asyncio.sleep(1.0 / HZ)
            while not (self.films and self.scenario.state["camera"]):
                await asyncio.sleep(0.01)
            is_key, content = coded[(number - 1) % len(coded)]
            self.camera.show(Picture(number, self.now_s, 0.001, is_key, WIDTH, HEIGHT, content))
            self.camera.step()

    async def _speak(self) -> None:
        """Say a sound every 20 ms, which began 20 ms before it is sent."""
        due_s = time.monotonic()
        for number in itertools.count(1):
            due_s = max(due_s + FRAME_S, time.monotonic() - 0.1)
            await asyncio.sleep(max(0.0, due_s - time.monotonic()))
            if self.tone and self.scenario.state["voice"]:
                captured_s = 24_000 * SPAN_S + due_s - FRAME_S - self.tone_old_s - self._started
                content = self.tone[number % len(self.tone)]
                self.voice.show(VoiceSound("from_remote", number, captured_s, 0.001, content))

    def _bin(self) -> int:
        return 24_000 + int((time.monotonic() - self._started) / SPAN_S)

    async def _send(self, client: Client) -> None:
        last_bin, sent_at, version, newest, since = 0, -1.0, 0, "", time.monotonic()
        while True:
            await asyncio.sleep(max(0.0, SPAN_S - (time.monotonic() - self._started) % SPAN_S))
            if not self.scenario.sends:
                continue
            scenario, number = self.scenario, self._bin()
            age_s = time.monotonic() - sent_at
            text = json.dumps(scenario.at(time.monotonic() - since)) if age_s > STATE_S else newest
            if text != newest or age_s > 1.0:
                version += 1
                newest, sent_at = text, time.monotonic()
                await client.socket.send_text(json.dumps(json.loads(text) | {"version": version}))
            if client.sent - client.drawn >= CREDIT:
                client.skipped += 1
                continue
            client.sent += 1
            client.most_under_way = max(client.most_under_way, client.sent - client.drawn)
            client.sent_at[client.sent] = time.monotonic()
            first = last_bin == 0
            bins = BINS if first else min(BINS, max(1, number - last_bin))
            kind = Kind.WHOLE if first else Kind.PICTURE
            await client.socket.send_bytes(synthetic.picture(client.sent, number, scenario, kind, bins))
            last_bin = number
            for quantity, column, row in client.tiles[:TILES_A_PICTURE]:
                await client.socket.send_bytes(synthetic.tile(quantity, column, row, version))
            del client.tiles[:TILES_A_PICTURE]

    async def _take(self, client: Client, message: dict[str, Any]) -> None:
        kind = message["kind"]
        if kind == "drawn":
            client.drawn = max(client.drawn, message["sequence"])
            client.delays_s.append(time.monotonic() - client.sent_at.pop(message["sequence"]))
        elif kind == "alive":
            client.alive.append(message)
        elif kind == "show":
            self.shown.append(message)
            client.ask_for_tiles([message["quantity"], *([message["second"]] if "second" in message else [])])
        elif kind == "ask":
            self.asks.append(message)
            again = message["verb"] == "estop" and message["id"] in client.stops
            act = (lambda _: {}) if again else self._answer
            answer = {"ok": True, "text": "", "details": {}} | self.answers.get(message["verb"], act)(message)
            if message["verb"] == "estop":
                client.stops.add(message["id"])
            if answer["ok"] is not None:
                await client.socket.send_text(json.dumps({"kind": "answer", "id": message["id"]} | answer))

    def _answer(self, ask: dict[str, Any]) -> dict[str, Any]:
        """What a console would do, near enough for a page."""
        verb, details, session = ask["verb"], ask["details"], self.scenario.state["session"]
        if self.scenario.state["you"]["role"] == "observe" and verb != "place" and not session["playback"]:
            return {"ok": False, "text": "OBSERVER. Control is at OR-2."}
        if verb == "begin":
            if looks_like_a_name(details["pseudonym"]):
                return {"ok": False, "text": "Use a study number, not a name."}
            session.update(pseudonym=details["pseudonym"], recording=True)
        elif verb == "engage":
            session["state"] = "engaged"
        elif verb == "disengage":
            session["state"] = "paused"
            return {"text": "PAUSED. Outputs neutral."}
        elif verb == "clutch":
            self.scenario.state["coupling"]["open"] = details["open"]
        elif verb == "scale":
            self.scenario.state["coupling"]["scale"] = details["scale"]
        elif verb == "estop":
            session["state"] = "stopped"
            self.scenario.state["stop"] = synthetic.stop_of(dict.fromkeys(synthetic.DEVICES, 0.06), late=False)
        elif verb == "clear_fault":
            session["state"] = "connected"
            self.scenario.state.update(stop=None, alarms=[])
        elif verb == "acknowledge":
            self.scenario.state["alarms"] = [alarm for alarm in self.scenario.state["alarms"] if not alarm["waits"]]
        elif verb == "end":
            session.update(
                state="connected",
                pseudonym=None,
                recording=False,
                saved={"text": "Saved: 12 min 41 s, 1 finding, 0 messages lost.", "report": "/report/P-0417.html"},
            )
        elif verb == "finding":
            findings = self.scenario.state["findings"]
            number = len(findings) + 1
            kind = details["kind"] or "other"
            findings.append(
                {"id": number, "note": "", "saved": True, "text": f"{kind}, 36.4 ± 0.2 °C"}
                | {"x_mm": None, "y_mm": None}
                | details
            )
            return {"text": f"Finding {number} saved: {kind}, 36.4 ± 0.2 °C.", "details": {"id": number, "saved": True}}
        elif verb in ("edit", "withdraw"):
            state = self.scenario.state
            found = next(found for found in state["findings"] if found["id"] == details["finding"])
            state["before"], state["undo"], state["changes"] = dict(found), found["id"], 1
            changed = {"withdrawn": details["reason"]} if verb == "withdraw" else details
            found.update({name: value for name, value in changed.items() if name != "finding"})
        elif verb == "undo":
            state = self.scenario.state
            found = next(found for found in state["findings"] if found["id"] == state["undo"])
            found.clear()
            found.update(state["before"])
            state["undo"], state["changes"] = None, 0
        elif verb == "propose":
            return {"details": synthetic.PROPOSED}
        elif verb == "note":
            found = next(found for found in self.scenario.state["findings"] if found["id"] == details["finding"])
            found["note"] = details["text"]
            return {"text": f"Note to finding {found['id']} saved."}
        elif verb == "sound":
            session["sound"] = details["answer"]
        elif verb == "take_control":
            self.scenario.state["you"] = {"role": "act", "in_control": True, "control": "console"}
        elif verb == "place":
            return {"details": {"text": "36.4 ± 0.2 °C, 14 touches, 92 s ago"}}
        elif verb == "seek":
            session["playback"]["at_s"] = details["at_s"]
        elif verb in ("play", "pause") and session["playback"]:
            session["playback"]["playing"] = verb == "play"
        return {}


def main() -> None:
    """Run the stage by hand; the state to show is typed in."""
    with Stage("engaged") as stage:
        print(stage.url)
        while name := input("state: "):
            stage.show(name)


if __name__ == "__main__":
    main()
