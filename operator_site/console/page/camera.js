// The remote site's camera over a part of the map: VP8 over a websocket of its own, decoded by the browser. A browser
// that cannot decode it gets still pictures, JPEG files that the console makes of some of the pictures.
import { openBeside } from "./connection.js";
import { byId, write } from "./dom.js";
import { now, playback } from "./now.js";
import { WORDS } from "./words.js";

const FROZEN_S = 0.45; // the name stands within 0.5 s of the capture
const STILL_S = 0.5; // interval between two still pictures
const MAGIC = 0x7ea8, VERSION = 1, HEADER = 24, LEAD_MS = 5000, SIZES = ["small", "large", "off"];
let socket = null, decoder = null, waits = true, size = 0, drawn = null, drawnAt_ms = -Infinity, failed = false;
const sent = new Map(); // header of each picture in the decoder, by its time stamp
let stamp = 0, timer = null, leads = [-Infinity, -Infinity], begun_ms = 0, changed = () => {}, picks = null;

export function decodePicture(buffer) {
  if (buffer.byteLength <= HEADER) throw new RangeError(`${buffer.byteLength} bytes`);
  const view = new DataView(buffer);
  const picture = {
    isKey: Boolean(view.getUint8(3) & 1), sequence: view.getUint32(4, true), captured_s: view.getFloat64(8, true),
    uncertainty_s: view.getFloat32(16, true), width: view.getUint16(20, true), height: view.getUint16(22, true), content: new Uint8Array(buffer, HEADER),
  };
  if (view.getUint16(0, true) !== MAGIC || view.getUint8(2) !== VERSION) throw new RangeError("not a picture of version 1");
  if (!(Math.abs(picture.captured_s) < 1e12) || !(picture.uncertainty_s >= 0) || !picture.width || !picture.height) throw new RangeError("range");
  return picture;
}

export function startCamera(redraw) {
  changed = redraw;
  byId("camera").addEventListener("click", event => (picks && event.detail ? pick(event) : nextSize())); // a key has no place
}

// Shows the picture large and gives each tapped place, 0 to 1 of width and height, to `taken`; null ends this.
export function pickInPicture(taken) {
  picks = taken;
  size = taken ? SIZES.indexOf("large") : 0;
  showCamera();
}

// The picture is as large as fits into its canvas.
function pick({ clientX, clientY }) {
  const canvas = byId("camera-picture"), box = canvas.getBoundingClientRect(), scale = Math.min(box.width / canvas.width, box.height / canvas.height);
  const u = 0.5 + (clientX - box.left - box.width / 2) / (canvas.width * scale), v = 0.5 + (clientY - box.top - box.height / 2) / (canvas.height * scale);
  if (Math.abs(u - 0.5) <= 0.5 && Math.abs(v - 0.5) <= 0.5) picks(u, v);
}

// Returns whether places were still asked for.
export function endPicking() {
  const asked = picks !== null;
  if (asked) pickInPicture(null);
  return asked;
}

export function nextSize() {
  if (byId("camera").hidden) return;
  size = (size + 1) % SIZES.length;
  showCamera();
}

// WebCodecs exist on HTTPS and on localhost only.
const decodes = () => typeof VideoDecoder !== "undefined" && !failed;

const open = () => { socket = openBeside("camera", { onopen: askStills, onmessage: event => take(event.data), onclose: end }, () => { socket = null; }); };

function end() {
  if (decoder?.state === "configured") decoder.close();
  decoder = null;
  waits = true;
  sent.clear();
}

const say = message => { if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message)); };

const askStills = () => { if (!decodes()) say({ kind: "still" }); };

function lost(error) {
  end();
  failed ||= error?.name === "NotSupportedError";
  say({ kind: decodes() ? "lost" : "still" });
}

function take(data) {
  let picture;
  try { picture = decodePicture(data); } catch { return; } // such as of a newer version
  if (!decodes()) { takeStill(picture); return; }
  if (waits && !picture.isKey) return;
  try {
    if (!decoder) {
      decoder = new VideoDecoder({ output: drawFrame, error: lost });
      decoder.configure({ codec: "vp8", optimizeForLatency: true });
    }
    stamp += 1;
    sent.set(stamp, picture);
    decoder.decode(new EncodedVideoChunk({ type: picture.isKey ? "key" : "delta", timestamp: stamp, data: picture.content }));
    waits = false;
  } catch (error) { lost(error); }
}

async function takeStill(picture) {
  try {
    const image = await createImageBitmap(new Blob([picture.content], { type: "image/jpeg" }));
    draw(image, image.width, image.height, picture);
  } catch { say({ kind: "lost" }); }
}

function drawFrame(frame) {
  const picture = sent.get(frame.timestamp);
  sent.delete(frame.timestamp);
  draw(frame, frame.displayWidth, frame.displayHeight, picture);
}

function draw(image, width, height, picture) {
  const canvas = byId("camera-picture");
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  canvas.getContext("2d").drawImage(image, 0, 0);
  image.close();
  if (!picture) return;
  drawn = picture;
  drawnAt_ms = performance.now();
  say({ kind: "drawn", sequence: picture.sequence });
  showCamera();
  changed();
  clearTimeout(timer);
  timer = setTimeout(showCamera, Math.max(0, 1000 * (longest_s() - pictureAge_s())) + 5);
}

// The site's clock ahead of the page's, s: a delay only lowers what a message shows, so the largest of 5 to 10 s is kept.
export function followClock(message) {
  if (message.came_ms - begun_ms > LEAD_MS) { leads = [leads[1], -Infinity]; begun_ms = message.came_ms; }
  leads[1] = Math.max(leads[1], message.time_s - message.came_ms / 1000);
}

// The site's clock, s.
export const siteTime_s = () => performance.now() / 1000 + Math.max(...leads);

// Age of the drawn picture on the site's clock, s; a paused recording stands still.
export function pictureAge_s() {
  if (!drawn || !now.picture) return Infinity;
  if (playback()) return Math.max(0, now.picture.time_s - drawn.captured_s);
  const at_ms = performance.now();
  return Math.max((at_ms - drawnAt_ms) / 1000, siteTime_s() - drawn.captured_s);
}

// Between two still pictures the drawn one grows older; the console names the camera that is late or frozen meanwhile.
const longest_s = () => FROZEN_S + (decodes() ? 0 : STILL_S);
export const frozen = () => pictureAge_s() > longest_s() || (!decodes() && now.state?.camera?.seen !== "live");

function said(camera) {
  if (!decodes() && !camera.stills) return WORDS.cameraNeeds;
  if (["no_camera", "refused"].includes(camera.seen)) return WORDS.camera[camera.seen];
  const age = pictureAge_s();
  if (age === Infinity) return WORDS.camera.waiting;
  const text = WORDS.camera[!frozen() ? "live" : camera.seen === "late" ? "late" : "frozen"](age);
  return [text, ...(camera.reduced && !frozen() ? [WORDS.camera.reduced] : []), ...(decodes() ? [] : [WORDS.camera.still(window.isSecureContext)])].join(" · ");
}

// Runs ten times a second and with each picture.
export function showCamera() {
  const camera = now.state?.camera, button = byId("camera");
  button.hidden = !camera;
  if (!camera) return;
  if (!socket && (decodes() || camera.stills) && now.connected) open();
  byId("map-view").dataset.camera = SIZES[size];
  byId("camera-picture").hidden = !drawn || SIZES[size] === "off";
  const is = frozen();
  if (is !== button.classList.contains("frozen")) { button.classList.toggle("frozen", is); changed(); }
  write(byId("camera-said"), said(camera));
}
