// Writes a note to a finding. Space types here and Esc is STOP; closing keeps the text.
import { byId, make, remake, write } from "./dom.js";
import { acts, now } from "./now.js";
import { WORDS } from "./words.js";

let connection = null, say = null, expected = null;

export function startNotes(link, speak) {
  connection = link;
  say = speak;
  byId("note-button").addEventListener("click", () => openNote());
  byId("note-close").addEventListener("click", closeNote);
  byId("note-finding").addEventListener("change", showWritten);
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
  if (!acts()) return;
  const last = id === null ? choices().at(-1) : choices().find(([offered]) => offered === id);
  if (!last) { say(WORDS.noFindings); return; }
  byId("noting").hidden = false;
  showNotes();
  byId("note-finding").value = String(last[0]);
  if (!byId("note-text").value) showWritten();
  byId("note-text").focus();
}

// Shows the note that a finding has, so that it is edited and not replaced.
function showWritten() {
  byId("note-text").value = now.state.findings.find(found => String(found.id) === byId("note-finding").value)?.note ?? "";
}

function closeNote() {
  byId("noting").hidden = true;
  byId("note-button").focus();
}

export function showNotes() {
  if (byId("noting").hidden || !now.state) return;
  const offered = choices(), chosen = byId("note-finding").value;
  remake(byId("note-finding"), offered, () => offered.map(([id, text]) => make("option", { value: id, text: `${id}: ${text}`.slice(0, 60) })));
  if (chosen && offered.some(([id]) => String(id) === chosen)) byId("note-finding").value = chosen;
}

async function save() {
  const text = byId("note-text").value;
  if (!text.trim()) return;
  write(byId("note-said"), WORDS.noteSaving);
  const answer = await connection.ask("note", { finding: Number(byId("note-finding").value), text });
  write(byId("note-said"), answer.text);
  if (!answer.ok) return;
  byId("note-text").value = "";
  say(answer.text);
  closeNote();
}
