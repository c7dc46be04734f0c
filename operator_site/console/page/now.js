// What the page knows at this moment: the newest state and picture, when they came, and what follows from both.
import { FINGER_COUNT } from "./picture.js";

export const NOT_LIVE_S = 1.0, HELD_S = 1.0;
export const OF_LINK = ["disconnected", "connected", "engaged", "fault"];
const LINK_OF = { disconnected: 0, connected: 1, engaging: 1, engaged: 2, paused: 1, fault: 3, stopped: 3 };

export const now = {
  state: null, stateAt_ms: -Infinity, picture: null, pictureAt_ms: -Infinity, loaded_ms: performance.now(),
  connected: false, refused: false, stopPressed: false, chosen: null, active: 1,
};

export function playback() {
  return Boolean(now.state?.session.playback);
}

export function acts() {
  return now.state?.you.role === "act" && !playback();
}

// Seconds since the last picture was drawn. A hidden page draws none and is not late; a recording may stand still.
export function unseen_s(at_ms = performance.now()) {
  if (document.hidden || (playback() && now.connected)) return 0;
  return (at_ms - Math.max(now.pictureAt_ms, now.loaded_ms)) / 1000;
}

export function live() {
  return now.connected && now.picture !== null && now.state !== null && unseen_s() < NOT_LIVE_S;
}

// The last state that was told, however old: what STOP's keys go by when nothing is heard any more.
export function lastTold() {
  return now.state ? now.state.session.state : "disconnected";
}

// Either source arms STOP's keys: a picture tells of engaging up to 0.1 s before the state.
export function underWay() {
  const engaged = now.picture !== null && now.picture.state === LINK_OF.engaged;
  return acts() && (engaged || ["engaging", "engaged", "paused"].includes(lastTold()));
}

export function shownState() {
  if (!now.connected || !now.state || (!live() && now.picture !== null)) return "unknown";
  if (playback()) return "playback";
  const told = now.state.session.state, stop = now.state.stop;
  if (now.stopPressed || (stop && !stop.confirmed)) return "stopping";
  if (now.picture && now.pictureAt_ms > now.stateAt_ms && now.picture.state !== LINK_OF[told]) {
    if (told !== "engaging" || now.picture.state === LINK_OF.fault) return OF_LINK[now.picture.state];
  }
  return told;
}

// The active finger: the chosen one, else the one that touched last, held at least a second.
const touchedAt_s = new Array(FINGER_COUNT).fill(-Infinity);
const touching = new Array(FINGER_COUNT).fill(false);
let changedAt_s = -Infinity;

export function followContact(picture) {
  for (let finger = 0; finger < FINGER_COUNT; finger += 1) {
    const contact = picture.contact(finger);
    if (contact && !touching[finger]) touchedAt_s[finger] = picture.time_s;
    if (!contact) touchedAt_s[finger] = -Infinity;
    touching[finger] = contact;
  }
  if (now.chosen !== null) { now.active = now.chosen; return; }
  if (picture.time_s - changedAt_s < HELD_S && picture.time_s >= changedAt_s) return;
  let newest = now.active;
  for (let finger = 0; finger < FINGER_COUNT; finger += 1) if (touchedAt_s[finger] > touchedAt_s[newest]) newest = finger;
  if (newest !== now.active) { now.active = newest; changedAt_s = picture.time_s; }
}
