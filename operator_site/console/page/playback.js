// A recording: play, pause, speed, and a slider with alarms and findings as ticks.
import { ask } from "./actions.js";
import { byId, make, remake, write } from "./dom.js";
import { now, playback } from "./now.js";
import { OF_LINK } from "./shown.js";
import { STATES, WORDS } from "./words.js";

const SPEEDS = [0.5, 1, 2, 4, 8], HELD_MS = 400;
let movedAt_ms = -Infinity;

export function startPlayback() {
  byId("speed").append(...SPEEDS.map(speed => make("option", { value: speed, text: `${speed} ×` })));
  byId("play-button").addEventListener("click", play);
  byId("speed").addEventListener("change", () => { const told = now.state.session.playback; if (told && told.playing) ask("play", { speed: Number(byId("speed").value) }); });
  byId("slider").addEventListener("input", () => { movedAt_ms = performance.now(); ask("seek", { at_s: Number(byId("slider").value) }); });
}

export function play() {
  if (!playback()) return;
  if (now.state.session.playback.playing) ask("pause");
  else ask("play", { speed: Number(byId("speed").value) });
}

function seek(at_s) {
  movedAt_ms = performance.now();
  const { length_s } = now.state.session.playback, at = Math.min(length_s, Math.max(0, at_s));
  byId("slider").value = String(at);
  ask("seek", { at_s: at });
}

export function showPlayback() {
  const told = now.state ? now.state.session.playback : null;
  byId("playback").hidden = !told;
  if (!told) return;
  const slider = byId("slider");
  slider.max = String(told.length_s);
  if (performance.now() - movedAt_ms > HELD_MS) slider.value = String(told.at_s);
  const where = WORDS.position(told.at_s, told.length_s), state = now.picture ? ` · ${STATES[OF_LINK[now.picture.state]]}` : "";
  write(byId("played"), where + state);
  slider.setAttribute("aria-valuetext", where);
  write(byId("play-button"), told.playing ? WORDS.pausePlay : WORDS.play);
  if (document.activeElement !== byId("speed")) byId("speed").value = String(SPEEDS.includes(told.speed) ? told.speed : 1);
  remake(byId("ticks"), [told.marks, told.length_s], () => told.marks.map(mark => {
    const tick = make("span", { class: mark.kind, title: mark.text });
    tick.style.left = `${100 * mark.at_s / told.length_s}%`;
    return tick;
  }));
}

// True where the key was one of playback's.
export function playbackKey(event) {
  const told = now.state.session.playback, at_s = byId("slider").valueAsNumber, step_s = event.shiftKey ? 10 : 1;
  const marks = told.marks.map(mark => mark.at_s).sort((a, b) => a - b);
  if (event.key === " " && !event.repeat) play();
  else if (event.key === "ArrowLeft") seek(at_s - step_s);
  else if (event.key === "ArrowRight") seek(at_s + step_s);
  else if (event.key === "[") seek(marks.filter(mark => mark < at_s - 0.5).at(-1) ?? 0);
  else if (event.key === "]") seek(marks.find(mark => mark > at_s + 0.1) ?? told.length_s);
  else if (event.key === "Home") seek(0);
  else if (event.key === "End") seek(told.length_s);
  else return false;
  event.preventDefault();
  return true;
}
