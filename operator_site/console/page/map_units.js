// Units of the map: what a value is shown as, and things that people know beside it.
import { now } from "./now.js";
import { ANCHORS, WORDS } from "./words.js";

const SCALE_V = [0.002, 0.2];

// Ends of the console's scale are the levels 0 and 10.
const levels = () => now.state?.map?.legend?.roughness ?? SCALE_V;
const scaled = () => now.state?.map?.roughness_um ?? null;

// Converts a roughness in V to um, or to a level of 0 to 10 where the sensor was not calibrated for um.
export function roughness(value_v) {
  const scale = scaled();
  if (scale) return Math.exp(scale.ln_um + scale.exponent * Math.log(value_v));
  const [low, high] = levels();
  return 10 * Math.log(value_v / low) / Math.log(high / low);
}

export function roughnessSd(value_v, sd_v) {
  if (typeof value_v !== "number" || typeof sd_v !== "number") return null;
  const scale = scaled(), relative = sd_v / value_v, [low, high] = levels();
  return scale ? roughness(value_v) * Math.hypot(scale.exponent * relative, scale.ln_sd) : 10 * relative / Math.log(high / low);
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
