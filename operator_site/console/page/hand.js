// Region C, drawing: five fingertips from above, over the table's columns. The fill shows force, a thick outline contact,
// the dot vibration, the glyph the mode, and the bar below the plate's temperature.
import { TABLES } from "./colours.js";
import { byId, penOf } from "./dom.js";
import { age_s, GONE_S } from "./fingers.js";
import { now } from "./now.js";
import { FINGER_COUNT } from "./picture.js";
import { colour } from "./theme.js";

const LIMIT_N = 10, MOST_HZ = 200, PLATE_C = [15, 45], REACH = [0.72, 0.94, 1.0, 0.94, 0.8];
const PLATE = 9, GAP = 5;

export function drawHand(picture) {
  const canvas = byId("drawing");
  if (canvas.clientHeight === 0) return;
  const pen = penOf(canvas);
  const width = canvas.clientWidth, height = canvas.clientHeight, column = width / FINGER_COUNT;
  pen.clearRect(0, 0, width, height);
  for (let finger = 0; finger < FINGER_COUNT; finger += 1) {
    const known = picture.inUse(finger) && age_s(finger) <= GONE_S;
    const wide = Math.min(52, column - 14), left = column * (finger + 0.5) - wide / 2;
    const bottom = height - PLATE - GAP - 4, top = 6 + (1 - REACH[finger]) * (bottom - 6);
    tip(pen, picture, finger, known, left, top, wide, bottom - top);
    plate(pen, known ? picture.of(finger, "plate_c") : NaN, left, height - PLATE - 2, wide);
    if (finger === now.active) { pen.fillStyle = colour.text; pen.fillRect(left - 5, height - 2, wide + 10, 2); }
  }
}

function tip(pen, picture, finger, known, left, top, wide, high) {
  const radius = wide / 2, force_n = picture.of(finger, "force_n"), hertz = picture.of(finger, "motor_hz"), contact = known && picture.contact(finger);
  const outline = new Path2D();
  outline.roundRect(left, top, wide, high, [radius, radius, 10, 10]);
  pen.save();
  pen.clip(outline);
  pen.fillStyle = colour.faint;
  pen.fillRect(left, top, wide, high);
  if (known && force_n > 0) {
    const filled = Math.min(1, force_n / LIMIT_N) * high;
    pen.fillStyle = colour.mark;
    pen.fillRect(left, top + high - filled, wide, filled);
  }
  pen.restore();
  pen.strokeStyle = contact ? colour.text : colour.line;
  pen.lineWidth = contact ? 5 : 2;
  pen.setLineDash(known ? [] : [4, 4]);
  pen.stroke(outline);
  pen.setLineDash([]);
  if (!known) return;
  if (hertz > 0) {
    pen.beginPath();
    pen.arc(left + radius, top + high - 22, 3 + 11 * Math.min(1, hertz / MOST_HZ), 0, 2 * Math.PI);
    pen.fillStyle = colour.text;
    pen.fill();
    pen.lineWidth = 2;
    pen.strokeStyle = colour.ground;
    pen.stroke();
  }
  glyph(pen, picture.of(finger, "mode"), left + radius, top + radius + 4);
}

// free: ring; tapping: arrow down; resting: bar; stroking: arrow to both sides
function glyph(pen, mode, x, y) {
  pen.strokeStyle = colour.text;
  pen.lineWidth = 3;
  pen.beginPath();
  if (mode === 0) pen.arc(x, y, 5, 0, 2 * Math.PI);
  else if (mode === 1) { pen.moveTo(x, y - 9); pen.lineTo(x, y + 8); pen.moveTo(x - 6, y + 1); pen.lineTo(x, y + 8); pen.lineTo(x + 6, y + 1); }
  else if (mode === 2) { pen.moveTo(x - 10, y); pen.lineTo(x + 10, y); }
  else if (mode === 3) {
    pen.moveTo(x - 12, y); pen.lineTo(x + 12, y);
    for (const side of [-1, 1]) { pen.moveTo(x + side * 6, y - 6); pen.lineTo(x + side * 12, y); pen.lineTo(x + side * 6, y + 6); }
  }
  pen.stroke();
}

function plate(pen, celsius, left, top, wide) {
  pen.lineWidth = 1;
  pen.strokeStyle = colour.line;
  if (!Number.isNaN(celsius)) {
    const table = TABLES.temperature, place = (celsius - PLATE_C[0]) / (PLATE_C[1] - PLATE_C[0]);
    const entry = 3 * Math.round(255 * Math.min(1, Math.max(0, place)));
    pen.fillStyle = `rgb(${table[entry]} ${table[entry + 1]} ${table[entry + 2]})`;
    pen.fillRect(left, top, wide, PLATE - 2);
  }
  pen.strokeRect(left + 0.5, top + 0.5, wide - 1, PLATE - 2);
}
