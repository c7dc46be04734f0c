// STOP: acts on the press, repeats until it is answered, and shows the answer of each device.
import { byId, make, remake, typing, write } from "./dom.js";
import { known, now, playback, silent_s, underWay } from "./now.js";
import { capital, DEVICE_LABELS, WORDS } from "./words.js";

const AGAIN_MS = 50;
let connection = null, changed = null, id = null, timer = null;

export function startStop(link, show) {
  connection = link;
  changed = show;
  const button = byId("stop");
  button.addEventListener("pointerdown", event => {
    event.preventDefault();
    button.focus({ preventScroll: true });
    press();
  });
  // Enter, or Space where it is no STOP key, acts when the key goes down.
  button.addEventListener("keydown", event => {
    if ((event.key === "Enter" || event.key === " ") && !event.repeat) { event.preventDefault(); press(); }
  });
  // Assistive software sends a click alone.
  button.addEventListener("click", event => { if (event.detail === 0 && id === null) press(); });
}

export function press() {
  if (id !== null) return;
  id = connection.newId();
  now.stopPressed = true;
  send();
  timer = setInterval(send, AGAIN_MS);
  changed();
}

function send() {
  connection.repeat(id, "estop", answer => {
    if (id === null || answer.id !== id) return;
    if (answer.ok) finish();
    else id = connection.newId();
  });
}

// Sends a pending STOP first on a new connection.
export function sendKept() {
  if (id !== null) send();
}

function finish() {
  clearInterval(timer);
  id = null;
  // STOPPING is shown until a state after the answer reports the devices.
  const until = setInterval(() => {
    if (!now.state || now.state.stop || ["stopped", "fault"].includes(now.state.session.state) || !now.connected) {
      clearInterval(until);
      now.stopPressed = false;
      changed();
    }
  }, AGAIN_MS);
}

export function showStop() {
  const stop = now.state ? now.state.stop : null;
  write(byId("stop-key"), !known() && !playback() ? WORDS.notLiveFor(silent_s()) : !underWay() ? WORDS.stopKeyOff : typing() ? WORDS.escapeKey : WORDS.spaceKey);
  const answers = byId("answers");
  answers.hidden = !now.stopPressed && !stop;
  if (answers.hidden) return;
  const times = stop ? stop.devices : {};
  const asked = stop && Object.keys(times).length ? DEVICE_LABELS.filter(([device]) => device in times) : DEVICE_LABELS;
  const missing = asked.filter(([device]) => typeof times[device] !== "number");
  write(byId("answers-title"), title(stop, times, missing));
  const from = asked.map(([device]) => [device, times[device] ?? null, Boolean(stop && stop.late)]);
  remake(byId("answers-list"), from, () => asked.map(([device, label]) => {
    const time_s = times[device], stopped = typeof time_s === "number";
    const wide = label.length > 2 ? "wide " : "";
    return make("li", { class: wide + (stopped ? "stopped" : stop && stop.late ? "late" : "") }, label, make("span", { text: stopped ? WORDS.stopped : WORDS.waiting }), ...(stopped ? [make("span", { text: WORDS.stoppedIn(time_s) })] : []));
  }));
}

function title(stop, times, missing) {
  if (!now.connected && now.stopPressed) return WORDS.stopNotSent;
  if (stop && stop.confirmed && missing.length === 0) return WORDS.stopConfirmed(Object.keys(times).length, Math.max(...Object.values(times)));
  if (stop && stop.late) return WORDS.stopNotConfirmed(missing.map(([device, label]) => (label.startsWith("D") ? capital(device) : label)).join(", "));
  return WORDS.stopping;
}
