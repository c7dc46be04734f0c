// Paints one pane of the map: a still picture, tiles with their patterns, and letters that repeat a colour.
import { codeAt, SIDE, UNEXPLORED, valueOf } from "./map_tiles.js";
import { drawStill, word } from "./map_over.js";
import { drawPhoto, hasPhoto } from "./map_photo.js";
import { marks } from "./words.js";

const SIGN_K = 1, LETTERS_PX = 28;
const patterns = new Map();

// what: {painting, quantity, range, legend, materials, plain: whether values are shown, no spreads or differences}
export function paintPane(canvas, at, what) {
  const { painting } = what, pen = canvas.getContext("2d", { alpha: false }), scale = canvas.width / canvas.clientWidth;
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.imageSmoothingEnabled = false;
  pen.fillStyle = pattern(pen, "unexplored", brush => {
    brush.fillStyle = "#808890";
    brush.fillRect(0, 0, 8, 8);
    slanted(brush, "#6D757D");
  });
  pen.fillRect(0, 0, canvas.width, canvas.height);
  if (hasPhoto()) drawPhoto(pen, at, scale);
  const side = at.side_mm * at.scale * scale, place = [at.toX(at.left_mm) * scale, at.toY(at.near_mm + at.side_mm) * scale, side, side];
  // A picture is seen through holes, so that the colours stay those of the legend.
  if (hasPhoto()) through(pen, canvas, painting.colours, place, "holes", holes, "source-in");
  else pen.drawImage(painting.colours, ...place);
  through(pen, canvas, painting.stippled, place, "stipple", dots(4, 1));
  through(pen, canvas, painting.dotted, place, "dot", dots(8, 2));
  through(pen, canvas, painting.steep, place, "steep", brush => slanted(brush, "#10151B"));
  if (what.plain) letters(pen, at, scale, what);
  drawStill(canvas, at);
}

function pattern(pen, name, draw) {
  if (!patterns.has(name)) {
    const small = Object.assign(document.createElement("canvas"), { width: 8, height: 8 });
    draw(small.getContext("2d"));
    patterns.set(name, pen.createPattern(small, "repeat"));
  }
  return patterns.get(name);
}

function slanted(brush, ink) {
  brush.strokeStyle = ink;
  brush.lineWidth = 1.2;
  for (const start of [-8, 0, 8]) { brush.moveTo(start, 8); brush.lineTo(start + 8, 0); }
  brush.stroke();
}

function dots(step, size) {
  return brush => {
    brush.fillStyle = "#10151B";
    for (let y = 0; y < 8; y += step) for (let x = (y / step % 2) * step / 2; x < 8; x += step) brush.fillRect(x, y, size, size);
  };
}

function holes(brush) {
  brush.fillRect(0, 0, 8, 8);
  brush.clearRect(0, 0, 4, 4);
}

// Draws a pattern through a mask's cells only, or with "source-in" the cells through a pattern.
const sieve = document.createElement("canvas");
function through(pen, canvas, mask, place, name, draw, how = "destination-in") {
  sieve.width = canvas.width;
  sieve.height = canvas.height;
  const brush = sieve.getContext("2d");
  brush.imageSmoothingEnabled = false;
  brush.fillStyle = pattern(pen, name, draw);
  brush.fillRect(0, 0, sieve.width, sieve.height);
  brush.globalCompositeOperation = how;
  brush.drawImage(mask, ...place);
  pen.drawImage(sieve, 0, 0);
}

// Returns the sign that repeats a colour: a material's letter, or + and − for a temperature off the scale's middle.
function markOf(code, short, { quantity, range, legend: [low, high] }) {
  if (code === UNEXPLORED || quantity !== "temperature") return quantity === "material" ? short[code] : "";
  const off = valueOf(quantity, code, range) - (low + high) / 2;
  return Math.abs(off) < SIGN_K ? "" : off > 0 ? "+" : "−";
}

function letters(pen, at, scale, what) {
  const short = marks(what.materials), step = Math.max(4, Math.round(LETTERS_PX * SIDE / at.side_mm / at.scale));
  pen.font = `600 ${16 * scale}px system-ui, sans-serif`;
  pen.textAlign = "center";
  for (let row = step >> 1; row < SIDE; row += step) {
    for (let column = step >> 1; column < SIDE; column += step) {
      const mark = markOf(codeAt(what.quantity, column, row), short, what);
      if (!mark) continue;
      const x = at.toX(at.left_mm + column * at.side_mm / SIDE) * scale, y = at.toY(at.near_mm + row * at.side_mm / SIDE) * scale;
      word(pen, mark, x, y + 6 * scale, scale);
    }
  }
}
