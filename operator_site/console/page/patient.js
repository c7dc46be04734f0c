// The patient's pain, its age, the force limit that follows the patient's threshold, and the most tender place in words; a movement of the patient.
import { byId, write } from "./dom.js";
import { known, now } from "./now.js";
import { WORDS } from "./words.js";

export function showPatient() {
  const patient = now.state?.patient, line = byId("patient");
  const moved = now.state?.map?.moved;
  line.hidden = !patient && !moved;
  if (line.hidden) return;
  const pain = known() ? patient?.pain : null;
  write(line, [patient && (known() ? WORDS.pain(pain, patient.age_s) : WORDS.painNotLive), patient?.limit, patient?.ends, patient?.tender?.text, moved].filter(Boolean).join("\n"));
  line.dataset.painful = String(pain > 0);
}
