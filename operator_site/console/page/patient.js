// The patient's pain, its age, the force limit that follows the patient's threshold, and the most tender place in words.
import { byId, write } from "./dom.js";
import { known, now } from "./now.js";
import { WORDS } from "./words.js";

export function showPatient() {
  const patient = now.state?.patient, line = byId("patient");
  line.hidden = !patient;
  if (!patient) return;
  const pain = known() ? patient.pain : null;
  write(line, [WORDS.pain(pain, patient.age_s), patient.limit, patient.ends, patient.tender?.text].filter(Boolean).join("\n"));
  line.dataset.painful = String(pain > 0);
}
