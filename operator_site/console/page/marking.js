// Marks a finding: time and place of the key press, then kind, place and save.
import { byId, make, write } from "./dom.js";
import { acts, live, now } from "./now.js";
import { fingerPlace, moved } from "./map.js";
import { expect } from "./notes.js";
import { FINGER_NAMES, FINGERS, KINDS, WORDS } from "./words.js";

let connection = null, say = null, finding = null, saving = false;

export function startMarking(link, speak) {
  connection = link;
  say = speak;
  KINDS.forEach((kind, at) => {
    const button = make("button", { "aria-pressed": "false" }, `${kind} `, make("kbd", { text: at + 1 }));
    button.addEventListener("click", () => choose(at));
    byId("kinds").append(button);
  });
  byId("marking").tabIndex = -1;
  byId("finding-button").addEventListener("click", begin);
  byId("finding-save").addEventListener("click", save);
  byId("finding-discard").addEventListener("click", discard);
}

export function marked() {
  return finding;
}

export function begin() {
  if (!acts() || !live() || finding) return;
  const place = fingerPlace();
  finding = { finger: FINGERS[now.active], at_s: now.picture.time_s, x_mm: place ? Math.round(place.x) : null, y_mm: place ? Math.round(place.y) : null, kind: null };
  byId("marking").hidden = false;
  showMarking();
  byId("marking").focus({ preventScroll: false });
}

export function choose(at) {
  finding.kind = KINDS[at];
  showMarking();
}

export function moveTo(place) {
  if (!finding) return;
  finding.x_mm = Math.round(place.x);
  finding.y_mm = Math.round(place.y);
  showMarking();
}

export function discard() {
  finding = null;
  byId("marking").hidden = true;
  byId("finding-button").focus();
}

// A finding that the console did not take stays open.
export async function save() {
  if (!finding || saving) return;
  saving = true;
  const details = { finger: finding.finger, at_s: finding.at_s, kind: finding.kind };
  if (finding.x_mm !== null) Object.assign(details, { x_mm: finding.x_mm, y_mm: finding.y_mm });
  const answer = await connection.ask("finding", details);
  saving = false;
  say(answer.text);
  if (!answer.ok) return;
  expect(answer.details.id, finding.kind ?? "");
  discard();
}

// Handles the keys that have another meaning while a finding is marked; returns whether it used one.
export function markingKey(event) {
  if (!finding) return false;
  const step = moved(event), onButton = document.activeElement?.matches("button, select, a");
  if (step) {
    const from = finding.x_mm === null ? fingerPlace() ?? { x: 0, y: 0 } : { x: finding.x_mm, y: finding.y_mm };
    moveTo({ x: from.x + step.x, y: from.y + step.y });
  } else if (event.repeat) return false;
  else if (/^[1-6]$/.test(event.key)) choose(Number(event.key) - 1);
  else if (event.key === "Enter" && !onButton) save();
  else if (event.key === "Backspace") discard();
  else return false;
  event.preventDefault();
  return true;
}

export function showMarking() {
  if (!finding) return;
  const name = FINGER_NAMES[FINGERS.indexOf(finding.finger)];
  write(byId("marking-title"), WORDS.findingAt(name, finding.x_mm, finding.y_mm ?? 0));
  [...byId("kinds").children].forEach((button, at) => button.setAttribute("aria-pressed", String(KINDS[at] === finding.kind)));
}
