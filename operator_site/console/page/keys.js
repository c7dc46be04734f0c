// Keys. The STOP keys come first at any focus; key repeat is ignored.
import { calm, hold, pause, release } from "./actions.js";
import { acknowledge, quiet } from "./alarms.js";
import { closeBody } from "./body.js";
import { nextSize } from "./camera.js";
import { holdClutch, releaseClutch } from "./clutch.js";
import { byId, make, remember, remembered, typing, write } from "./dom.js";
import { fitMap, nextComparison, show, showBoth, showSure, widen, zoomBy } from "./map.js";
import { begin, marked, markingKey } from "./marking.js";
import { openNote } from "./notes.js";
import { playback, underWay } from "./now.js";
import { playbackKey } from "./playback.js";
import { closeAll, toggle } from "./sheets.js";
import { press } from "./stop.js";
import { otherTheme } from "./theme.js";
import { holdTalk, releaseTalk, toggleTalk } from "./voice.js";
import { KEYS, WORDS } from "./words.js";

// A pedal sends a key that writes nothing, so that it works in a text field, too.
const PEDAL = "F9";
let plain = true;

export function startKeys({ choose, details, listed }) {
  useLetters(remembered("letters") !== "alt");
  byId("key-list").append(...KEYS.flatMap(([keys, does]) => [make("dt", {}, make("kbd", { text: keys })), make("dd", { text: does })]));
  byId("letters-button").addEventListener("click", () => {
    useLetters(!plain);
    remember("letters", plain ? "plain" : "alt");
  });
  byId("theme-button").addEventListener("click", otherTheme);
  const letters = {
    e: () => hold("engage"), c: () => hold("clear_fault"), p: pause, f: begin, n: () => openNote(), u: showSure, v: showBoth, b: nextComparison, x: fitMap, q: quiet, k: acknowledge, l: otherTheme, d: details, g: holdClutch, w: nextSize, h: holdTalk, o: toggleTalk,
    t: () => show("temperature"), r: () => show("roughness"), s: () => show("stiffness"), m: () => show("material"), a: () => toggle("sheet-alarms", listed),
  };
  const signs = { "?": () => toggle("sheet-help"), "+": () => zoomBy(1.5), "=": () => zoomBy(1.5), "-": () => zoomBy(1 / 1.5), ",": () => widen(-1), ".": () => widen(1) };
  window.addEventListener("keydown", event => {
    if (stops(event)) { swallow(event); if (!event.repeat) press(); return; }
    if (event.key === PEDAL) { event.preventDefault(); if (!event.repeat) holdClutch(); return; }
    if (event.repeat && event.key === "Enter" && !document.activeElement?.matches("textarea")) { event.preventDefault(); return; } // it presses a button once
    if (event.key.length === 1 && !/[ec]/i.test(event.key) && document.activeElement !== byId("act-button")) calm(); // words that are typed without a text field
    if (event.ctrlKey || event.metaKey || typing()) return;
    if (playback() && !menu() && playbackKey(event)) return;
    if (document.activeElement !== byId("map-surface") || marked()) if (markingKey(event)) return;
    if (event.repeat || menu()) return;
    if (event.altKey === plain) return;
    if (/^[0-5]$/.test(event.key) && !marked()) choose(event.key === "0" ? null : Number(event.key) - 1);
    else if (Object.hasOwn(signs, event.key)) signs[event.key]();
    else if (Object.hasOwn(letters, event.key.toLowerCase())) letters[event.key.toLowerCase()]();
    else if (event.key === "Escape") closeBody() || closeAll();
    else return;
    event.preventDefault();
  }, { capture: true });
  window.addEventListener("keyup", event => {
    if (stops(event)) { swallow(event); return; }
    if (event.key === PEDAL || event.key.toLowerCase() === "g") releaseClutch();
    if (event.key.toLowerCase() === "h") releaseTalk();
    if (["e", "c"].includes(event.key.toLowerCase())) release();
  }, { capture: true });
  window.addEventListener("blur", () => release(false));
}

// The keys beside the words of buttons show whether they need Alt.
function useLetters(alone) {
  plain = alone;
  document.body.dataset.letters = plain ? "plain" : "alt";
  write(byId("letters-button"), WORDS.letters(plain));
}

// An open list uses letters itself.
function menu() {
  return document.activeElement?.matches("select");
}

function stops(event) {
  return underWay() && (event.key === "Escape" || (event.key === " " && !typing()));
}

function swallow(event) {
  event.preventDefault();
  event.stopImmediatePropagation();
}
