// Region D, legends: value upwards with known things beside it, confidence to the right; materials as a list.
import { byId, penOf, write } from "./dom.js";
import { inkOf, over, placeOf, SPREADS } from "./map_tiles.js";
import { anchors, numberText, unitOf } from "./map_units.js";
import { word } from "./map_over.js";
import { colour } from "./theme.js";
import { capital, marks, WORDS } from "./words.js";

const ROW = 26, LEAST_ROW = 17, BOX = 26, APART = 18;

// what: {quantity, legend, materials, sure, span: half the range of differences, or null, beyond}
export function drawLegend(number, what) {
  const { quantity, materials, sure, span, beyond } = what, block = byId("legend").querySelectorAll(".scale")[number];
  const canvas = block.querySelector("canvas"), text = (name, words) => write(block.querySelector(`.${name}`), words);
  const pen = penOf(canvas), width = canvas.clientWidth, height = canvas.clientHeight;
  pen.fillStyle = colour.panel;
  pen.fillRect(0, 0, width, height);
  const listed = quantity === "material" && !sure, [low, high, unit] = ends(what);
  text("name", capital(quantity));
  text("unit", unit);
  text("high", listed ? "" : `${beyond[1] && !sure ? "▲ " : ""}${high}`);
  text("low", listed ? "" : `${beyond[0] && !sure ? "▼ " : ""}${low}`);
  text("foot", listed || sure ? "" : WORDS.confidenceFoot);
  if (listed) list(pen, materials, width, height);
  else field(pen, span === null ? quantity : "temperature", sure, width, height);
  if (!listed && !sure && span === null) known(pen, what, width, height);
  const name = listed ? materials.join(", ") : `${capital(quantity)}, ${low} … ${high} ${unit}`;
  if (canvas.getAttribute("aria-label") !== name) canvas.setAttribute("aria-label", name);
}

function ends({ quantity, legend, sure, span }) {
  if (sure) return [...SPREADS[quantity].map(digits), WORDS.spreadUnit[quantity]];
  if (span === null) return [...legend.map(value => numberText(quantity, value, digits)), unitOf(quantity)];
  return quantity === "temperature" ? [`−${digits(span)}`, `+${digits(span)}`, WORDS.differenceUnit] : [digits(Math.exp(-span)), digits(Math.exp(span)), WORDS.ratioUnit];
}

function digits(value) {
  return Math.abs(value) >= 100 ? value.toFixed(0) : Math.abs(value) >= 1 || value === 0 ? value.toFixed(1) : value.toPrecision(2);
}

function field(pen, quantity, sure, width, height) {
  for (let step = 1; step <= 3; step += 1) {
    const left = (step - 1) * width / 3;
    for (let y = 0; y < height; y += 1) {
      const ink = sure ? inkOf("stiffness", 1 - y / height) : over(inkOf(quantity, 1 - y / height), step);
      pen.fillStyle = `rgb(${ink.join(" ")})`;
      pen.fillRect(left, y, width / 3, 1.5);
    }
    if (step === 1 && !sure) for (let y = 2; y < height; y += 4) for (let x = (y % 8) / 2; x < width / 3; x += 4) { pen.fillStyle = "#10151B"; pen.fillRect(left + x, y, 1, 1); }
  }
}

// Things that people know, each with a mark at its value; those that would overlap are left out.
function known(pen, { quantity, legend }, width, height) {
  let last = Infinity;
  pen.font = "600 16px system-ui, sans-serif";
  pen.textAlign = "right";
  for (const [value, name] of anchors(quantity).sort((one, other) => one[0] - other[0])) {
    const share = placeOf(quantity, value, legend), y = (1 - share) * height;
    if (share < 0 || share > 1 || last - y < APART) continue;
    last = y;
    pen.fillStyle = "#10151B";
    pen.fillRect(0, y - 1, 8, 2);
    word(pen, name, width - 3, Math.max(14, Math.min(height - 3, y + 6)));
  }
}

function list(pen, materials, width, height) {
  const short = marks(materials), row = Math.min(ROW, Math.max(LEAST_ROW, height / materials.length));
  materials.forEach((name, at) => {
    const top = at * row, foot = top + row / 2 + 6;
    if (foot > height) return;
    pen.fillStyle = `rgb(${inkOf("material", at).join(" ")})`;
    pen.fillRect(0, top + 1, BOX, row - 2);
    pen.font = "600 16px system-ui, sans-serif";
    pen.textAlign = "center";
    word(pen, short[at], BOX / 2, foot);
    pen.font = "16px system-ui, sans-serif";
    pen.textAlign = "left";
    pen.fillStyle = colour.text;
    pen.fillText(name, BOX + 4, foot, width - BOX - 4);
  });
}
