// Units of the map: what a value is shown as, and things that people know beside it.
import { now } from "./now.js";
import { ANCHORS, WORDS } from "./words.js";

const LEVEL_0_V = 0.002, LEVELS_LN = Math.log(100); // level 0 to 10 is 2 to 200 mV

const scaled = () => now.state?.map?.roughness_um ?? null;

// Converts a roughness in V to um, or to a level of 0 to 10 where the sensor was not calibrated for um.
export function roughness(value_v) {
  const scale = scaled();
  if (scale) return Math.exp(scale.ln_um + scale.exponent * Math.log(value_v));
  return 10 * Math.log(value_v / LEVEL_0_V) / LEVELS_LN;
}

export function roughnessSd(value_v, sd_v) {
  if (typeof value_v !== "number" || typeof sd_v !== "number") return null;
  const scale = scaled(), relative = sd_v / value_v;
  return scale ? roughness(value_v) * Math.hypot(scale.exponent * relative, scale.ln_sd) : 10 * relative / LEVELS_LN;
}

export function unitOf(quantity) {
  return quantity === "roughness" ? WORDS.roughnessUnit[scaled() ? "um" : "level"] : WORDS.legendUnit[quantity];
}

export function numberOf(quantity, value) {
  return quantity === "roughness" ? roughness(value) : value;
}

// Returns [value in the map's unit, name] of known things on a scale.
export function anchors(quantity) {
  if (quantity !== "roughness") return ANCHORS[quantity] ?? [];
  const scale = scaled();
  return scale ? ANCHORS.roughness_um.map(([um, name]) => [Math.exp((Math.log(um) - scale.ln_um) / scale.exponent), name]) : [];
}
