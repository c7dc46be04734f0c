// Region B: alarm line, list and sound, and the page's own alarms for a lost console.
import { ask, askSilently } from "./actions.js";
import { siteTime_s } from "./camera.js";
import { byId, make, remake, shape, write } from "./dom.js";
import { acts, controls, driven, known, now, playback, silent_s } from "./now.js";
import { AGAIN_S, burst, soundPossible } from "./sound.js";
import { WORDS } from "./words.js";

const QUIET_S = 60, ANNOUNCE_MS = 2000, STARTS_MS = 1000, LONG = 44;
const RANK = { high: 3, medium: 2, low: 1 };
const quietUntil_ms = new Map(), sounded = new Map();
let announced = "", announcedAt_ms = -Infinity;

export function startAlarms() {
  byId("acknowledge-button").addEventListener("click", acknowledge);
  byId("quiet-button").addEventListener("click", quiet);
}

// The page's own alarms: connection, token, data, a STOP that was not sent, and a reloaded page that may not sound yet.
function own() {
  const acted = driven(), late_s = silent_s();
  const urgent = acted || now.state?.alarms.some(alarm => alarm.active && alarm.priority === "high") ? "high" : "medium"; // no old alarm stands before it
  const alarms = [], raise = (id, priority, text) => alarms.push({ id, priority, text, active: true });
  if (now.stopPressed && !now.connected) raise("stop-not-sent", "high", WORDS.stopNotSent);
  if (now.refused) raise("refused", "medium", WORDS.refused);
  else if (late_s > 0 && !now.connected) raise("no-connection", urgent, WORDS.noConnection);
  else if (late_s > 0) raise("no-data", urgent, WORDS.noData(late_s));
  else if (!acted && now.state?.session.why) raise("paused", "low", WORDS.pausedBy(now.state.session.why));
  if (acts() && now.state.session.sound === "heard" && !soundPossible() && performance.now() - now.loaded_ms > STARTS_MS) raise("silent", "low", WORDS.noSoundYet);
  return alarms;
}

const listed = () => [...own(), ...(now.state?.alarms ?? [])];

// The cause of a latched alarm is gone, and a person has yet to acknowledge it.
const latched = alarm => Boolean(alarm.waits);

// Alarms that are active or wait to be acknowledged: active ones first, then the most urgent.
export function standing() {
  const of = alarm => RANK[alarm.priority] + (alarm.active ? 4 : 0) + (alarm.id.startsWith("stop") ? 8 : 0);
  return listed()
    .filter(alarm => alarm.active || latched(alarm))
    .sort((a, b) => of(b) - of(a));
}

export function showAlarms() {
  const all = standing(), top = all[0] ?? null, more = all.length - 1;
  const section = byId("alarm");
  section.dataset.priority = top ? top.priority : "none";
  section.classList.toggle("past", Boolean(top && !top.active));
  byId("alarm-shape").setAttribute("href", `#shape-${top ? top.priority : "low"}`);
  const text = top ? top.text : WORDS.noAlarms;
  write(byId("alarm-text"), text);
  byId("alarm-text").classList.toggle("long", text.length > LONG);
  write(byId("alarm-age"), ageOf(top));
  write(byId("alarm-button"), more > 0 ? WORDS.more(more) : WORDS.alarmList);
  byId("acknowledge-button").hidden = !acknowledgeable();
  announce(top);
  showQuiet(all);
  if (!byId("sheet-alarms").hidden) showList();
}

// The time since the alarm began, while it is known; one whose text counts the silence itself has none.
function ageOf(alarm) {
  return alarm?.id !== "feed" && alarm?.age_s >= 0 && silent_s() === 0 ? WORDS.alarmAge(alarm.active, alarm.age_s) : "";
}

const acknowledgeable = () => controls() && known() && now.state.alarms.some(latched);

// Ends the past alarms that a person must know of; a fault of the site is cleared by the main button.
export function acknowledge() {
  if (acknowledgeable()) ask("acknowledge");
}

function quietable(alarm) {
  return alarm.active && alarm.silenceable !== false && !alarm.id.startsWith("stop");
}

// A hidden page draws no picture: the last one's time would pause the sound until the page is shown again.
function quietLeft_s(alarm) {
  const there_s = now.picture ? (alarm.quiet_until_s ?? 0) - siteTime_s() : 0;
  return Math.max(0, there_s, ((quietUntil_ms.get(alarm.id) ?? 0) - performance.now()) / 1000);
}

export function quiet() {
  const until_ms = performance.now() + QUIET_S * 1000;
  for (const alarm of standing().filter(quietable)) {
    quietUntil_ms.set(alarm.id, until_ms);
    if (controls() && now.connected && "since_s" in alarm) askSilently("quiet", { alarm: alarm.id, seconds: QUIET_S });
  }
  showAlarms();
}

function showQuiet(all) {
  const heard = all.filter(alarm => quietable(alarm) && alarm.priority !== "low");
  const button = byId("quiet-button");
  button.hidden = heard.length === 0 || playback();
  const left_s = Math.max(0, ...heard.map(quietLeft_s));
  write(button, left_s > 0 ? WORDS.quietFor(Math.ceil(left_s)) : WORDS.quiet);
}

// Sounds the most urgent alarm that is not quieted; a new or rising one at once.
export function soundAlarms(at_ms = performance.now()) {
  if (playback()) return;
  const all = standing().filter(alarm => alarm.active);
  for (const id of sounded.keys()) if (!all.some(alarm => alarm.id === id)) { sounded.delete(id); quietUntil_ms.delete(id); }
  for (const alarm of all) if (RANK[alarm.priority] > RANK[sounded.get(alarm.id)?.priority ?? "high"]) quietUntil_ms.delete(alarm.id);
  const loud = all.filter(alarm => quietLeft_s(alarm) === 0).sort((a, b) => RANK[b.priority] - RANK[a.priority]);
  const top = loud[0];
  if (!top) return;
  const before = sounded.get(top.id);
  const again = !before || before.priority !== top.priority || at_ms - before.at_ms >= AGAIN_S[top.priority] * 1000;
  if (again && burst(top.priority)) sounded.set(top.id, { priority: top.priority, at_ms });
}

// At most one announcement in 2 s, and never a number that only counts.
function announce(top) {
  const text = top ? top.text : "", steady = text.replace(/\d/g, "");
  if (steady === announced || performance.now() - announcedAt_ms < ANNOUNCE_MS) return;
  announced = steady;
  announcedAt_ms = performance.now();
  write(byId("urgent"), top && top.priority === "high" ? text : "");
  write(byId("polite"), top && top.priority !== "high" ? text : "");
}

export function showList() {
  const all = listed().sort((a, b) => (b.since_s ?? Infinity) - (a.since_s ?? Infinity));
  remake(byId("alarm-list"), all.map(alarm => ({ ...alarm, age_s: null })), () => (all.length ? all.map(item) : [make("li", { text: WORDS.noAlarms })]));
}

function item(alarm) {
  const facts = [];
  if (alarm.since) facts.push(alarm.since);
  else if (alarm.since_s !== undefined) facts.push(WORDS.since(alarm.since_s));
  if (typeof alarm.ended_s === "number") facts.push(WORDS.lasted(alarm.ended_s - alarm.since_s));
  if (alarm.cleared_by) facts.push(WORDS.clearedBy(alarm.cleared_by));
  else facts.push(alarm.active ? WORDS.present : latched(alarm) ? WORDS.waits : WORDS.past);
  return make("li", { "data-priority": alarm.priority, class: alarm.active ? null : "past" }, shape(alarm.priority),
    make("span", { text: alarm.what ?? alarm.text }), make("span", { class: "small", text: facts.join(" · ") }));
}
