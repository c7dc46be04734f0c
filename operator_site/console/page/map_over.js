// Region D, over the map: a cross for each finger, names of lumps, the marked finding, the cursor; on the map itself:
// findings as flags, reports of pain with the force at which they began, the most tender place, lumps, the next place to press, a scale bar of 10 mm, the sides of the body.
import { penOf } from "./dom.js";
import { age_s, GONE_S } from "./fingers.js";
import { now } from "./now.js";
import { FINGER_COUNT } from "./picture.js";
import { FINGER_IDS, percent, WORDS } from "./words.js";

const INK = "#10151B", PAPER = "#FFFFFF", BAR_MM = 10, STALE_MM = 4, SURE = 0.9, OPPOSITE = { head: "feet", feet: "head", left: "right", right: "left" };

function begin(canvas) {
  const pen = penOf(canvas);
  pen.font = "600 16px system-ui, sans-serif";
  pen.textAlign = "center";
  return pen;
}

export function drawStill(canvas, at) {
  const pen = begin(canvas);
  stale(pen, at);
  sides(pen, at);
  bar(pen, at);
  for (const lump of lumps()) outline(pen, at, lump);
  for (const [x_mm, y_mm, threshold_n] of now.state?.patient?.reports ?? []) { const x = at.toX(x_mm), y = at.toY(y_mm); ring(pen, x, y, 7, 3); word(pen, `pain ${threshold_n.toFixed(1)} N`, x, y + 24, 0.8); }
  tender(pen, at);
  for (const found of flagged()) flag(pen, at.toX(found.x_mm), at.toY(found.y_mm), found.id);
}

const flagged = () => (now.state?.findings ?? []).filter(found => !found.withdrawn && typeof found.x_mm === "number" && typeof found.y_mm === "number");

// mirror: x of the mirror line, mm, or null.
export function drawOver(canvas, at, finding, cursor, mirror) {
  const pen = begin(canvas);
  pen.clearRect(0, 0, at.width, at.height);
  const fingers = [], press = now.state?.map?.next_mm, next = press && [at.toX(press[0]), at.toY(press[1])];
  if (next) lines(pen, ...next, 8, 2, 4);
  if (now.picture) for (let finger = 0; finger < FINGER_COUNT; finger += 1) if (now.picture.inUse(finger) && age_s(finger) <= GONE_S) fingers.push(...cross(pen, at, finger, next));
  const flags = flagged().map(({ x_mm, y_mm }) => [at.toX(x_mm) + 12, at.toY(y_mm) - 18, 14, 18]);
  const taken = [...fingers, ...flags, ...lumps().map(lump => name(pen, at, lump, fingers))];
  if (next) beside(pen, "next", ...next, taken);
  if (mirror !== null) { const x = at.toX(mirror); pen.setLineDash([10, 6]); edged(pen, 2, () => { pen.moveTo(x, 0); pen.lineTo(x, at.height); }); pen.setLineDash([]); }
  if (cursor) lines(pen, at.toX(cursor.x), at.toY(cursor.y), 9, 1.5, 3);
  if (finding && finding.x_mm !== null) aim(pen, at.toX(finding.x_mm), at.toY(finding.y_mm));
}

// Dark with a white edge, visible on every colour.
function edged(pen, thick, draw) {
  for (const [ink, wide] of [[PAPER, thick + 3], [INK, thick]]) {
    pen.strokeStyle = ink;
    pen.lineWidth = wide;
    pen.beginPath();
    draw();
    pen.stroke();
  }
}

function lines(pen, x, y, long, thick, open = 0) {
  edged(pen, thick, () => {
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) { pen.moveTo(x + open * dx, y + open * dy); pen.lineTo(x + long * dx, y + long * dy); }
  });
}

function ring(pen, x, y, radius, thick) {
  edged(pen, thick, () => pen.arc(x, y, radius, 0, 2 * Math.PI));
}

export function word(pen, text, x, y, scale = 1) {
  pen.lineJoin = "round";
  pen.lineWidth = 4 * scale;
  pen.strokeStyle = INK;
  pen.strokeText(text, x, y);
  pen.fillStyle = PAPER;
  pen.fillText(text, x, y);
}

// Boxes on the map: middle, half width and half height.
const LETTER = 6, WORD = 8;
const meet = (one, other) => Math.abs(one[0] - other[0]) < one[2] + other[2] && Math.abs(one[1] - other[1]) < one[3] + other[3];
const boxOf = (text, x, y) => [x, y - LETTER, text.length * LETTER, WORD];

// Returns the boxes of its cross and name.
function cross(pen, at, finger, next) {
  const x = at.toX(now.picture.of(finger, "x_m") * 1000), y = at.toY(now.picture.of(finger, "y_m") * 1000), id = FINGER_IDS[finger];
  if (x < 0 || y < 0 || x > at.width || y > at.height) return [outside(pen, at, x, y, id)];
  const active = finger === now.active, long = active ? 13 : 7;
  lines(pen, x, y, long, active ? 4 : 2);
  // To the left; findings are to the right. Below where the next place to press is above.
  const left = x - (active ? 15 : 12), box = boxOf(id, left, y - 8);
  if (next && meet(box, [...next, 9, 9])) box[1] = y + 14;
  word(pen, id, left, box[1] + LETTER);
  if (now.picture.contact(finger)) ring(pen, x, y, active ? 9 : 6, 2);
  return [[x, y, long, long], box];
}

// A finger beyond the edge: its letter and an arrow towards it.
function outside(pen, at, x, y, id) {
  const edgeX = Math.min(at.width - 18, Math.max(18, x)), edgeY = Math.min(at.height - 8, Math.max(20, y));
  const eighth = Math.round(4 * Math.atan2(edgeY - y, x - edgeX) / Math.PI) & 7;
  word(pen, id + "→↗↑↖←↙↓↘"[eighth], edgeX, edgeY);
  return boxOf(`${id}→`, edgeX, edgeY);
}

// A word below a mark, or above or beside it where something else is written.
function beside(pen, text, x, y, taken) {
  const long = 10 + text.length * LETTER, places = [[x, y + 22], [x, y - 16], [x + long, y + 6], [x - long, y + 6]];
  word(pen, text, ...(places.find(place => !taken.some(box => meet(boxOf(text, ...place), box))) ?? places[0]), 0.8);
}

function flag(pen, x, y, number) {
  const text = String(number), wide = 14 + 10 * text.length;
  pen.fillStyle = INK;
  pen.strokeStyle = PAPER;
  pen.lineWidth = 2;
  pen.beginPath();
  pen.moveTo(x, y); pen.lineTo(x, y - 34); pen.lineTo(x + wide, y - 34); pen.lineTo(x + wide, y - 12); pen.lineTo(x + 3, y - 12); pen.lineTo(x + 3, y); pen.closePath();
  pen.fill(); pen.stroke();
  pen.fillStyle = PAPER;
  pen.fillText(text, x + 1 + wide / 2, y - 17);
}

const lumps = () => now.state?.map?.lumps ?? [];

// A lump: solid where it is sure.
function outline(pen, at, { outline_mm, probability, at_edge }) {
  pen.setLineDash(probability < SURE || at_edge ? [6, 5] : []);
  edged(pen, 2.5, () => { for (const [x, y] of outline_mm) pen.lineTo(at.toX(x), at.toY(y)); pen.closePath(); });
  pen.setLineDash([]);
}

// Its name, below it if a finger is above. Returns the name's box.
function name(pen, at, { outline_mm, probability, at_edge, x_mm }, fingers) {
  const x = at.toX(x_mm), all = outline_mm.map(corner => at.toY(corner[1])), above = Math.min(...all) - 8;
  const text = `${at_edge ? "edge" : "lump"} ${percent(probability)}`, taken = fingers.some(finger => meet(boxOf(text, x, above), finger));
  const y = taken ? Math.max(...all) + 18 : above;
  word(pen, text, x, y, 0.8);
  return boxOf(text, x, y);
}

// Two strokes through each square that was felt before the patient moved.
function stale(pen, at) {
  const squares = now.state?.map?.stale_mm ?? [];
  if (!squares.length) return;
  edged(pen, 1, () => {
    for (const [x, y] of squares) for (const part of [0, STALE_MM / 2]) { pen.moveTo(at.toX(x + part), at.toY(y)); pen.lineTo(at.toX(x + part + STALE_MM / 2), at.toY(y + STALE_MM)); }
  });
}

// The circle that holds the most tender place with a probability of 95 %.
function tender(pen, at) {
  const circle = now.state?.patient?.tender?.circle;
  if (!circle) return;
  const [x, y] = [at.toX(circle[0]), at.toY(circle[1])], radius = Math.max(3, circle[2] * at.scale);
  pen.setLineDash([3, 4]);
  ring(pen, x, y, radius, 2.5);
  pen.setLineDash([]);
  word(pen, WORDS.tenderCircle, x, y - radius - 8, 0.8);
}

function aim(pen, x, y) {
  lines(pen, x, y, 34, 3, 8);
  ring(pen, x, y, 20, 3);
}

function bar(pen, at) {
  const long = BAR_MM * at.scale, left = 12, y = at.height - 12;
  edged(pen, 3, () => { pen.moveTo(left, y); pen.lineTo(left + long, y); });
  word(pen, "10 mm", left + Math.max(28, long / 2), y - 9);
}

function sides(pen, at) {
  const named = now.state?.map?.sides;
  if (!named) return;
  const middle = at.width / 2, side = at.height / 2;
  if (named.top) { word(pen, named.top, middle, 18); word(pen, OPPOSITE[named.top] ?? "", middle, at.height - 8); }
  if (!named.right) return;
  pen.save();
  pen.textAlign = "right"; word(pen, named.right, at.width - 6, side);
  pen.textAlign = "left"; word(pen, OPPOSITE[named.right] ?? "", 6, side);
  pen.restore();
}
