// Region D: the tactile map along the plane's normal. Only the user moves and zooms it.
import { byId, equal, fit, make, write } from "./dom.js";
import { codeAt, forgetTiles, keepTile, Painting, QUANTITIES, regions, SIDE, UNEXPLORED, valueOf } from "./map_tiles.js";
import { drawLegend } from "./legend.js";
import { drawOver, drawStill, word } from "./map_over.js";
import { now } from "./now.js";
import { onTheme } from "./theme.js";
import { capital, marks, WORDS } from "./words.js";

const ZOOM = 1.5, MOST_ZOOM = 12, LOOK_MS = 250, PAINT_MS = 100, FRAME = { x_m: -0.128, y_m: -0.128, cell_m: 0.001 };
const ENDS = [1, 2], WIDER = 2, SIGN_K = 1;
const NEAR_TIMES = 2, NEAR_TILES = [2, 3, 4, 5]; // the middle 128 mm
const painting = new Painting();
let connection = null, quantity = "temperature", sure = false, zoom = null, middle = null, frameKey = "", legendKey = "", stillKey = "", dirty = true, paintedAt_ms = 0, wider = 0;
let far = false, cursor = null, looked = "", lookedAt_ms = 0, looking = false;

export function startMap(link, pick) {
  connection = link;
  for (const name of QUANTITIES) {
    const button = make("button", { "data-quantity": name }, `${capital(name)} `, make("kbd", { text: capital(name)[0] }));
    button.addEventListener("click", () => show(name));
    byId("quantities").append(button);
  }
  const button = make("button", { id: "sure-button", "aria-pressed": "false" }, `${WORDS.confidence} `, make("kbd", { text: WORDS.confidenceKey }));
  button.addEventListener("click", showSure);
  byId("quantities").append(button);
  byId("zoom-in").addEventListener("click", () => zoomBy(ZOOM));
  byId("zoom-out").addEventListener("click", () => zoomBy(1 / ZOOM));
  onTheme(() => { dirty = true; });
  point(byId("map-surface"), pick);
  show(quantity);
}

export function show(name) {
  quantity = name;
  sure = false;
  wider = 0;
  for (const button of byId("quantities").querySelectorAll("[data-quantity]")) button.setAttribute("aria-pressed", String(button.dataset.quantity === name));
  byId("sure-button").setAttribute("aria-pressed", "false");
  byId("map-surface").setAttribute("aria-label", WORDS.mapName(name));
  connection.send({ kind: "show", quantity });
  repaint();
}

export function showAgain() {
  connection.send({ kind: "show", quantity });
}

export function showSure() {
  sure = !sure;
  byId("sure-button").setAttribute("aria-pressed", String(sure));
  repaint();
}

export function widen(steps) {
  wider = Math.max(-2, Math.min(2, wider + steps));
  repaint();
}

function range() {
  return now.state?.map?.ranges?.[quantity] ?? ENDS;
}

function legend() {
  const reported = now.state?.map?.legend?.[quantity] ?? ENDS;
  if (wider === 0 || quantity === "material") return reported;
  const share = WIDER ** wider, [low, high] = reported;
  if (quantity === "temperature") return [(low + high) / 2 - share * (high - low) / 2, (low + high) / 2 + share * (high - low) / 2];
  const centre = Math.sqrt(low * high), half = Math.sqrt(high / low) ** share;
  return [centre / half, centre * half];
}

export function frame() {
  return now.state?.map?.frame ?? FRAME;
}

function repaint() {
  painting.all(quantity, range(), legend(), sure);
  legendKey = JSON.stringify(legend());
  dirty = true;
}

export function takeTile(tile) {
  keepTile(tile);
  if (!far && !(NEAR_TILES.includes(tile.column) && NEAR_TILES.includes(tile.row)) && tile.values.some(code => code !== UNEXPLORED)) far = dirty = true;
  if (QUANTITIES[tile.quantity] !== quantity) return;
  painting.tile(quantity, tile.column, tile.row, range(), legend(), sure);
  dirty = true;
}

export function followMap(state) {
  // Another frame or another map: all old tiles are invalid.
  const key = JSON.stringify(state.map ? [state.map.frame, state.map.number] : null);
  if (frameKey && key !== frameKey) { forgetTiles(); far = false; repaint(); }
  frameKey = key;
  if (JSON.stringify(legend()) !== legendKey) repaint();
  const still = JSON.stringify([state.findings, state.map?.sides, state.map?.lumps, state.map?.next_mm]);
  if (still !== stillKey) dirty = true;
  stillKey = still;
}

// ---- view: pixels for millimetres

function view(canvas) {
  const here = frame(), side_mm = SIDE * here.cell_m * 1000, centre = middle ?? { x: here.x_m * 1000 + side_mm / 2, y: here.y_m * 1000 + side_mm / 2 };
  const [short, long] = [canvas.clientWidth, canvas.clientHeight].sort((a, b) => a - b);
  // Until the user zooms: the middle, or the whole frame once a finger has touched beyond.
  const times = zoom ?? (far ? Math.min(1.7, long / short) : NEAR_TIMES), scale = times * short / side_mm;
  return {
    times, scale, width: canvas.clientWidth, height: canvas.clientHeight, side_mm, left_mm: here.x_m * 1000, near_mm: here.y_m * 1000,
    toX: x_mm => canvas.clientWidth / 2 + (x_mm - centre.x) * scale, toY: y_mm => canvas.clientHeight / 2 - (y_mm - centre.y) * scale,
    x_mm: x => centre.x + (x - canvas.clientWidth / 2) / scale, y_mm: y => centre.y - (y - canvas.clientHeight / 2) / scale, centre,
  };
}

export function zoomBy(factor) {
  const canvas = byId("map-surface"), at = view(canvas), fixed = cursor ?? fingerPlace() ?? at.centre;
  const next = Math.max(1, Math.min(MOST_ZOOM, at.times * factor)), share = at.times / next;
  middle = next === 1 ? null : { x: fixed.x + (at.centre.x - fixed.x) * share, y: fixed.y + (at.centre.y - fixed.y) * share };
  zoom = next;
  dirty = true;
}

export function fingerPlace() {
  if (!now.picture) return null;
  const x = now.picture.of(now.active, "x_m") * 1000, y = now.picture.of(now.active, "y_m") * 1000;
  return Number.isNaN(x) || Number.isNaN(y) ? null : { x, y };
}

// At most ten times a second, and only when something changed.
export function drawMap(finding, at_ms = performance.now()) {
  const canvas = byId("map-surface");
  if (canvas.clientHeight === 0) return;
  const at = view(canvas);
  if ((fit(canvas) || dirty) && at_ms - paintedAt_ms >= PAINT_MS) {
    paint(canvas, at);
    drawLegend(quantity, legend(), now.state?.map?.materials ?? [], sure, painting.beyond);
    paintedAt_ms = at_ms;
    dirty = false;
  }
  drawOver(byId("map-over"), at, finding, cursor);
}

const patterns = new Map();

function pattern(pen, name, draw) {
  if (!patterns.has(name)) {
    const small = Object.assign(document.createElement("canvas"), { width: 8, height: 8 });
    draw(small.getContext("2d"));
    patterns.set(name, pen.createPattern(small, "repeat"));
  }
  return patterns.get(name);
}

function paint(canvas, at) {
  const pen = canvas.getContext("2d", { alpha: false }), scale = canvas.width / canvas.clientWidth;
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.imageSmoothingEnabled = false;
  pen.fillStyle = pattern(pen, "unexplored", brush => {
    brush.fillStyle = "#808890";
    brush.fillRect(0, 0, 8, 8);
    slanted(brush, "#6D757D");
  });
  pen.fillRect(0, 0, canvas.width, canvas.height);
  const side = at.side_mm * at.scale * scale, place = [at.toX(at.left_mm) * scale, at.toY(at.near_mm + at.side_mm) * scale, side, side];
  pen.drawImage(painting.colours, ...place);
  through(pen, canvas, painting.stippled, place, "stipple", dots(4, 1));
  through(pen, canvas, painting.dotted, place, "dot", dots(8, 2));
  through(pen, canvas, painting.steep, place, "steep", brush => slanted(brush, "#10151B"));
  if (!sure) letters(pen, at, scale);
  drawStill(canvas, at);
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

// Draws a pattern through a mask's cells only.
const sieve = document.createElement("canvas");
function through(pen, canvas, mask, place, name, draw) {
  sieve.width = canvas.width;
  sieve.height = canvas.height;
  const brush = sieve.getContext("2d");
  brush.imageSmoothingEnabled = false;
  brush.fillStyle = pattern(pen, name, draw);
  brush.fillRect(0, 0, sieve.width, sieve.height);
  brush.globalCompositeOperation = "destination-in";
  brush.drawImage(mask, ...place);
  pen.drawImage(sieve, 0, 0);
}

// Returns the sign that repeats a colour: a material's letter, or + and − for a temperature off the scale's middle.
function markOf(code, short, middle) {
  if (code === UNEXPLORED || quantity !== "temperature") return quantity === "material" ? short[code] : "";
  const off = valueOf(quantity, code, range()) - middle;
  return Math.abs(off) < SIGN_K ? "" : off > 0 ? "+" : "−";
}

function letters(pen, at, scale) {
  const short = marks(now.state?.map?.materials ?? []), [low, high] = legend(), step = Math.max(8, Math.round(28 / at.scale));
  pen.font = `600 ${16 * scale}px system-ui, sans-serif`;
  pen.textAlign = "center";
  for (let row = step >> 1; row < SIDE; row += step) {
    for (let column = step >> 1; column < SIDE; column += step) {
      const mark = markOf(codeAt(quantity, column, row), short, (low + high) / 2);
      if (!mark) continue;
      const x = at.toX(at.left_mm + column * at.side_mm / SIDE) * scale, y = at.toY(at.near_mm + row * at.side_mm / SIDE) * scale;
      word(pen, mark, x, y + 6 * scale, scale);
    }
  }
}

// ---- pointing: a pointer moves, drags and turns the wheel; arrow keys move the cursor by 1 or 5 mm

function point(canvas, pick) {
  let dragged = null;
  const place = event => {
    const box = canvas.getBoundingClientRect(), at = view(canvas);
    return { x: at.x_mm(event.clientX - box.left), y: at.y_mm(event.clientY - box.top) };
  };
  canvas.addEventListener("pointerdown", event => {
    dragged = { x: event.clientX, y: event.clientY, centre: view(canvas).centre, far: false };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", event => {
    if (!dragged) { cursor = place(event); return; }
    const dx = event.clientX - dragged.x, dy = event.clientY - dragged.y;
    if (Math.hypot(dx, dy) > 6) dragged.far = true;
    const { scale, times } = view(canvas);
    if (!dragged.far || times === 1) return;
    middle = { x: dragged.centre.x - dx / scale, y: dragged.centre.y + dy / scale };
    dirty = true;
  });
  canvas.addEventListener("pointerup", event => {
    if (dragged && !dragged.far) { cursor = place(event); pick(cursor); }
    dragged = null;
  });
  canvas.addEventListener("pointerleave", () => { if (!dragged) cursor = null; });
  canvas.addEventListener("wheel", event => { event.preventDefault(); zoomBy(event.deltaY < 0 ? 1.15 : 1 / 1.15); }, { passive: false });
  canvas.addEventListener("keydown", event => {
    const step = moved(event);
    if (!step || event.defaultPrevented) return;
    event.preventDefault();
    const from = cursor ?? fingerPlace() ?? view(canvas).centre;
    cursor = { x: Math.round(from.x + step.x), y: Math.round(from.y + step.y) };
  });
  canvas.addEventListener("blur", () => { cursor = null; });
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export function moved(event) {
  const arrow = ARROWS[event.key], far = event.shiftKey ? 5 : 1;
  return arrow ? { x: far * arrow[0], y: far * arrow[1] } : null;
}

// Shows the values at the cursor; requests them at most four times a second.
export async function readOut(said, place = cursor) {
  if (said) { write(byId("read-out"), said); return; }
  if (!place) { looked = ""; write(byId("read-out"), WORDS.pointAtMap); return; }
  const key = `${Math.round(place.x)} ${Math.round(place.y)} ${quantity}`;
  if (looking || (key === looked && performance.now() - lookedAt_ms < 4 * LOOK_MS) || performance.now() - lookedAt_ms < LOOK_MS) return;
  [looked, lookedAt_ms, looking] = [key, performance.now(), true];
  const answer = await connection.ask("place", { x_mm: place.x, y_mm: place.y });
  looking = false;
  const text = answer.ok ? answer.details.text || WORDS.nothingHere : answer.text;
  write(byId("read-out"), `${WORDS.placeOf(place.x, place.y)}: ${text}`);
}

export function showMapTable() {
  const here = frame(), names = now.state?.map?.materials ?? [];
  const value = number => (quantity === "material" ? names[number] ?? "--" : number.toPrecision(3));
  const rows = () => regions(quantity, range()).map(found => [
    (here.x_m * 1000 + found.column * here.cell_m * 1000).toFixed(0), (here.y_m * 1000 + found.row * here.cell_m * 1000).toFixed(0),
    `${Math.round(100 * found.share)} %`, value(found.low), value(found.high)]);
  equal("map-table", `${capital(quantity)}, ${WORDS.legendUnit[quantity]}`, WORDS.mapTable, rows);
}
