// Region D: the tactile map along the plane's normal, as one pane or two. Only the user chooses, moves and zooms what it shows;
// until then it opens on the quantity that was felt in most cells, and fits what was felt.
import { byId, equal, fit, make, onChoice, write } from "./dom.js";
import { drawLegend } from "./legend.js";
import { comparable, COMPARISONS, differences, forgetBefore, hasBefore, keepBefore, SPAN } from "./map_compare.js";
import { drawOver } from "./map_over.js";
import { paintPane } from "./map_paint.js";
import { dragPhoto, endAdjusting, offerCamera, startPhoto } from "./map_photo.js";
import { startPointer } from "./map_pointer.js";
import { forgetTiles, keepTile, Painting, QUANTITIES, regions } from "./map_tiles.js";
import { numberText, unitOf } from "./map_units.js";
import { fitAgain, followFelt, forgetFelt, frame, isFitted, moveTo, viewOf, zoomAt } from "./map_view.js";
import { known, now } from "./now.js";
import { onTheme } from "./theme.js";
import { capital, WORDS } from "./words.js";

export { moved } from "./map_pointer.js";

const ZOOM = 1.5, LOOK_MS = 250, PAINT_MS = 100, COMPARE_MS = 500, ENDS = [1, 2], WIDER = 2, FULLER = 1.5;
const panes = [{ id: "map-surface", over: "map-over" }, { id: "map-surface-2", over: "map-over-2" }].map(pane => ({ ...pane, painting: new Painting(), quantity: null, legendKey: "", comparedAt_ms: -Infinity, stale: false }));
let connection = null, both = false, sure = false, comparison = "none", axis_mm = null, chosen = false;
let frameKey = "", stillKey = "", dirty = true, paintedAt_ms = 0, wider = 0, cursor = null, looked = "", lookedAt_ms = 0, looking = null;

export function startMap(link, pick) {
  connection = link;
  for (const name of QUANTITIES) {
    const button = make("button", { "data-quantity": name }, `${capital(name)} `, make("kbd", { text: capital(name)[0] }));
    button.addEventListener("click", () => show(name));
    byId("quantities").append(button);
  }
  byId("compare").append(...COMPARISONS.map(name => make("option", { value: name, text: WORDS.comparisons[name] })));
  onChoice(byId("compare"), compareWith);
  byId("compare-set").addEventListener("click", setReference);
  byId("sure-button").addEventListener("click", showSure);
  byId("both-button").addEventListener("click", showBoth);
  byId("fit-button").addEventListener("click", fitMap);
  byId("photo-button").addEventListener("click", togglePhoto);
  byId("zoom-in").addEventListener("click", () => zoomBy(ZOOM));
  byId("zoom-out").addEventListener("click", () => zoomBy(1 / ZOOM));
  onTheme(() => { dirty = true; });
  for (const pane of panes) {
    startPointer(byId(pane.id), {
      cursor(place) { cursor = place; }, pick, start: () => cursor ?? fingerPlace(),
      changed() { dirty = true; showTools(); }, dragged: dragPhoto,
    });
  }
  startPhoto(() => { dirty = true; }, () => viewOf(byId(panes[0].id)).centre);
  panes[0].quantity = "temperature";
  panes[1].quantity = "stiffness";
  subscribe();
}

// ---- what is shown

const shownPanes = () => (both ? panes : panes.slice(0, 1));

// Shows a quantity; with two panes, the one before moves to the second.
export function show(name, byUser = true) {
  chosen ||= byUser;
  if (name !== panes[0].quantity) [panes[0].quantity, panes[1].quantity] = [name, panes[0].quantity];
  sure = false;
  wider = 0;
  subscribe();
}

export function showBoth() {
  both = !both;
  subscribe();
}

export function showSure() {
  sure = !sure;
  repaint();
}

// Also after a new connection.
export function subscribe() {
  connection.send({ kind: "show", quantity: panes[0].quantity, ...(both && { second: panes[1].quantity }) });
  repaint();
}

export function widen(steps) {
  wider = Math.max(-2, Math.min(2, wider + steps));
  repaint();
}

export function nextComparison() {
  compareWith(COMPARISONS[(COMPARISONS.indexOf(comparison) + 1) % COMPARISONS.length]);
}

function compareWith(name) {
  comparison = name;
  sure = false;
  repaint();
}

// Sets the mirror's axis at the cursor, or keeps the present map as the earlier one.
function setReference() {
  if (comparison === "mirror") axis_mm = Math.round((cursor ?? fingerPlace() ?? viewOf(byId("map-surface")).centre).x);
  else keepBefore(range);
  repaint();
}

const axis = () => axis_mm ?? (now.state?.map?.felt_mm ? (now.state.map.felt_mm[0] + now.state.map.felt_mm[2]) / 2 : 0);
const differs = quantity => comparison !== "none" && !sure && comparable(quantity);
const range = quantity => now.state?.map?.ranges?.[quantity] ?? ENDS;

function legend(quantity) {
  const reported = now.state?.map?.legend?.[quantity] ?? ENDS;
  if (wider === 0 || quantity === "material") return reported;
  const share = WIDER ** wider, [low, high] = reported;
  if (quantity === "temperature") return [(low + high) / 2 - share * (high - low) / 2, (low + high) / 2 + share * (high - low) / 2];
  const centre = Math.sqrt(low * high), half = Math.sqrt(high / low) ** share;
  return [centre / half, centre * half];
}

function howOf({ quantity }) {
  const here = frame(), axisCell = (axis() / 1000 - here.x_m) / here.cell_m;
  const compared = differs(quantity) ? { differences: differences(quantity, comparison, range(quantity), axisCell), span: SPAN[quantity] * WIDER ** wider } : {};
  return { range: range(quantity), legend: legend(quantity), sure, ...compared };
}

function repaint() {
  for (const pane of shownPanes()) paintAll(pane);
  showTools();
}

function paintAll(pane) {
  pane.painting.all(pane.quantity, howOf(pane));
  pane.legendKey = JSON.stringify(legend(pane.quantity));
  pane.comparedAt_ms = performance.now();
  pane.stale = false;
  dirty = true;
}

function showTools() {
  for (const button of byId("quantities").querySelectorAll("[data-quantity]")) {
    button.setAttribute("aria-pressed", String(shownPanes().some(pane => pane.quantity === button.dataset.quantity)));
  }
  byId("sure-button").setAttribute("aria-pressed", String(sure));
  byId("both-button").setAttribute("aria-pressed", String(both));
  byId("fit-button").disabled = isFitted();
  byId("compare").value = comparison;
  byId("compare-set").hidden = !["mirror", "before"].includes(comparison);
  write(byId("compare-set"), comparison === "mirror" ? WORDS.axisHere : WORDS.keepNow);
  byId("map").classList.toggle("both", both);
  for (const pane of panes) byId(pane.id).setAttribute("aria-label", WORDS.mapName(pane.quantity, comparison));
}

function togglePhoto() {
  const tray = byId("photo");
  tray.hidden = !tray.hidden;
  offerCamera();
  if (tray.hidden) endAdjusting();
  byId("photo-button").setAttribute("aria-expanded", String(!tray.hidden));
}

// ---- what the console sends

export function takeTile(tile) {
  keepTile(tile);
  for (const pane of shownPanes()) {
    if (QUANTITIES[tile.quantity] !== pane.quantity) continue;
    if (differs(pane.quantity)) pane.stale = true; // a difference depends on other tiles, too
    else pane.painting.tile(pane.quantity, tile.column, tile.row, howOf(pane));
    dirty = true;
  }
}

export function followMap(state) {
  // Another frame or another map: all old tiles are invalid.
  const key = JSON.stringify(state.map ? [state.map.frame, state.map.number] : null);
  if (frameKey && key !== frameKey) { forgetTiles(); forgetBefore(); forgetFelt(); axis_mm = null; repaint(); }
  frameKey = key;
  if (shownPanes().some(pane => JSON.stringify(legend(pane.quantity)) !== pane.legendKey)) repaint();
  if (followFelt(state.map?.felt_mm)) dirty = true;
  openOnFullest(state.map?.felt_cells);
  const still = JSON.stringify([state.findings, state.patient?.reports, state.patient?.tender, state.map?.sides, state.map?.lumps, state.map?.stale_mm]);
  if (still !== stillKey) dirty = true;
  stillKey = still;
}

function openOnFullest(cells) {
  if (chosen || !cells) return;
  const fullest = QUANTITIES.reduce((best, name) => (cells[name] > cells[best] ? name : best));
  if (cells[fullest] > FULLER * cells[panes[0].quantity]) show(fullest, false);
}

// ---- view

export function zoomBy(factor) {
  const canvas = byId("map-surface");
  zoomAt(canvas, factor, cursor ?? fingerPlace() ?? viewOf(canvas).centre);
  dirty = true;
  showTools();
}

export function fitMap() {
  fitAgain();
  dirty = true;
  showTools();
}

// Moves middle and cursor of the map to a place, mm.
export function lookAt(x_mm, y_mm) {
  cursor = { x: x_mm, y: y_mm };
  moveTo(byId("map-surface"), { ...cursor });
  dirty = true;
  showTools();
}

export function fingerPlace() {
  if (!now.picture) return null;
  const x = now.picture.of(now.active, "x_m") * 1000, y = now.picture.of(now.active, "y_m") * 1000;
  return Number.isNaN(x) || Number.isNaN(y) ? null : { x, y };
}

// At most ten times a second, and only when something changed.
export function drawMap(finding, at_ms = performance.now()) {
  if (byId("map-surface").clientHeight === 0) return;
  for (const pane of shownPanes()) if (pane.stale && at_ms - pane.comparedAt_ms >= COMPARE_MS) paintAll(pane);
  const resized = shownPanes().map(pane => fit(byId(pane.id))).some(Boolean);
  const paints = (resized || dirty) && at_ms - paintedAt_ms >= PAINT_MS, mirror = comparison === "mirror" ? axis() : null;
  shownPanes().forEach((pane, number) => {
    const canvas = byId(pane.id), at = viewOf(canvas), { quantity, painting } = pane, materials = now.state?.map?.materials ?? [], compared = differs(quantity);
    if (paints) {
      paintPane(canvas, at, { painting, quantity, range: range(quantity), legend: legend(quantity), materials, plain: !sure && !compared });
      drawLegend(number, { quantity, legend: legend(quantity), materials, sure, span: compared ? SPAN[quantity] * WIDER ** wider : null, beyond: painting.beyond });
    }
    drawOver(byId(pane.over), at, finding, cursor, compared ? mirror : null);
  });
  if (!paints) return;
  paintedAt_ms = at_ms;
  dirty = false;
}

// Shows the values at the cursor; requests them at most four times a second. Drops an answer when something else was shown since.
export async function readOut(said) {
  const place = cursor, instead = said || insteadOfValues();
  if (instead) { [looked, looking] = ["", null]; write(byId("read-out"), instead); return; }
  const key = `${Math.round(place.x)} ${Math.round(place.y)} ${panes[0].quantity} ${comparison}`, at_ms = performance.now();
  if (looking || (key === looked && at_ms - lookedAt_ms < 4 * LOOK_MS) || at_ms - lookedAt_ms < LOOK_MS) return;
  const mine = {};
  [looked, lookedAt_ms, looking] = [key, at_ms, mine];
  const text = comparison === "mirror" ? WORDS.mirrored(await valueAt(place), await valueAt({ x: 2 * axis() - place.x, y: place.y })) : await valueAt(place);
  if (looking !== mine) return;
  looking = null;
  if (cursor) write(byId("read-out"), `${WORDS.placeOf(place.x, place.y)}: ${text}`);
}

function insteadOfValues() {
  if (!known()) return "--";
  if (comparison === "before" && !hasBefore(panes[0].quantity)) return WORDS.nothingBefore;
  return cursor ? "" : WORDS.pointAtMap;
}

async function valueAt(place) {
  const answer = await connection.ask("place", { x_mm: place.x, y_mm: place.y });
  return answer.ok ? answer.details.text || WORDS.nothingHere : answer.text;
}

export function showMapTable() {
  const here = frame(), names = now.state?.map?.materials ?? [], [{ quantity }] = panes;
  const text = number => (quantity === "material" ? names[number] ?? "--" : numberText(quantity, number, value => value.toPrecision(3)));
  const rows = () => regions(quantity, range(quantity)).map(found => [
    (here.x_m * 1000 + found.column * here.cell_m * 1000).toFixed(0), (here.y_m * 1000 + found.row * here.cell_m * 1000).toFixed(0),
    `${Math.round(100 * found.share)} %`, text(found.low), text(found.high)]);
  equal("map-table", `${capital(quantity)}, ${unitOf(quantity)}`, WORDS.mapTable, rows);
}
