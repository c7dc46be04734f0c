// The patient's stop button and pain slider. The page answers each question of the process at once, and only while it is
// seen: a page that is hidden or hangs is silent, and silence stops the fingers.

const LOST_MS = 300;
const SILENT_MS = 3000;
const LOOK_MS = 100;
const AGAIN_MS = 500;
const LONGEST_WAIT_MS = 30000;
const REFUSALS = { 4401: "refused", 4408: "full" };
const STOPPED_MS = 10000;
const CLICK_MS = 500;

const state = document.getElementById("state");
const stop = document.getElementById("stop");
const pain = document.getElementById("pain");
const slider = document.getElementById("slider");
const value = document.getElementById("value");

const WORDS = {
  lost: "Not connected. The examination cannot continue.",
  refused: "This page may not be used here. Ask for its address again.",
  full: "Too many tablets are open. Close one.",
  waiting: "Connected to this tablet only. The examination has not begun.",
  other: "Another tablet is in use. STOP works here too.",
  stopped: "Stopped. Say when it may continue.",
  ready: "Ready. You can stop at any time.",
};

let socket = null;
let asked = null;
let heardMs = -Infinity;
let openedMs = -Infinity;
let stoppedMs = -Infinity;
let refusal = null;
let waitMs = AGAIN_MS;
let placed = false;
const holds = new Set();

function connect() {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  const opened = new WebSocket(`${scheme}://${location.host}/patient`);
  socket = opened;
  openedMs = performance.now();
  opened.addEventListener("message", ({ data }) => {
    if (opened !== socket) return;
    asked = JSON.parse(data);
    heardMs = performance.now();
    refusal = null;
    waitMs = AGAIN_MS;
    if (asked.stopped) stoppedMs = heardMs;
    place();
    if (document.visibilityState === "visible") answer();
    show();
  });
  opened.addEventListener("close", ({ code }) => {
    if (opened !== socket) return;
    refusal = REFUSALS[code] ?? null;
    setTimeout(connect, waitMs);
    waitMs = refusal === null ? AGAIN_MS : Math.min(2 * waitMs, LONGEST_WAIT_MS);
  });
}

// A connection whose network has gone stays open in the browser for minutes: another one takes its place.
function renew() {
  if (socket.readyState > WebSocket.OPEN || performance.now() - Math.max(heardMs, openedMs) <= SILENT_MS) return;
  socket.close();
  connect();
}

// A page that was loaded again has the slider where the patient has set it, and so has a page that is not in use.
function place() {
  if (asked.pain !== null && !(placed && asked.in_use)) slider.value = asked.pain;
  placed = true;
}

function answer() {
  if (asked === null || socket.readyState !== WebSocket.OPEN) return;
  socket.send(JSON.stringify({ at_s: asked.at_s, pressed: holds.size > 0, pain: Number(slider.value) }));
}

function hold(what, pressed) {
  if (pressed) holds.add(what);
  else holds.delete(what);
  answer();
  show();
}

function show() {
  const lost = performance.now() - heardMs > LOST_MS;
  let word = "ready";
  if (refusal !== null) word = refusal;
  else if (lost) word = "lost";
  else if (holds.size > 0 || performance.now() - stoppedMs < STOPPED_MS) word = "stopped";
  else if (!asked.in_use) word = "other";
  else if (!asked.site) word = "waiting";
  if (state.textContent !== WORDS[word]) state.textContent = WORDS[word];
  state.classList.toggle("lost", lost || refusal !== null);
  stop.classList.toggle("pressed", holds.size > 0 || Boolean(asked?.stopped));
  pain.hidden = asked === null || asked.pain === null;
  value.textContent = slider.value;
}

stop.addEventListener("pointerdown", (event) => {
  hold(`pointer ${event.pointerId}`, true);
  stop.setPointerCapture(event.pointerId);
});
for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
  stop.addEventListener(end, (event) => hold(`pointer ${event.pointerId}`, false));
}
// Assistive software sends a click alone.
stop.addEventListener("click", (event) => {
  if (event.detail !== 0) return;
  hold("click", true);
  setTimeout(() => hold("click", false), CLICK_MS);
});
stop.addEventListener("contextmenu", (event) => event.preventDefault());
document.addEventListener("keydown", (event) => {
  if (["Escape", " ", "Enter"].includes(event.key)) {
    event.preventDefault();
    hold(`key ${event.code}`, true);
  }
});
document.addEventListener("keyup", (event) => hold(`key ${event.code}`, false));
window.addEventListener("blur", () => {
  holds.clear();
  show();
});
slider.addEventListener("input", () => {
  answer();
  show();
});

async function stayAwake() {
  try {
    await navigator.wakeLock?.request("screen");
  } catch {
    // The tablet's own setting then decides when its screen goes dark.
  }
}

document.addEventListener("visibilitychange", () => {
  if (document.visibilityState === "visible") stayAwake();
});
setInterval(show, LOOK_MS);
setInterval(renew, LOOK_MS);
stayAwake();
connect();
