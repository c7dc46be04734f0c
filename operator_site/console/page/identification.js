// Region E: the material at the active finger, its probability and age.
import { byId, make, remake, write } from "./dom.js";
import { age_s, GONE_S, STALE_S } from "./fingers.js";
import { roughness, unitOf } from "./map_units.js";
import { live, now } from "./now.js";
import { FINGER_NAMES, withSd, WORDS } from "./words.js";

const LONG = 13;

export function showIdentification() {
  const finger = now.state ? now.state.fingers[now.active] : null;
  const name = FINGER_NAMES[now.active] + (now.chosen === null ? ` (${WORDS.auto})` : "");
  const age = age_s(now.active), known = finger !== null && live() && age <= GONE_S, stale = known && age > STALE_S;
  const old_s = known ? finger.held_s : null;
  write(byId("identification-title"), stale ? WORDS.oldFinger(name, age) : old_s ? WORDS.held(name, old_s) : WORDS.active(name, known ? finger.contact_s : null));
  const [head, rest] = !known ? ["--", ""] : finger.decision === "IDENTIFIED" ? [finger.line, ""] : [finger.decision, finger.line];
  const more = rest || !known || !finger.limits.length ? rest : WORDS.limits(finger.limits);
  write(byId("decision"), head);
  byId("decision").className = [finger?.decision === "DECIDING" ? "tentative" : "", head.length > LONG ? "long" : ""].join(" ");
  byId("identification").classList.toggle("stale", stale);
  write(byId("decision-more"), more);
  const warmth = known ? `${withSd(finger.object_c, finger.object_c_sd)} °C${finger.object_c_uncertain ? WORDS.uncertain : ""}` : "-- °C";
  write(byId("object"), `${WORDS.object} ${warmth}`);
  write(byId("against"), known ? WORDS.against(finger.against) : "");
  write(byId("chart-meaning"), now.state?.meaning ?? WORDS.notCalibrated);
  showProperties(known ? finger : null);
}

function showProperties(finger) {
  const [value, sd, unit] = finger?.roughness_v ? roughness(finger.roughness_v, finger.roughness_sd_v) : [null, null, unitOf("roughness")];
  const rows = [
    [WORDS.stiffness, finger && finger.stiffness_known ? withSd(finger.stiffness_n_m, finger.stiffness_sd_n_m, 0) : "--", "N/m"],
    [WORDS.roughness, withSd(value, sd), unit],
    [WORDS.groove, finger ? withSd(finger.groove_mm, finger.groove_sd_mm, 2) : "--", "mm"],
  ];
  remake(byId("properties"), rows, () => rows.flatMap(([name, shown, in_unit]) => [make("dt", { text: name }), make("dd", { text: `${shown} ${in_unit}` })]));
}
