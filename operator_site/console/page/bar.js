// Region A: state, clocks, link, recording, and a mark that steps with every picture.
import { byId, write } from "./dom.js";
import { live, now, playback, shownState } from "./now.js";
import { clock, delay, linkMore, STATES, WORDS } from "./words.js";

const SHAPES = { fault: "stopped", stopping: "stopped", lost: "unknown" };
const MARK_STEPS = 4;
let steps = 0;

export function showBar() {
  const shown = shownState(), state = now.state;
  document.body.dataset.shown = shown;
  document.body.dataset.role = state ? state.you.role : "";
  document.body.dataset.connected = String(now.connected);
  document.body.dataset.playback = String(playback());
  write(byId("state-word"), STATES[shown]);
  write(document.querySelector("title"), `${STATES[shown]} · teletaction`);
  byId("state-shape").setAttribute("href", `#shape-${SHAPES[shown] ?? shown}`);
  byId("session-button").disabled = !state;
  if (!state) return;
  const session = state.session, isLive = live() && shown !== "unknown";
  const clock_s = session.playback ? session.playback.at_s : session.clock_s;
  write(byId("clock"), isLive && typeof clock_s === "number" ? clock(clock_s) : "--");
  write(byId("pseudonym"), session.pseudonym ?? WORDS.startSession);
  write(byId("delay"), isLive ? delay(state.link) : "--");
  write(byId("link-more"), linkMore(isLive ? state.link : null));
  write(byId("wall-clock"), (isLive && state.wall_clock) || "--");
  const recording = session.playback ? session.title ?? "" : session.recording ? WORDS.recording : WORDS.notRecording;
  write(byId("recording"), isLive ? recording : "--");
  byId("recording").className = session.recording ? "small" : "small off";
}

export function stepMark() {
  steps = (steps + 1) % MARK_STEPS;
  byId("mark-step").style.transform = `translateX(${steps * 100}%)`;
}
