// The first button: engage, pause, resume, clear. A request that drives fingers is held for 1 s or pressed twice.
import { byId, make, remake, write } from "./dom.js";
import { acts, controls, driven, known, lastState, live, now } from "./now.js";
import { open } from "./sheets.js";
import { FIXED, WORDS } from "./words.js";

const HOLD_MS = 1000, CONFIRM_MS = 5000, APART_MS = 500, STEP_MS = 50;
let connection = null, speak = null, held = null, confirming = null, begun = null; // what the button did when it was pressed

export function startActions(link, say) {
  connection = link;
  speak = say;
  const button = byId("act-button");
  button.addEventListener("pointerdown", () => { begun = current(); if (begun.hold) hold(begun.verb); });
  for (const kind of ["pointerup", "pointercancel", "pointerleave"]) button.addEventListener(kind, event => release(event.type === "pointerup"));
  button.addEventListener("click", event => {
    const act = current(), alone = event.detail === 0; // from the keyboard or assistive software
    if (act.hold) { if (alone) twice(act.verb); } else if (alone || act.text === begun?.text) act.press(); // a released hold is no press of what follows
  });
  button.addEventListener("contextmenu", event => event.preventDefault());
}

// Returns what the button does now; `hold` needs a held press or two presses.
function current() {
  const state = lastState();
  const nothing = { text: WORDS.engage, press: () => {}, disabled: true };
  if (!acts() || !live()) return nothing;
  if (now.stopPressed || (now.state.stop && !now.state.stop.confirmed)) return { ...nothing, text: WORDS.clear };
  if (state === "silent") return nothing;
  const elsewhere = controls() ? "" : WORDS.controlElsewhere(now.state.you.control);
  if (driven()) return { text: WORDS.pause, key: "P", press: pause, more: elsewhere, disabled: Boolean(elsewhere) };
  if (!known()) return nothing;
  if (elsewhere) return { text: FIXED.takeControl, more: elsewhere, press: () => ask("take_control") };
  if (clearable()) return { verb: "clear_fault", hold: true, text: WORDS.clear, confirm: WORDS.confirmClear, key: "C" };
  if (state === "disconnected") return nothing;
  if (!now.state.session.pseudonym) return { text: WORDS.startSession, press: () => open("sheet-session") };
  const paused = state === "paused";
  return { verb: "engage", hold: true, text: paused ? WORDS.resume : WORDS.engage, confirm: paused ? WORDS.confirmResume : WORDS.confirmEngage, key: "E" };
}

const clearable = () => ["fault", "stopped"].includes(lastState());
const possible = verb => current().verb === verb;

// Shows a text below the map for a moment.
export const say = text => speak(text);

export const askSilently = (verb, details) => connection.ask(verb, details);

// Asks the console and shows its answer.
export async function ask(verb, details) {
  const answer = await askSilently(verb, details);
  if (answer.text) say(answer.text);
  return answer;
}

export function pause() {
  if (controls() && driven()) ask("disengage");
}

// A held press fills the ring in 1 s. After a short press, a second one within 5 s counts, too.
export function hold(verb) {
  if (held || !possible(verb)) return;
  const started_ms = performance.now();
  held = { verb, timer: setInterval(() => {
    const share = (performance.now() - started_ms) / HOLD_MS;
    byId("act-button").style.setProperty("--held", `${Math.min(100, 100 * share)}%`);
    if (share >= 1) { end(); calm(); ask(verb); }
  }, STEP_MS) };
  byId("act-button").classList.add("hold");
}

export function release(counts = true) {
  if (!held) return;
  const { verb } = held;
  end();
  if (counts) twice(verb);
}

function end() {
  clearInterval(held.timer);
  held = null;
  byId("act-button").classList.remove("hold");
  byId("act-button").style.removeProperty("--held");
}

function twice(verb) {
  const at_ms = performance.now();
  if (confirming?.verb === verb) {
    if (at_ms - confirming.at_ms < APART_MS) return; // a double click is one press
    calm();
    ask(verb);
    return;
  }
  calm();
  confirming = { verb, at_ms, timer: setTimeout(() => { confirming = null; showActions(); }, CONFIRM_MS) };
  showActions();
}

// Takes the first of two presses back.
export function calm() {
  if (confirming) clearTimeout(confirming.timer);
  confirming = null;
}

export function showActions() {
  const act = current(), button = byId("act-button");
  // A press that began in one state does not count in another.
  if (confirming && !possible(confirming.verb)) calm();
  if (held && !possible(held.verb)) end();
  const text = confirming?.verb === act.verb ? act.confirm ?? act.text : act.text, key = act.key ?? "";
  const more = act.hold && !confirming ? WORDS.hold : act.more ?? "";
  remake(button, [text, key, more], () => {
    const parts = [make("span", { text })];
    if (key) parts.push(" ", make("kbd", { text: key }));
    if (more) parts.push(make("br"), make("span", { class: "small", text: more }));
    return parts;
  });
  button.disabled = Boolean(act.disabled);
  byId("finding-button").disabled = !controls() || !known() || !now.state.session.pseudonym;
  byId("note-button").disabled = !controls();
  write(byId("looking-on"), now.state?.you.role === "observe" ? WORDS.observer(now.state.you.control ?? "--") : "");
}
