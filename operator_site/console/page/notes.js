// Writes a note to a finding. Space types here and Esc is STOP; closing keeps the text for this finding.
import { askSilently, say } from "./actions.js";
import { byId, make, remake, write } from "./dom.js";
import { controls, now } from "./now.js";
import { WORDS } from "./words.js";

const drafts = new Map(); // unsaved texts by study number and finding
let expected = null, study = null; // study number for which the tray was opened

export function startNotes() {
  byId("note-button").addEventListener("click", () => openNote());
  byId("note-close").addEventListener("click", closeNote);
  byId("note-finding").addEventListener("change", showText);
  byId("note-text").addEventListener("input", () => drafts.set(draftKey(), byId("note-text").value));
  byId("noting").addEventListener("submit", event => { event.preventDefault(); save(); });
}

// Offers a finding that was just saved before it arrives with a state.
export const expect = (id, text) => { expected = [id, text]; };

function choices() {
  const listed = now.state.findings.filter(found => !found.withdrawn).map(found => [found.id, found.text]);
  if (!expected || listed.some(([id]) => id === expected[0])) expected = null;
  return expected ? [...listed, expected] : listed;
}

export function openNote(id = null) {
  if (!controls()) return;
  const last = id === null ? choices().at(-1) : choices().find(([offered]) => offered === id);
  if (!last) { say(WORDS.noFindings); return; }
  byId("noting").hidden = false;
  study = now.state.session.pseudonym;
  showNotes();
  byId("note-finding").value = String(last[0]);
  showText();
  byId("note-text").focus();
}

const draftKey = () => `${now.state.session.pseudonym} ${byId("note-finding").value}`;

// Shows the unsaved text, or the note that the finding has, so that it is edited and not replaced.
function showText() {
  const found = now.state.findings.find(each => String(each.id) === byId("note-finding").value);
  byId("note-text").value = drafts.get(draftKey()) ?? found?.note ?? "";
  write(byId("note-said"), "");
}

function closeNote() {
  byId("noting").hidden = true;
  byId("note-button").focus();
}

export function showNotes() {
  if (byId("noting").hidden || !now.state) return;
  const { pseudonym } = now.state.session;
  if (pseudonym && pseudonym !== study) { byId("noting").hidden = true; return; } // the text is of another person
  const offered = choices(), chosen = byId("note-finding").value;
  remake(byId("note-finding"), offered, () => offered.map(([id, text]) => make("option", { value: id, text: `${id}: ${text}`.slice(0, 60) })));
  if (chosen && offered.some(([id]) => String(id) === chosen)) byId("note-finding").value = chosen;
}

async function save() {
  const text = byId("note-text").value, key = draftKey();
  if (!text.trim()) return;
  write(byId("note-said"), WORDS.noteSaving);
  const answer = await askSilently("note", { finding: Number(byId("note-finding").value), text });
  write(byId("note-said"), answer.text);
  if (!answer.ok) return;
  say(answer.text);
  if ((drafts.get(key) ?? text) !== text) return; // changed since
  drafts.delete(key);
  if (!byId("noting").hidden && draftKey() === key) closeNote();
}
