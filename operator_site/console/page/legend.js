// Region D, legend: value upwards and confidence to the right, as on the map; materials as a list.
import { byId, penOf, write } from "./dom.js";
import { inkOf, over, SPREADS } from "./map_tiles.js";
import { word } from "./map_over.js";
import { colour } from "./theme.js";
import { capital, marks, WORDS } from "./words.js";

const ROW = 26, LEAST_ROW = 17, BOX = 26;

export function drawLegend(quantity, legend, materials, sure, beyond) {
  const canvas = byId("legend-scale");
  const pen = penOf(canvas);
  const width = canvas.clientWidth, height = canvas.clientHeight;
  pen.fillStyle = colour.panel;
  pen.fillRect(0, 0, width, height);
  const listed = quantity === "material" && !sure, [low, high] = sure ? SPREADS[quantity] : legend, unit = (sure ? WORDS.spreadUnit : WORDS.legendUnit)[quantity];
  write(byId("legend-unit"), unit);
  write(byId("legend-high"), listed ? "" : `${beyond[1] && !sure ? "▲ " : ""}${digits(high)}`);
  write(byId("legend-low"), listed ? "" : `${beyond[0] && !sure ? "▼ " : ""}${digits(low)}`);
  write(byId("legend-foot"), sure ? "" : WORDS.confidenceFoot);
  if (listed) list(pen, materials, width, height);
  else field(pen, quantity, sure, width, height);
  const name = listed ? materials.join(", ") : `${capital(quantity)}, ${digits(low)} … ${digits(high)} ${unit}`;
  if (canvas.getAttribute("aria-label") !== name) canvas.setAttribute("aria-label", name);
}

function digits(value) {
  return Math.abs(value) >= 100 ? value.toFixed(0) : Math.abs(value) >= 1 ? value.toFixed(1) : value.toPrecision(2);
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
