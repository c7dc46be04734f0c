// Holds the newest state and picture with their times, and derives the shown state from both.
import { FINGER_COUNT } from "./picture.js";
import { ACTING, OF_LINK, shownWord, silence } from "./shown.js";

export const NOT_LIVE_S = 1.0, HELD_S = 1.0;

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

// Returns whether this page is in control: the console refuses others all but STOP.
export function controls() {
  return acts() && now.state.you.in_control;
}

// Returns the silence of the console, s; 0 without one. A hidden page draws nothing; a recording may pause.
export function silent_s(at_ms = performance.now()) {
  if (playback() && now.connected) return 0;
  const age_s = since_ms => (at_ms - Math.max(since_ms, now.loaded_ms)) / 1000;
  return silence(document.hidden ? null : age_s(now.pictureAt_ms), age_s(now.stateAt_ms));
}

// Returns whether numbers may be shown: a short gap hides none.
export function live() {
  return now.connected && now.picture !== null && now.state !== null && silent_s() < NOT_LIVE_S;
}

// Returns whether the state is known now. Nothing but STOP and Pause is offered without it.
export function known() {
  return live() && silent_s() === 0 && lastState() !== "silent";
}

// Returns the last known state at any age; the STOP keys depend on it.
export function lastState() {
  return now.state ? now.state.session.state : "disconnected";
}

// Returns whether outputs acted in the last known state, or may act unseen.
export function driven() {
  return [...ACTING, "lost", "silent"].includes(lastState());
}

// Either source arms the STOP keys, because a picture may be 0.1 s ahead of the state.
export function underWay() {
  const engaged = now.picture !== null && OF_LINK[now.picture.state] === "engaged";
  return acts() && (engaged || driven() || lastState() === "paused");
}

export function shownState() {
  if (!now.connected || !now.state) return "unknown";
  if (playback()) return "playback";
  const { session, stop } = now.state;
  const drawn = now.picture && now.picture.came_ms > now.stateAt_ms ? now.picture.state : null;
  return shownWord({ state: session.state, drawn, silent_s: silent_s(), stopping: now.stopPressed || Boolean(stop && !stop.confirmed) });
}

// The active finger: chosen, else the last that touched, held at least a second.
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
