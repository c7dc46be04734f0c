// The session sheet: study number, place on the body, check list, sound, end, report.
import { ask } from "./actions.js";
import { byId, make, once, remake, write } from "./dom.js";
import { bodyText, openBody } from "./body.js";
import { acts, controls, known, live, now, playback } from "./now.js";
import { close, open } from "./sheets.js";
import { burst, soundPossible, wakeSound } from "./sound.js";
import { capital, SIDES, WORDS } from "./words.js";

const CONFIRM_MS = 5000;
let body = null, ending = null, offered = false, played = false, hadSession = false;

export function startSession() {
  for (const id of ["begin-top", "begin-right"]) byId(id).append(...SIDES.map(side => make("option", { value: side, text: side || "–" })));
  const beginOnce = once(begin);
  byId("begin-form").addEventListener("submit", event => { event.preventDefault(); beginOnce(); });
  byId("sound-play").addEventListener("click", () => { wakeSound(); played = true; setTimeout(() => { burst("medium"); showSound(); }, 100); });
  byId("sound-heard").addEventListener("click", () => ask("sound", { answer: "heard" }));
  byId("sound-refused").addEventListener("click", () => ask("sound", { answer: "refused" }));
  byId("take-button").addEventListener("click", () => ask("take_control"));
  byId("end-button").addEventListener("click", event => { if (event.detail < 2) end(); }); // a double click is one press
  byId("begin-body").addEventListener("click", () => openBody(body, showBody));
  showBody(null);
}

function showBody(place) {
  body = place;
  write(byId("begin-body"), place ? capital(bodyText(place)) : WORDS.chooseBody);
}

async function begin() {
  const { session } = now.state;
  const answer = await ask("begin", { pseudonym: byId("begin-pseudonym").value.trim(), sides: { top: byId("begin-top").value, right: byId("begin-right").value }, body, consent: byId("begin-consent").checked });
  write(byId("begin-said"), answer.ok ? "" : answer.text);
  if (!answer.ok) { byId(session.consented.length && !byId("begin-consent").checked ? "begin-consent" : "begin-pseudonym").focus(); return; }
  byId("begin-form").reset();
  showBody(null);
  close("sheet-session");
  byId("act-button").focus();
}

async function end() {
  if (!ending) {
    ending = setTimeout(() => { ending = null; showSession(); }, CONFIRM_MS);
    showSession();
    return;
  }
  clearTimeout(ending);
  ending = null;
  const answer = await ask("end");
  write(byId("session-said"), answer.ok ? "" : answer.text);
  open("sheet-session");
}

export function showSession() {
  if (!now.state) return;
  const { session, you } = now.state, findings = now.state.findings.filter(found => !found.withdrawn), inSession = Boolean(session.pseudonym);
  // Offers once to begin a session while none is open.
  if (!offered && controls() && !inSession && live() && ["connected", "disconnected"].includes(session.state)) { offered = true; open("sheet-session"); }
  if (hadSession && !inSession && session.saved) open("sheet-session");
  hadSession = inSession;
  const sheet = byId("sheet-session");
  sheet.classList.toggle("start", controls() && !inSession && !["engaged", "engaging"].includes(session.state));
  byId("session-begin").hidden = inSession || !controls();
  byId("begin-consent-field").hidden = !session.consented.length;
  write(byId("begin-consent-text"), WORDS.consents(session.consented));
  byId("session-running").hidden = controls() && !inSession && !session.saved;
  byId("session-sound").hidden = !controls() || session.state === "engaged";
  byId("take-button").hidden = !acts() || you.in_control || session.state === "engaged";
  const ended = document.activeElement === byId("end-button") && !inSession; // its button goes away with the focus
  byId("end-button").hidden = !controls() || !inSession;
  write(byId("end-button"), ending ? WORDS.confirmEnd(session.pseudonym, findings.length) : WORDS.end);
  const control = you.in_control ? "" : ` ${WORDS.controlElsewhere(you.control)}`;
  const summary = session.saved ? session.saved.text : inSession ? WORDS.sessionOpen(session.pseudonym, session.body) : playback() ? session.title ?? "" : WORDS.noSession;
  write(byId("session-summary"), `${summary}${control}`);
  const report = session.saved ? session.saved.report : null, link = byId("report-link");
  link.hidden = !(typeof report === "string" && report.startsWith("/report/"));
  if (!link.hidden && link.getAttribute("href") !== report) link.setAttribute("href", report);
  for (const button of byId("sheet-session").querySelectorAll("button:not(.close)")) button.disabled = !known();
  if (ended) byId("begin-pseudonym").focus();
  showSound();
  showChecks();
}

function showSound() {
  if (!now.state) return;
  const answered = now.state.session.sound;
  byId("sound-heard").hidden = !played;
  const text = answered === "heard" ? WORDS.soundHeard : answered === "refused" ? WORDS.soundRefused : played ? WORDS.soundAsk : WORDS.soundNeeded;
  write(byId("sound-said"), played && !soundPossible() ? WORDS.soundBlocked : text);
}

function showChecks() {
  const all = [...now.state.devices, ...now.state.checks];
  const lines = known() ? all : all.map(({ name }) => ({ name, ready: false, text: WORDS.notLive, help: "", unknown: true }));
  const tick = text => make("span", { "aria-hidden": "true", text });
  remake(byId("ready"), lines, () => lines.filter(line => line.ready).map(line => make("li", {}, tick("✓"), ` ${capital(line.name)} `, make("span", { class: "detail", text: line.text || WORDS.ready }))));
  remake(byId("checks"), lines, () => lines.filter(line => !line.ready).map(line => make("li", {}, tick(line.unknown ? "?" : "✗"), make("span", { text: capital(line.name) }),
    make("span", { class: "missing", text: line.text }), ...(line.help ? [make("code", { text: line.help })] : []))));
}
