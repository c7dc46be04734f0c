// Pointing at the map: a tap or the mouse picks a place, one pointer drags, two pinch, the wheel zooms, arrows move by 1 or 5 mm.
import { moveTo, viewOf, zoomAt } from "./map_view.js";

const FAR_PX = 6, WHEEL = 1.15;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export function moved(event) {
  const arrow = ARROWS[event.key], far = event.shiftKey ? 5 : 1;
  return arrow ? { x: far * arrow[0], y: far * arrow[1] } : null;
}

// acts: {cursor(place or null), pick(place), start(), changed(), dragged({x, y} in mm, factor): whether something else took the drag}
export function startPointer(canvas, acts) {
  const pointers = new Map();
  let far = false;
  const inside = ({ clientX, clientY }) => { const box = canvas.getBoundingClientRect(); return { x: clientX - box.left, y: clientY - box.top }; };
  const place = event => { const at = viewOf(canvas), { x, y } = inside(event); return { x: at.x_mm(x), y: at.y_mm(y) }; };
  const whole = ({ x, y }) => ({ x: Math.round(x), y: Math.round(y) }); // as shown, and as marked
  const middle = all => ({ x: all.reduce((sum, p) => sum + p.x, 0) / all.length, y: all.reduce((sum, p) => sum + p.y, 0) / all.length });
  const apart = all => (all.length < 2 ? 1 : Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y));

  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    if (pointers.size === 0) far = false;
    pointers.set(event.pointerId, { ...inside(event), start: inside(event) });
    if (pointers.size > 1) far = true;
  });
  canvas.addEventListener("pointermove", event => {
    const pointer = pointers.get(event.pointerId);
    if (!pointer) { if (event.pointerType === "mouse") acts.cursor(whole(place(event))); return; }
    const before = [...pointers.values()].map(({ x, y }) => ({ x, y }));
    Object.assign(pointer, inside(event));
    const after = [...pointers.values()];
    if (Math.hypot(pointer.x - pointer.start.x, pointer.y - pointer.start.y) > FAR_PX) far = true;
    if (far) drag(middle(before), middle(after), apart(after) / apart(before));
  });
  const ended = event => {
    const tapped = pointers.delete(event.pointerId) && pointers.size === 0 && !far && event.type === "pointerup";
    if (tapped) { acts.cursor(whole(place(event))); acts.pick(whole(place(event))); }
  };
  canvas.addEventListener("pointerup", ended);
  canvas.addEventListener("pointercancel", ended);
  canvas.addEventListener("pointerleave", event => { if (event.pointerType === "mouse" && pointers.size === 0) acts.cursor(null); });
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    zoomAt(canvas, event.deltaY < 0 ? WHEEL : 1 / WHEEL, place(event));
    acts.changed();
  }, { passive: false });
  canvas.addEventListener("keydown", event => {
    const step = moved(event);
    if (!step || event.defaultPrevented) return;
    event.preventDefault();
    const from = acts.start() ?? viewOf(canvas).centre;
    acts.cursor({ x: Math.round(from.x + step.x), y: Math.round(from.y + step.y) });
  });

  function drag(from, to, factor) {
    const at = viewOf(canvas), by = { x: (to.x - from.x) / at.scale, y: (from.y - to.y) / at.scale };
    if (acts.dragged(by, factor)) return;
    moveTo(canvas, { x: at.centre.x - by.x, y: at.centre.y - by.y });
    if (factor !== 1) { const next = viewOf(canvas); zoomAt(canvas, factor, { x: next.x_mm(to.x), y: next.y_mm(to.y) }); }
    acts.changed();
  }
}
