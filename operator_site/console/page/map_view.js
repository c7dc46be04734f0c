// View of the map: pixels for millimetres. It fits what was felt until the user moves or zooms it. All panes share it.
import { SIDE } from "./map_tiles.js";
import { now } from "./now.js";

const FRAME = { x_m: -0.128, y_m: -0.128, cell_m: 0.001 };
const LEAST_MM = 60, FIRST_MM = 128, MARGIN_MM = 6, MARGIN = 0.08, MOST_PX_MM = 40, LEAST_SHARE = 0.8;
let box = null; // edges of the fitted area, mm
let chosen = null; // the user's view: centre, mm, and scale, pixels for a millimetre

export function frame() {
  return now.state?.map?.frame ?? FRAME;
}

// Fits again once something was felt outside of the fitted area; returns whether the view changed.
export function followFelt(felt) {
  if (!felt) return false;
  const [left, near, right, far] = felt;
  if (box && left >= box[0] && near >= box[1] && right <= box[2] && far <= box[3]) return false;
  const x = MARGIN_MM + MARGIN * (right - left), y = MARGIN_MM + MARGIN * (far - near);
  box = [left - x, near - y, right + x, far + y];
  return chosen === null;
}

export function forgetFelt() {
  box = null;
}

export function fitAgain() {
  chosen = null;
}

export const isFitted = () => chosen === null;

function fittedTo(width, height) {
  const here = frame(), side_mm = SIDE * here.cell_m * 1000, middle = { x: here.x_m * 1000 + side_mm / 2, y: here.y_m * 1000 + side_mm / 2 };
  if (!box) return { centre: middle, scale: Math.min(width, height) / FIRST_MM };
  const wide = Math.max(LEAST_MM, box[2] - box[0]), high = Math.max(LEAST_MM, box[3] - box[1]);
  return { centre: { x: (box[0] + box[2]) / 2, y: (box[1] + box[3]) / 2 }, scale: Math.min(width / wide, height / high) };
}

export function viewOf(canvas) {
  const width = canvas.clientWidth, height = canvas.clientHeight, here = frame(), { centre, scale } = chosen ?? fittedTo(width, height);
  return {
    width, height, centre, scale, side_mm: SIDE * here.cell_m * 1000, left_mm: here.x_m * 1000, near_mm: here.y_m * 1000,
    toX: x_mm => width / 2 + (x_mm - centre.x) * scale, toY: y_mm => height / 2 - (y_mm - centre.y) * scale,
    x_mm: x => centre.x + (x - width / 2) / scale, y_mm: y => centre.y - (y - height / 2) / scale,
  };
}

export function moveTo(canvas, centre) {
  chosen = { centre, scale: viewOf(canvas).scale };
}

// Zooms by a factor; the place `fixed`, mm, stays where it is.
export function zoomAt(canvas, factor, fixed) {
  const { centre, scale, width, height, side_mm } = viewOf(canvas);
  const least = LEAST_SHARE * Math.min(width, height) / side_mm, next = Math.max(least, Math.min(MOST_PX_MM, scale * factor)), share = scale / next;
  chosen = { scale: next, centre: { x: fixed.x + (centre.x - fixed.x) * share, y: fixed.y + (centre.y - fixed.y) * share } };
}
