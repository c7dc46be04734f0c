// Region C, table: four numbers for each of five fingers, at 4 Hz. Old numbers turn grey, then "--".
import { byId, make, write } from "./dom.js";
import { known, now, playback } from "./now.js";
import { FINGER_COUNT } from "./picture.js";
import { FINGER_IDS, FINGER_NAMES, MODES, WORDS } from "./words.js";

export const STALE_S = 0.25, GONE_S = 1.0;
const LIMIT_HELD_S = 3, ROWS = ["force_n", "plate_c", "motor_hz", "mode"], FOLDS = ["motor_hz", "mode"];
const DIGITS = { force_n: 1, plate_c: 1, motor_hz: 0 };
const cells = [], limitedAt_s = new Array(FINGER_COUNT).fill(-Infinity), strongest_n = new Array(FINGER_COUNT).fill(NaN);

export function startFingers(choose) {
  const heads = FINGER_NAMES.map((name, finger) => {
    const button = make("button", { "aria-pressed": "false" }, FINGER_IDS[finger], make("span", { class: "unseen", text: ` ${name}` }));
    button.addEventListener("click", () => choose(now.chosen === finger ? null : finger));
    return make("th", { scope: "col" }, button);
  });
  byId("finger-table").append(make("thead", {}, make("tr", {}, make("td"), ...heads)), ...[...ROWS, "remarks"].map(row => body(row)));
  byId("details-table").append(...FOLDS.map(row => body(row)));
}

function body(row) {
  const name = make("th", { scope: "row", class: "row-name", text: WORDS.rows[row] });
  const values = make("tr", { class: row === "remarks" ? "remarks" : null, "aria-label": WORDS.rows[row] }, name);
  for (let finger = 0; finger < FINGER_COUNT; finger += 1) {
    const cell = make("td", { class: row });
    cells.push({ cell, row, finger });
    values.append(cell);
  }
  if (row === "remarks") name.firstChild.replaceWith(make("span", { class: "unseen", text: WORDS.rows[row] }));
  return make("tbody", { class: FOLDS.includes(row) ? "folds" : null }, values);
}

// Keeps the largest force since the last update, and the time of each acting limit, until a jump back in a recording.
export function followFingers(picture) {
  for (let finger = 0; finger < FINGER_COUNT; finger += 1) {
    const force_n = picture.of(finger, "force_n");
    if (!(strongest_n[finger] >= force_n)) strongest_n[finger] = force_n;
    if (picture.limit(finger)) limitedAt_s[finger] = picture.time_s;
    else if (limitedAt_s[finger] > picture.time_s) limitedAt_s[finger] = -Infinity;
  }
}

export function age_s(finger) {
  if (!now.picture) return Infinity;
  const reported_s = now.picture.of(finger, "age_s");
  const since_s = playback() && now.connected ? 0 : (performance.now() - now.pictureAt_ms) / 1000;
  return Number.isNaN(reported_s) ? Infinity : reported_s + since_s;
}

export function showFingers() {
  for (const { cell, row, finger } of cells) {
    const age = age_s(finger), used = Boolean(now.picture?.inUse(finger));
    const stale = age > STALE_S;
    if (row === "remarks") showRemarks(cell, finger, used, age);
    else {
      write(cell, used && age <= GONE_S ? value(row, finger) : "--");
      cell.className = `${row}${used ? "" : " unused"}${stale ? " stale" : ""}`;
    }
  }
  strongest_n.fill(NaN);
  const heads = byId("finger-table").querySelectorAll("thead button");
  for (let finger = 0; finger < FINGER_COUNT; finger += 1) {
    heads[finger].setAttribute("aria-pressed", String(now.active === finger));
    heads[finger].parentElement.className = now.picture?.inUse(finger) ? "" : "unused";
  }
}

function value(row, finger) {
  const shown = row === "force_n" ? strongest_n[finger] : now.picture.of(finger, row);
  const number = Number.isNaN(shown) ? now.picture.of(finger, row) : shown;
  if (Number.isNaN(number)) return "--";
  return row === "mode" ? MODES[number] ?? "--" : number.toFixed(DIGITS[row]);
}

function showRemarks(cell, finger, used, age) {
  const limited = used && age <= GONE_S && now.picture.time_s - limitedAt_s[finger] < LIMIT_HELD_S;
  const text = !used || !now.picture ? "" : age > GONE_S ? "--" : age > STALE_S ? WORDS.old(age) : "";
  const softened = used && known() && Boolean(now.state.fingers[finger].softened);
  const shown = limited ? WORDS.limit : text || (softened ? WORDS.softened : "");
  if (cell.textContent === shown) return;
  cell.replaceChildren(limited ? make("span", { class: "limit", text: shown }) : shown);
}
