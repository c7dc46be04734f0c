// A still picture under the map, chosen from a file. It stays in this page. While it is adjusted, a drag moves and a pinch scales it.
import { byId, write } from "./dom.js";
import { WORDS } from "./words.js";

const WIDTH_MM = 150, STEP = 1.05;
let photo = null; // {image, x, y, width} with centre and width in mm
let adjusting = false, changed = () => {};

export function startPhoto(redraw, centre) {
  changed = redraw;
  byId("photo-file").addEventListener("change", async event => {
    const [file] = event.target.files;
    event.target.value = "";
    if (!file) return;
    try { photo = { image: await createImageBitmap(file), ...centre(), width: WIDTH_MM }; } catch { write(byId("photo-said"), WORDS.notAPicture); return; }
    write(byId("photo-said"), "");
    adjust(true);
  });
  byId("photo-choose").addEventListener("click", () => byId("photo-file").click());
  byId("photo-adjust").addEventListener("click", () => adjust(!adjusting));
  byId("photo-smaller").addEventListener("click", () => scale(1 / STEP));
  byId("photo-larger").addEventListener("click", () => scale(STEP));
  byId("photo-remove").addEventListener("click", () => { photo = null; adjust(false); });
}

export const hasPhoto = () => photo !== null;

function adjust(on) {
  adjusting = on && photo !== null;
  for (const id of ["photo-adjust", "photo-smaller", "photo-larger", "photo-remove"]) byId(id).disabled = photo === null;
  byId("photo-adjust").setAttribute("aria-pressed", String(adjusting));
  changed();
}

function scale(factor) {
  photo.width = Math.max(5, Math.min(2000, photo.width * factor));
  changed();
}

// Takes a drag, mm, and a pinch while the picture is adjusted; returns whether it did.
export function dragPhoto(by, factor) {
  if (!adjusting) return false;
  photo.x += by.x;
  photo.y += by.y;
  scale(factor);
  return true;
}

export function endAdjusting() {
  adjust(false);
}

export function drawPhoto(pen, at, scale) {
  const { image, x, y, width } = photo, high = width * image.height / image.width, px = scale * at.scale;
  pen.drawImage(image, at.toX(x - width / 2) * scale, at.toY(y + high / 2) * scale, width * px, high * px);
}
