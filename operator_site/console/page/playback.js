// Plays a recording: play, pause, speed, and a slider with alarms and findings as ticks.
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
  byId("speed").addEventListener("change", () => { if (now.state.session.playback?.playing) ask("play", { speed: Number(byId("speed").value) }); });
  byId("slider").addEventListener("input", () => seek(byId("slider").valueAsNumber));
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
  const played = now.state ? now.state.session.playback : null;
  byId("playback").hidden = !played;
  if (!played) return;
  const slider = byId("slider");
  slider.max = String(played.length_s);
  if (performance.now() - movedAt_ms > HELD_MS) slider.value = String(played.at_s);
  const where = WORDS.position(played.at_s, played.length_s), state = now.picture ? ` · ${STATES[OF_LINK[now.picture.state]]}` : "";
  write(byId("played"), where + state);
  slider.setAttribute("aria-valuetext", where);
  write(byId("play-button"), played.playing ? WORDS.pausePlay : WORDS.play);
  if (document.activeElement !== byId("speed")) byId("speed").value = String(SPEEDS.includes(played.speed) ? played.speed : 1);
  remake(byId("ticks"), [played.marks, played.length_s], () => played.marks.map(mark => {
    const tick = make("span", { class: mark.kind, title: mark.text });
    tick.style.left = `${100 * mark.at_s / played.length_s}%`;
    return tick;
  }));
}

// Handles a key of the playback; returns whether it was one.
export function playbackKey(event) {
  const played = now.state.session.playback, at_s = byId("slider").valueAsNumber, step_s = event.shiftKey ? 10 : 1;
  const marks = played.marks.map(mark => mark.at_s).sort((a, b) => a - b);
  const jumps = {
    ArrowLeft: at_s - step_s, ArrowRight: at_s + step_s, Home: 0, End: played.length_s,
    "[": marks.filter(mark => mark < at_s - 0.5).at(-1) ?? 0, "]": marks.find(mark => mark > at_s + 0.1) ?? played.length_s,
  };
  if (event.key === " " && !event.repeat) play();
  else if (Object.hasOwn(jumps, event.key)) seek(jumps[event.key]);
  else return false;
  event.preventDefault();
  return true;
}
