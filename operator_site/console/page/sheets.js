// Opens the sheets for session, alarms and help, one at a time and never modal.
import { byId } from "./dom.js";

const BUTTONS = { "sheet-session": "session-button", "sheet-alarms": "alarm-button", "sheet-help": "help-button" };

export function startSheets(opened) {
  for (const [sheet, button] of Object.entries(BUTTONS)) {
    byId(button).addEventListener("click", () => toggle(sheet, opened));
    byId(sheet).querySelector(".close").addEventListener("click", () => close(sheet));
  }
}

export function toggle(sheet, opened = () => {}) {
  if (!byId(sheet).hidden) { close(sheet); return; }
  open(sheet);
  opened(sheet);
  const first = [...byId(sheet).querySelectorAll(".body[tabindex], input:not(:disabled), button:not(:disabled, #end-button)")].find(each => each.checkVisibility());
  if (first) first.focus();
}

export function open(sheet) {
  for (const other of Object.keys(BUTTONS)) {
    byId(other).hidden = other !== sheet;
    byId(BUTTONS[other]).setAttribute("aria-expanded", String(other === sheet));
  }
}

export function close(sheet) {
  if (byId(sheet).hidden) return false;
  const held = byId(sheet).contains(document.activeElement);
  byId(sheet).hidden = true;
  byId(BUTTONS[sheet]).setAttribute("aria-expanded", "false");
  if (held) byId(BUTTONS[sheet]).focus();
  return true;
}

export function closeAll() {
  return Object.keys(BUTTONS).map(close).some(Boolean);
}
