// Finds elements by id and makes them without markup; writes only changed text.
export function byId(id) {
  return document.getElementById(id);
}

export function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") element.textContent = value;
    else if (value != null && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

export function shape(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const use = document.createElementNS("http://www.w3.org/2000/svg", "use");
  use.setAttribute("href", `#shape-${name}`);
  svg.setAttribute("aria-hidden", "true");
  svg.append(use);
  return svg;
}

// Stores a choice of the user; where the browser forbids storage, it lasts until the reload.
export function remember(name, value) {
  try { localStorage.setItem(`teletaction-${name}`, value); } catch { /* forbidden */ }
}

export function remembered(name) {
  try { return localStorage.getItem(`teletaction-${name}`); } catch { return null; }
}

// Replaces children only when their data changed, so that a list keeps focus and reading place.
const made = new WeakMap();
export function remake(element, from, children) {
  const key = JSON.stringify(from);
  if (made.get(element) === key) return;
  made.set(element, key);
  element.replaceChildren(...children());
}

// Fills the table with the contents of a canvas, again while it has the focus. A row begins with its name.
export function equal(id, caption, heads, rowsOf) {
  const table = byId(id), host = table.parentElement;
  if (document.activeElement !== host && host.dataset.filled) return;
  host.dataset.filled = "true";
  const rows = rowsOf();
  remake(table, [caption, rows], () => [make("caption", { text: caption }), make("tr", {}, ...heads.map(text => make("th", { scope: "col", text }))),
    ...rows.map(([name, ...values]) => make("tr", {}, make("th", { scope: "row", text: name }), ...values.map(text => make("td", { text }))))]);
}

// Fits a canvas to the screen's resolution; returns whether all of it must be drawn again.
export function fit(canvas) {
  const scale = window.devicePixelRatio || 1;
  const width = Math.max(1, Math.round(canvas.clientWidth * scale));
  const height = Math.max(1, Math.round(canvas.clientHeight * scale));
  if (canvas.width === width && canvas.height === height) return false;
  canvas.width = width;
  canvas.height = height;
  return true;
}

// Returns a pen for a fitted canvas that draws in CSS pixels.
export function penOf(canvas) {
  fit(canvas);
  const scale = canvas.width / canvas.clientWidth, pen = canvas.getContext("2d");
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  return pen;
}

// Returns a function that does nothing while it is not done yet, such as on the second click of two.
export function once(act) {
  let doing = false;
  return async () => {
    if (doing) return;
    doing = true;
    try { await act(); } finally { doing = false; }
  };
}

// Acts on a choice from a list, which gives the focus back: it would keep the letter keys.
export function onChoice(list, act) {
  list.addEventListener("change", () => { list.blur(); act(list.value); });
}

export function typing() {
  return document.activeElement?.matches("input:not([type=range]), textarea");
}
