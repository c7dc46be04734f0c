// The body diagram: a view, a region of it, a side, and the distance from a landmark. Region buttons beside the picture
// offer the same by keyboard.
import { byId, make, write } from "./dom.js";
import { BODY_SIDES, capital, WORDS } from "./words.js";

const FARTHEST_MM = 1000;
let picture = null, mark = null, done = null, opener = null, view = "front";

export async function startBody() {
  for (const side of BODY_SIDES) byId("body-sides").append(choice(side || WORDS.noSide, () => choose({ side }), side));
  byId("body-use").addEventListener("click", use);
  byId("body-none").addEventListener("click", () => finish(null));
  byId("body-close").addEventListener("click", closeBody);
  for (const id of ["body-landmark", "body-mm"]) byId(id).addEventListener("change", show);
  const text = await (await fetch("/page/body.svg")).text();
  picture = document.importNode(new DOMParser().parseFromString(text, "image/svg+xml").documentElement, true);
  picture.setAttribute("aria-hidden", "true");
  byId("body-picture").append(picture);
  for (const group of picture.querySelectorAll("g")) byId("body-views").append(choice(group.id, () => turn(group.id), group.id));
  picture.addEventListener("click", event => {
    const { r, s } = event.target.dataset;
    if (r) choose({ region: r, side: s ?? "" });
  });
}

function choice(text, press, value) {
  const button = make("button", { type: "button", "aria-pressed": "false", "data-value": value }, capital(text));
  button.addEventListener("click", press);
  return button;
}

// Opens the diagram with a mark or without one; `use` takes the new mark, or null.
export function openBody(before, use) {
  if (!picture) return;
  [mark, done, opener] = [{ region: "", side: "", ...before }, use, document.activeElement];
  byId("body-landmark").value = before?.landmark ?? "";
  byId("body-mm").value = before?.landmark_mm ?? "";
  byId("sheet-body").hidden = false;
  turn(shapes(mark.region)[0]?.parentElement.id ?? view);
  byId("body-views").querySelector("[aria-pressed=true]").focus();
}

export function closeBody() {
  if (byId("sheet-body").hidden) return false;
  byId("sheet-body").hidden = true;
  opener?.focus();
  return true;
}

// A number field would drop the comma of "12,5".
function typed() {
  const said = byId("body-mm").value.trim().replace(",", "."), far = /^\d*\.?\d*$/.test(said) ? Number(said) : NaN;
  return { landmark: byId("body-landmark").value.trim(), landmark_mm: said === "" ? null : far };
}

function use() {
  const place = { ...mark, ...typed() };
  if (!(place.landmark_mm <= FARTHEST_MM)) { write(byId("body-said"), WORDS.landmarkFar(FARTHEST_MM)); byId("body-mm").focus(); return; }
  finish(place);
}

function finish(chosen) {
  closeBody();
  done(chosen);
}

const shapes = region => [...picture.querySelectorAll("[data-r]")].filter(shape => shape.dataset.r === region);

function turn(name) {
  view = name;
  const group = picture.getElementById(name), left = [...picture.querySelectorAll("g")].indexOf(group) * 100;
  picture.setAttribute("viewBox", `${left} 0 100 200`);
  const regions = new Set([...group.querySelectorAll("[data-r]")].map(shape => shape.dataset.r));
  byId("body-regions").replaceChildren(...[...regions].map(region => choice(region, () => choose({ region }), region)));
  show();
}

function choose(part) {
  Object.assign(mark, part);
  if (!shapes(mark.region).some(shape => shape.dataset.s)) mark.side = "";
  else if (part.region && !mark.side) mark.side = "right";
  show();
}

function show() {
  for (const [id, value] of [["body-views", view], ["body-regions", mark.region], ["body-sides", mark.side]])
    for (const button of byId(id).children) button.setAttribute("aria-pressed", String(button.dataset.value === value));
  const sided = shapes(mark.region).some(shape => shape.dataset.s);
  byId("body-sides").hidden = !sided;
  for (const shape of picture.querySelectorAll("[data-r]"))
    shape.classList.toggle("marked", shape.dataset.r === mark.region && (!sided || [shape.dataset.s, "both"].includes(mark.side)));
  byId("body-use").disabled = !mark.region;
  write(byId("body-said"), mark.region ? capital(bodyText({ ...mark, ...typed() })) : WORDS.bodyAsk);
}

export function bodyText(place) {
  if (!place) return "";
  const words = `${place.side} ${place.region}`.trim();
  return place.landmark ? `${words}, ${WORDS.landmarkAt(place.landmark, place.landmark_mm)}` : words;
}
