// Region F, the last 10 s: four strips of min/max bars on fixed scales. The canvas copies itself to the left and draws one
// new column for each bin. All of it is drawn only after a change of finger, size or theme.
import { byId, equal, fit, make } from "./dom.js";
import { now } from "./now.js";
import { BIN_FLOATS, FINGER_COUNT, LONGEST_BINS, SIGNAL_COUNT, SIGNALS, SNAPSHOT } from "./picture.js";
import { colour, onTheme } from "./theme.js";
import { FINGER_NAMES, WORDS } from "./words.js";

const STRIPS = [
  { range: [0, 10], signals: ["force_n"] }, { range: [0, 10], signals: ["contact_n"] },
  { range: [0, 200], signals: ["motor_hz"] }, { range: [15, 45], signals: ["plate_c", "skin_c"] },
];
const GAP = 4, DASH_BINS = 6;
const history = new Float32Array(BIN_FLOATS * LONGEST_BINS).fill(NaN);
const commands = new Float32Array(FINGER_COUNT * LONGEST_BINS).fill(NaN), limits = new Uint8Array(LONGEST_BINS);
let newest = -1, active = -1, whole = true;

export function startStrips() {
  byId("strip-labels").append(...STRIPS.map(({ range }, at) => make("div", {},
    make("span", { class: "name", text: WORDS.strips[at].join(" ") }), make("span", { class: "top", text: range[1], "data-low": range[0] }), make("span", { class: "low", text: range[0] }))));
  onTheme(() => { whole = true; });
}

const slot = bin => ((bin % LONGEST_BINS) + LONGEST_BINS) % LONGEST_BINS;

function keep(picture, last) {
  for (let at = 0; at < picture.bins; at += 1) {
    const bin = last - picture.bins + 1 + at;
    if (bin <= newest) continue;
    history.set(picture.values.subarray(at * BIN_FLOATS, (at + 1) * BIN_FLOATS), slot(bin) * BIN_FLOATS);
    if (picture.kind === SNAPSHOT) continue;
    let flags = 0;
    for (let finger = 0; finger < FINGER_COUNT; finger += 1) {
      commands[slot(bin) * FINGER_COUNT + finger] = picture.of(finger, "plate_set_c");
      if (picture.limit(finger)) flags |= 1 << finger;
    }
    limits[slot(bin)] = flags;
  }
}

function forget(from, to) {
  for (let bin = Math.max(from, to - LONGEST_BINS + 1); bin <= to; bin += 1) {
    history.fill(NaN, slot(bin) * BIN_FLOATS, (slot(bin) + 1) * BIN_FLOATS);
    commands.fill(NaN, slot(bin) * FINGER_COUNT, (slot(bin) + 1) * FINGER_COUNT);
    limits[slot(bin)] = 0;
  }
}

// Takes the picture's bins by their number; skipped bins stay blank.
export function drawStrips(picture) {
  const last = Math.round(picture.time_s / picture.span_s);
  if (picture.kind === SNAPSHOT || last < newest) {
    newest = last - LONGEST_BINS;
    whole = true;
  }
  const before = newest;
  if (last > newest) {
    forget(newest + 1, last);
    keep(picture, last);
    newest = last;
  }
  const canvas = byId("strips");
  if (canvas.clientHeight === 0) return;
  const pen = canvas.getContext("2d", { alpha: false });
  if (fit(canvas) || active !== now.active || last - before >= LONGEST_BINS) whole = true;
  active = now.active;
  if (whole) {
    ground(pen, canvas, 0, canvas.width);
    columns(pen, canvas, newest - LONGEST_BINS + 1);
    whole = false;
    return;
  }
  const shift = edge(canvas, newest) - edge(canvas, before);
  if (shift === 0) return;
  pen.drawImage(canvas, -shift, 0);
  ground(pen, canvas, canvas.width - shift, shift);
  columns(pen, canvas, before + 1);
}

const placeOf = (bin, finger, signal) => slot(bin) * BIN_FLOATS + 2 * (finger * SIGNAL_COUNT + SIGNALS[signal]);
const edge = (canvas, bin) => Math.floor((bin * canvas.width) / LONGEST_BINS);

function strip(canvas, at) {
  const scale = window.devicePixelRatio || 1, gap = GAP * scale, high = (canvas.height - 3 * gap) / 4;
  return { top: Math.round(at * (high + gap)), high: Math.round(high), scale };
}

function ground(pen, canvas, left, wide) {
  pen.fillStyle = colour.panel;
  pen.fillRect(left, 0, wide, canvas.height);
  pen.fillStyle = colour.ground;
  for (let at = 0; at < STRIPS.length; at += 1) { const { top, high } = strip(canvas, at); pen.fillRect(left, top, wide, high); }
}

function columns(pen, canvas, from) {
  for (let bin = from; bin <= newest; bin += 1) column(pen, canvas, bin);
}

function column(pen, canvas, bin) {
  const wide = edge(canvas, bin) - edge(canvas, bin - 1), left = canvas.width - edge(canvas, newest) + edge(canvas, bin - 1);
  for (let at = 0; at < STRIPS.length; at += 1) {
    const { top, high, scale } = strip(canvas, at), { range, signals } = STRIPS[at];
    const y = value => top + high - 1 - (Math.min(range[1], Math.max(range[0], value)) - range[0]) / (range[1] - range[0]) * (high - 1);
    if (limits[slot(bin)] & (1 << active)) hatch(pen, left, wide, top, high, bin);
    for (let finger = 0; finger < FINGER_COUNT; finger += 1) if (finger !== active) bar(pen, bin, finger, signals[0], y, left, wide, scale, colour.line);
    if (signals.length > 1) bar(pen, bin, active, signals[1], y, left, wide, 2 * scale, colour.muted);
    bar(pen, bin, active, signals[0], y, left, wide, 4 * scale, at === 3 ? colour.mark : colour.text);
    if (at === 3 && slot(bin) % DASH_BINS < DASH_BINS / 2) command(pen, bin, y, left, wide, scale);
  }
}

function bar(pen, bin, finger, signal, y, left, wide, thick, fill) {
  const place = placeOf(bin, finger, signal), low = history[place], high = history[place + 1];
  if (Number.isNaN(low) || Number.isNaN(high)) return;
  const top = y(high), bottom = y(low), tall = Math.max(thick, bottom - top + thick);
  pen.fillStyle = fill;
  pen.fillRect(left, Math.round((top + bottom - tall) / 2), wide, Math.round(tall));
}

function command(pen, bin, y, left, wide, scale) {
  const value = commands[slot(bin) * FINGER_COUNT + active];
  if (Number.isNaN(value)) return;
  pen.fillStyle = colour.text;
  pen.fillRect(left, Math.round(y(value)), wide, 2 * scale);
}

function hatch(pen, left, wide, top, high, bin) {
  pen.fillStyle = colour.faint;
  for (let step = (bin * 3) % 9; step < high; step += 9) pen.fillRect(left, top + step, wide, 4);
}

// Shows the same as numbers: smallest and largest of the 10 s for each finger.
export function showStripTable() {
  const rows = () => FINGER_NAMES.map((name, finger) => [name, ...Object.keys(SIGNALS).map(signal => range(finger, signal))]);
  equal("strip-table", WORDS.lastTable, WORDS.stripTable, rows);
}

function range(finger, signal) {
  let low = Infinity, high = -Infinity;
  for (let bin = 0; bin < LONGEST_BINS; bin += 1) {
    const place = placeOf(bin, finger, signal);
    if (history[place] < low) low = history[place];
    if (history[place + 1] > high) high = history[place + 1];
  }
  return low > high ? "--" : `${low.toFixed(1)} … ${high.toFixed(1)}`;
}
