// Plays a recording: play, pause, speed, and a slider under a time line with states, findings, alarms and faults.
import { ask } from "./actions.js";
import { byId, make, onChoice, remake, shape, write } from "./dom.js";
import { now, playback } from "./now.js";
import { OF_LINK } from "./shown.js";
import { STATES, WORDS } from "./words.js";

const SPEEDS = [0.5, 1, 2, 4, 8], HELD_MS = 400, NEAR_PX = 24, LABEL_PX = 100;
let movedAt_ms = -Infinity, chosen = false; // a speed for the next play

export function startPlayback() {
  byId("speed").append(...SPEEDS.map(speed => make("option", { value: speed, text: `${speed} ×` })));
  byId("play-button").addEventListener("click", play);
  onChoice(byId("speed"), speed => { if (now.state.session.playback?.playing) ask("play", { speed: Number(speed) }); else chosen = true; });
  byId("slider").addEventListener("input", () => seek(byId("slider").valueAsNumber));
  const line = byId("ticks");
  line.addEventListener("pointermove", event => describe(nearest(event)));
  line.addEventListener("pointerleave", () => describe(null));
  line.addEventListener("click", event => { const mark = nearest(event); if (mark) jump(mark); });
  line.addEventListener("focus", () => describe(now.state.session.playback?.marks.filter(mark => mark.at_s <= byId("slider").valueAsNumber + 0.1).at(-1)));
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

function jump(mark) {
  seek(mark.at_s);
  describe(mark);
}

// Jumps to the moment at which a finding was marked. Each examination of a recording numbers its findings from 1.
export function jumpToFinding({ id, at_s }) {
  const mark = now.state.session.playback.marks.findLast(found => found.kind === "finding" && found.text.startsWith(`${id}: `) && found.at_s <= at_s + 0.01);
  if (mark) jump(mark);
}

const textOf = mark => (mark.kind === "mode" ? STATES[mark.text] ?? mark.text : mark.text);

// Shows what a mark is, and when.
function describe(mark) {
  write(byId("mark-said"), mark ? WORDS.marked(mark.at_s, WORDS.markKinds[mark.kind], textOf(mark)) : "");
}

function nearest(event) {
  const { marks, length_s } = now.state.session.playback, box = byId("ticks").getBoundingClientRect();
  const far = mark => Math.abs(box.left + box.width * mark.at_s / length_s - event.clientX);
  const best = marks.reduce((found, mark) => (found === null || far(mark) < far(found) ? mark : found), null);
  return best && far(best) <= NEAR_PX ? best : null;
}

export function showPlayback() {
  const played = now.state ? now.state.session.playback : null;
  byId("playback").hidden = !played;
  if (!played) return;
  const slider = byId("slider"), { marks, length_s } = played;
  slider.max = String(length_s);
  if (performance.now() - movedAt_ms > HELD_MS) slider.value = String(played.at_s);
  const where = WORDS.position(played.at_s, length_s), state = now.picture ? ` · ${STATES[OF_LINK[now.picture.state]]}` : "";
  write(byId("played"), `${where}${state}${played.partial ? ` · ${WORDS.partial}` : ""}`);
  slider.setAttribute("aria-valuetext", where);
  write(byId("play-button"), played.playing ? WORDS.pausePlay : WORDS.play);
  chosen &&= !played.playing;
  if (!chosen && document.activeElement !== byId("speed")) byId("speed").value = String(SPEEDS.includes(played.speed) ? played.speed : 1);
  const wide = byId("ticks").clientWidth;
  remake(byId("ticks"), [marks, length_s, wide], () => labelled(marks, length_s, wide));
  remake(byId("modes"), [marks, length_s, wide], () => spans(marks.filter(mark => mark.kind === "mode"), length_s, wide));
}

// A mark has its shape, and its word where there is room.
function labelled(marks, length_s, wide) {
  const shown = marks.filter(mark => mark.kind !== "mode");
  return shown.map((mark, at) => {
    const room = ((shown[at + 1]?.at_s ?? length_s) - mark.at_s) / length_s * wide > LABEL_PX;
    const tick = make("span", { class: mark.kind }, shape(mark.kind), ...(room ? [make("span", { text: mark.kind === "finding" ? textOf(mark).split(",")[0] : WORDS.markKinds[mark.kind] })] : []));
    tick.style.left = `${100 * mark.at_s / length_s}%`;
    return tick;
  });
}

// A state lasts until the next one; its word stands where there is room.
function spans(modes, length_s, wide) {
  return modes.map((mode, at) => {
    const share = ((modes[at + 1]?.at_s ?? length_s) - mode.at_s) / length_s;
    const span = make("span", { class: mode.text, text: share * wide > LABEL_PX ? textOf(mode) : "" });
    span.style.left = `${100 * mode.at_s / length_s}%`;
    span.style.width = `${100 * share}%`;
    return span;
  });
}

// Handles a key of the playback; returns whether it was one.
export function playbackKey(event) {
  const played = now.state.session.playback, at_s = byId("slider").valueAsNumber, step_s = event.shiftKey ? 10 : 1;
  const steps = { ArrowLeft: at_s - step_s, ArrowRight: at_s + step_s }, onMap = document.activeElement.matches("#map-view canvas"); // its arrows move the cursor
  const jumps = { ...(onMap ? {} : steps), Home: 0, End: played.length_s };
  const mark = { "[": played.marks.filter(found => found.at_s < at_s - 0.5).at(-1), "]": played.marks.find(found => found.at_s > at_s + 0.1) };
  if (event.key === " " && !event.repeat) play();
  else if (event.key in mark) { seek(mark[event.key]?.at_s ?? (event.key === "[" ? 0 : played.length_s)); describe(mark[event.key]); }
  else if (Object.hasOwn(jumps, event.key)) seek(jumps[event.key]);
  else return false;
  event.preventDefault();
  return true;
}
