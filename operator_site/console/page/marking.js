// Marks a finding: time and place of the key press, then kind, place and save. Edits one in the same tray. The console
// proposes the kind from the contrast with the surroundings, and says before saving where there is none.
import { ask, askSilently, say } from "./actions.js";
import { bodyText, openBody } from "./body.js";
import { byId, make, write } from "./dom.js";
import { controls, known, now } from "./now.js";
import { fingerPlace, moved } from "./map.js";
import { expect, openNote } from "./notes.js";
import { capital, FINGER_NAMES, FINGERS, KINDS, WORDS } from "./words.js";

const PROPOSE_MS = 250;
let withdraw = null, finding = null, proposed = null, asking = null;

export function startMarking(openWithdraw) {
  withdraw = openWithdraw;
  KINDS.forEach((kind, at) => {
    const button = make("button", { "aria-pressed": "false" }, `${kind} `, make("kbd", { text: at + 1 }));
    button.addEventListener("click", () => choose(at));
    byId("kinds").append(button);
  });
  byId("marking").tabIndex = -1;
  byId("finding-button").addEventListener("click", begin);
  byId("finding-save").addEventListener("click", save);
  byId("finding-discard").addEventListener("click", discard);
  byId("finding-body").addEventListener("click", chooseBody);
  byId("finding-note").addEventListener("click", () => leave(openNote));
  byId("finding-withdraw").addEventListener("click", () => leave(withdraw));
}

// The place is of the finding for which the diagram was opened.
function chooseBody() {
  const placed = finding;
  openBody(placed.body, body => { Object.assign(placed, { body, bodyChosen: true }); showMarking(); });
}

// Closes the tray and opens another one for the same finding.
function leave(open) {
  const { id } = finding;
  discard();
  open(id);
}

export function marked() {
  return finding;
}

export function begin() {
  if (!controls() || !known() || finding) return;
  if (!now.state.session.pseudonym) { say(WORDS.noSession); return; }
  const place = fingerPlace();
  finding = { finger: FINGERS[now.active], at_s: now.picture.time_s, x_mm: place ? Math.round(place.x) : null, y_mm: place ? Math.round(place.y) : null, kind: null };
  openTray();
}

export function edit(found) {
  if (!controls() || !known() || finding) return;
  finding = { id: found.id, finger: found.finger, x_mm: found.x_mm, y_mm: found.y_mm, kind: found.kind, body: found.body, chosen: true };
  openTray();
}

function openTray() {
  proposed = null;
  byId("marking").hidden = false;
  for (const id of ["finding-note", "finding-withdraw"]) byId(id).hidden = !finding.id;
  showMarking();
  propose();
  byId("marking").focus({ preventScroll: false });
}

// Asks for the contrast at the place, at most four times a second, until it is answered.
async function propose() {
  if (!finding || finding.x_mm === null || asking) return;
  const { x_mm, y_mm } = finding;
  asking = setTimeout(() => {
    asking = null;
    if (!proposed) propose();
  }, PROPOSE_MS);
  const answer = await askSilently("propose", { x_mm, y_mm });
  if (!finding || !answer.ok || finding.x_mm !== x_mm || finding.y_mm !== y_mm) return;
  proposed = answer.details;
  if (!finding.chosen) finding.kind = proposed.kind ?? null;
  showMarking();
}

export function choose(at) {
  if (byId("kinds").children[at].hidden) return;
  finding.kind = KINDS[at];
  finding.chosen = true;
  showMarking();
}

export function moveTo(place) {
  if (!finding) return;
  finding.x_mm = Math.round(place.x);
  finding.y_mm = Math.round(place.y);
  proposed = null; // the old one is of another place
  if (!finding.chosen) finding.kind = null;
  showMarking();
  propose();
}

export function discard() {
  const from = finding.id ? byId("found-list").querySelector(`[data-edit="${finding.id}"]`) : byId("finding-button");
  finding = null;
  byId("marking").hidden = true;
  if (from) { from.disabled = false; from.focus(); }
}

// A finding that the console did not take stays open, and so does one that was opened since.
export async function save() {
  if (!finding || finding.saving) return;
  const saved = finding;
  saved.saving = true;
  const { id, finger, at_s, kind, x_mm, y_mm, body } = finding, details = id ? { finding: id, kind } : { finger, at_s, kind };
  if (x_mm !== null) Object.assign(details, { x_mm, y_mm });
  if (finding.bodyChosen) details.body = body && { region: body.region, side: body.side, landmark: body.landmark, landmark_mm: body.landmark_mm };
  const answer = await ask(id ? "edit" : "finding", details);
  saved.saving = false;
  if (!answer.ok) return;
  if (!id) expect(answer.details.id, kind ?? "");
  if (finding === saved) discard();
}

// Handles the keys that have another meaning while a finding is marked; returns whether it used one.
export function markingKey(event) {
  if (!finding || document.activeElement?.closest(".sheet")) return false;
  const step = moved(event), onButton = document.activeElement?.matches("button, select, a");
  if (step) {
    const from = finding.x_mm === null ? fingerPlace() ?? { x: 0, y: 0 } : { x: finding.x_mm, y: finding.y_mm };
    moveTo({ x: from.x + step.x, y: from.y + step.y });
  } else if (event.repeat) return false;
  else if (/^[1-7]$/.test(event.key)) choose(Number(event.key) - 1);
  else if (event.key === "Enter" && !onButton) save();
  else if (event.key === "Backspace") discard();
  else return false;
  event.preventDefault();
  return true;
}

export function showMarking() {
  if (!finding) return;
  const { pseudonym } = now.state.session;
  if (pseudonym && (finding.study ??= pseudonym) !== pseudonym) { discard(); return; } // it is of another person
  const name = FINGER_NAMES[FINGERS.indexOf(finding.finger)];
  write(byId("marking-title"), `${WORDS.findingAt(name, finding.x_mm, finding.y_mm ?? 0, finding.id)}${finding.body ? `, ${bodyText(finding.body)}` : ""}`);
  write(byId("marking-contrast"), contrast());
  [...byId("kinds").children].forEach((button, at) => {
    button.setAttribute("aria-pressed", String(KINDS[at] === finding.kind));
    button.hidden = KINDS[at] === "tender" && !now.state?.patient?.agreed; // pain is recorded with consent only
  });
}

function contrast() {
  if (finding.x_mm === null || !proposed) return "";
  if (!(finding.kind in proposed.kinds)) return capital(proposed.text);
  const { text, confidence } = proposed.kinds[finding.kind];
  return `${finding.kind === proposed.kind ? WORDS.proposed(finding.kind) : capital(finding.kind)}: ${text}. ${WORDS.confident(confidence)}`;
}
