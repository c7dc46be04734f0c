// A picture under the map: a still one from a file, which stays in this page, or the camera's. While it is adjusted, a drag
// moves and a pinch scales it. The camera's may be registered by marks instead.
import { endPicking, frozen } from "./camera.js";
import { askMarks } from "./camera_marks.js";
import { byId, write } from "./dom.js";
import { now } from "./now.js";
import { WORDS } from "./words.js";

const WIDTH_MM = 150, STEP = 1.05, FADED = 0.4;
let photo = null; // {image, x, y, width} with centre and width in mm, live: of the camera, matrix: of its registration
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
  byId("photo-camera").addEventListener("click", () => { photo = { image: byId("camera-picture"), ...centre(), width: WIDTH_MM, live: true, matrix: null }; adjust(true); });
  byId("photo-marks").addEventListener("click", () => { adjust(false); askMarks(text => write(byId("photo-said"), text), fit => { if (photo?.live) photo.matrix = fit?.matrix ?? null; changed(); }); });
  byId("photo-choose").addEventListener("click", () => byId("photo-file").click());
  byId("photo-adjust").addEventListener("click", () => adjust(!adjusting));
  byId("photo-smaller").addEventListener("click", () => scale(1 / STEP));
  byId("photo-larger").addEventListener("click", () => scale(STEP));
  byId("photo-remove").addEventListener("click", () => { photo = null; adjust(false); });
}

export const hasPhoto = () => photo !== null;

export function cameraDrew() {
  if (photo?.live) changed();
}

export function offerCamera() {
  for (const id of ["photo-camera", "photo-marks"]) byId(id).hidden = !now.state?.camera;
}

// Anything else that is done with a picture ends a registration that was begun.
function adjust(on) {
  if (endPicking()) write(byId("photo-said"), "");
  adjusting = on && photo !== null;
  if (adjusting) photo.matrix = null;
  byId("photo-marks").disabled = !photo?.live;
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
  const { image, x, y, width, matrix } = photo, high = width * image.height / image.width, px = scale * at.scale;
  pen.save();
  if (photo.live && frozen()) { pen.filter = "grayscale(1)"; pen.globalAlpha = FADED; }
  if (matrix) {
    const [a, d, b, e, c, f] = matrix;
    pen.transform(px * a, -px * d, px * b, -px * e, at.toX(c) * scale, at.toY(f) * scale);
    pen.drawImage(image, 0, 0, 1, 1);
  } else pen.drawImage(image, at.toX(x - width / 2) * scale, at.toY(y + high / 2) * scale, width * px, high * px);
  pen.restore();
}
