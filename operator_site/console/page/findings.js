// The list of findings, always in view, the newest first: jump, edit, withdraw with a reason, undo.
import { ask } from "./actions.js";
import { byId, make, once, remake, write } from "./dom.js";
import { lookAt } from "./map.js";
import { edit, marked } from "./marking.js";
import { controls, live, now, playback } from "./now.js";
import { jumpToFinding } from "./playback.js";
import { WORDS } from "./words.js";

const undoLast = once(undoChange);
let unanswered = null; // the undo whose answer was lost: repeated as it was, it undoes no further change
let withdrawing = null;

export function startFindings() {
  byId("withdraw-cancel").addEventListener("click", close);
  byId("withdrawing").addEventListener("submit", event => { event.preventDefault(); withdraw(); });
}

export function openWithdraw(id) {
  withdrawing = id;
  byId("withdrawing").hidden = false;
  write(byId("withdraw-title"), WORDS.withdrawAsk(id));
  write(byId("withdraw-said"), "");
  byId("withdraw-reason").value = "";
  byId("withdraw-reason").focus();
}

function close() {
  byId("withdrawing").hidden = true;
  entry(withdrawing)?.focus();
  withdrawing = null;
}

async function withdraw() {
  const finding = withdrawing, reason = byId("withdraw-reason").value.trim();
  if (!reason) { write(byId("withdraw-said"), WORDS.reasonNeeded); return; }
  const answer = await ask("withdraw", { finding, reason });
  if (withdrawing !== finding) return; // closed since
  write(byId("withdraw-said"), answer.ok ? "" : answer.text);
  if (answer.ok) close();
}

async function undoChange() {
  const { undo: finding, changes } = now.state;
  if (unanswered?.finding !== finding || unanswered.changes !== changes + 1) unanswered = { finding, changes };
  if ((await ask("undo", unanswered)).ok) unanswered = null;
}

const entry = id => byId("found-list").querySelector(`[data-jump="${id}"]`);

export function showFindings() {
  if (!now.state) return;
  const { findings } = now.state, mayEdit = controls() && Boolean(now.state.session.pseudonym), undo = mayEdit ? now.state.undo : null;
  write(byId("found-title"), WORDS.findingsTitle(findings.filter(found => !found.withdrawn).length));
  byId("found-none").hidden = findings.length > 0;
  write(byId("found-none"), mayEdit ? WORDS.markFirst : WORDS.noFindings);
  const list = byId("found-list"), held = list.contains(document.activeElement) ? document.activeElement.closest("li").firstChild.dataset.jump : null;
  remake(list, [findings, mayEdit, undo], () => findings.map(found => row(found, mayEdit, undo === found.id)).reverse());
  if (held && !list.contains(document.activeElement)) (entry(held) ?? byId("ticks")).focus(); // a jump back in a recording drops it
  for (const button of list.querySelectorAll(".jump ~ button")) button.disabled = !live() || Boolean(marked());
}

function row(found, mayEdit, mayUndo) {
  const placed = typeof found.x_mm === "number";
  const more = [found.contrast, placed ? WORDS.placeOf(found.x_mm, found.y_mm) : WORDS.noPlace, found.body?.text, found.note?.slice(0, 40), found.saved ? "" : WORDS.notSaved].filter(Boolean).join(" · ");
  const text = make(found.withdrawn ? "s" : "span", { text: `${found.id}: ${found.text}` });
  const jump = make("button", { "data-jump": found.id, class: "jump" }, text, make("span", { class: "small", text: found.withdrawn ? WORDS.withdrawn(found.withdrawn) : more }));
  jump.addEventListener("click", () => {
    if (placed) lookAt(found.x_mm, found.y_mm);
    if (playback()) jumpToFinding(found);
  });
  const undo = make("button", { "data-undo": found.id, "aria-label": WORDS.undoOf(found.id) }, WORDS.undo);
  undo.addEventListener("click", undoLast);
  const change = make("button", { "data-edit": found.id, "aria-label": WORDS.editOf(found.id) }, WORDS.edit);
  change.addEventListener("click", () => { if (placed) lookAt(found.x_mm, found.y_mm); edit(found); });
  return make("li", {}, jump, ...(mayUndo ? [undo] : []), ...(mayEdit && !found.withdrawn ? [change] : []));
}
