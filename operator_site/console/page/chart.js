// Region E, chart of the first 8 s of contact: stacked probabilities, and the object's temperature with its sd.
import { siteTime_s } from "./camera.js";
import { byId, equal, penOf } from "./dom.js";
import { now } from "./now.js";
import { FINGER_COUNT } from "./picture.js";
import { colour, onTheme } from "./theme.js";
import { FIXED, percent, WORDS } from "./words.js";

const LENGTH_S = 8, BANDS = ["#1F5FA8", "#F2B134", "#8FD0C0", "#8B2F5F"], INKS = ["#FFFFFF", "#000000", "#000000", "#FFFFFF"], REST = "#6D7680";
const RANGE_C = [15, 45], FONT = "500 16px system-ui, sans-serif", LEFT = 30, FOOT = 20, SPLIT = 0.66, SAME_S = 1;
const histories = Array.from({ length: FINGER_COUNT }, () => ({ samples: [], names: [], began_s: NaN }));

export function startChart() {
  onTheme(drawChart);
  new ResizeObserver(drawChart).observe(byId("chart-bands"));
}

export function followChart(state) {
  const at_s = state.session.playback?.at_s ?? siteTime_s();
  for (const [number, finger] of state.fingers.entries()) {
    const history = histories[number], newest = history.samples.at(-1);
    if (finger.contact_s === null || finger.contact_s === undefined) continue; // the last contact is shown until the next one
    const began_s = at_s - finger.contact_s; // of another contact after a jump in a recording, or after a gap
    if (newest && (finger.contact_s < newest.s || Math.abs(began_s - history.began_s) > SAME_S)) { history.samples = []; history.names = []; }
    history.began_s = began_s;
    if (finger.contact_s > LENGTH_S || (newest && finger.contact_s === newest.s && history.samples.length)) continue;
    for (const [name] of finger.candidates) if (!history.names.includes(name) && history.names.length < BANDS.length) history.names.push(name);
    history.samples.push({ s: finger.contact_s, of: new Map(finger.candidates), unknown: finger.decision === "UNKNOWN", object_c: finger.object_c, sd: finger.object_c_sd });
  }
}

export function drawChart() {
  const canvas = byId("chart-bands");
  if (canvas.clientHeight === 0) return;
  const pen = penOf(canvas);
  const width = canvas.clientWidth, height = canvas.clientHeight, high = (height - FOOT) * SPLIT;
  pen.clearRect(0, 0, width, height);
  pen.font = FONT;
  const x = s => LEFT + s / LENGTH_S * (width - LEFT - 2);
  const history = histories[now.active];
  pen.fillStyle = colour.ground;
  pen.fillRect(LEFT, 0, width - LEFT, high);
  pen.fillRect(LEFT, high + 6, width - LEFT, height - FOOT - high - 6);
  bands(pen, history, x, high);
  if (now.state) level(pen, width, high);
  warmth(pen, history, x, high + 6, height - FOOT);
  axes(pen, x, width, height, high);
  equal("chart-table", FIXED.chartTable, WORDS.chartTable, () => rowsOf(history));
}

function bands(pen, history, x, high) {
  const { samples, names } = history, last = samples.at(-1);
  if (!last) return;
  const order = [...names].sort((a, b) => (last.of.get(b) ?? 0) - (last.of.get(a) ?? 0));
  samples.forEach((sample, at) => {
    const from = Math.floor(x(at > 0 ? samples[at - 1].s : sample.s < 0.5 ? 0 : sample.s - 0.1)), to = Math.ceil(x(sample.s));
    let foot = high;
    for (const name of order) {
      const tall = (sample.of.get(name) ?? 0) * high;
      pen.fillStyle = BANDS[names.indexOf(name)];
      if (tall > 2) pen.fillRect(from, foot - tall + 2, to - from, tall - 2);
      foot -= tall;
    }
    pen.fillStyle = REST;
    pen.fillRect(from, 0, to - from, Math.max(0, foot));
    if (sample.unknown) hatch(pen, from, to, foot);
  });
  label(pen, order, names, last, x, high);
}

function hatch(pen, from, to, foot) {
  pen.fillStyle = colour.text;
  for (let y = 2; y < foot; y += 8) pen.fillRect(from, y, to - from, 1.5);
}

// Names stand in their bands, at the newest end.
function label(pen, order, names, last, x, high) {
  let foot = high;
  const write = (text, ink, top, bottom) => {
    const wide = pen.measureText(text).width;
    if (bottom - top < 19 || x(last.s) - LEFT < wide + 8) return;
    pen.fillStyle = ink;
    pen.fillText(text, x(last.s) - wide - 6, (top + bottom) / 2 + 6);
  };
  for (const name of order) {
    const tall = (last.of.get(name) ?? 0) * high, at = names.indexOf(name);
    write(name, INKS[at], foot - tall, foot);
    foot -= tall;
  }
  const wide = pen.measureText(WORDS.none).width + 12;
  if (!last.unknown) write(WORDS.rest, "#FFFFFF", 0, foot);
  else if (foot > 24 && x(last.s) - LEFT > wide) {
    pen.fillStyle = REST;
    pen.fillRect(x(last.s) - wide, foot / 2 - 12, wide, 24);
    write(WORDS.none, "#FFFFFF", 0, foot);
  }
}

function level(pen, width, high) {
  const y = high * (1 - now.state.decide_at);
  pen.setLineDash([6, 4]);
  for (const [ink, thick] of [[colour.ground, 4], [colour.text, 2]]) {
    pen.strokeStyle = ink;
    pen.lineWidth = thick;
    pen.beginPath();
    pen.moveTo(LEFT, y);
    pen.lineTo(width, y);
    pen.stroke();
  }
  pen.setLineDash([]);
}

function warmth(pen, history, x, top, bottom) {
  const y = celsius => bottom - (Math.min(RANGE_C[1], Math.max(RANGE_C[0], celsius)) - RANGE_C[0]) / (RANGE_C[1] - RANGE_C[0]) * (bottom - top);
  const known = history.samples.filter(sample => typeof sample.object_c === "number");
  known.forEach((sample, at) => {
    const from = Math.floor(x(at === 0 ? Math.max(0, sample.s - 0.1) : known[at - 1].s)), wide = Math.max(1, Math.floor(x(sample.s)) - from);
    if (typeof sample.sd === "number") {
      const high = y(sample.object_c + sample.sd);
      pen.fillStyle = colour.line;
      pen.globalAlpha = 0.5;
      pen.fillRect(from, high, wide, y(sample.object_c - sample.sd) - high);
      pen.globalAlpha = 1;
      pen.fillStyle = colour.muted;
      if (at % 2 === 0) for (const side of [-2, 2]) pen.fillRect(from, y(sample.object_c + side * sample.sd), wide, 1.5);
    }
    pen.fillStyle = colour.text;
    pen.fillRect(from, y(sample.object_c) - 1.25, wide, 2.5);
  });
}

function axes(pen, x, width, height, high) {
  pen.fillStyle = colour.muted;
  pen.fillText("1", 14, 14);
  pen.fillText("0", 14, high);
  pen.fillText(`${RANGE_C[1]}`, 4, high + 20);
  pen.fillText(`${RANGE_C[0]}`, 4, height - FOOT);
  for (const s of [0, 2, 4, 6, 8]) {
    const text = s === 8 ? "8 s" : String(s), wide = pen.measureText(text).width;
    pen.fillText(text, Math.min(width - wide, x(s) - (s ? wide / 2 : 0)), height - 4);
  }
}

function rowsOf(history) {
  const rows = [];
  let next = 0;
  for (const sample of history.samples) {
    if (sample.s < next && sample !== history.samples.at(-1)) continue;
    next = Math.floor(sample.s) + 1;
    for (const [name, probability] of sample.of) rows.push([sample.s.toFixed(1), name, percent(probability)]);
  }
  return rows;
}
