// Derives the state that may be shown from live data only.
export const SILENT_S = 0.5, STATE_SILENT_S = 1.0; // a picture is due 30 times a second, a state 4 times

export const ACTING = ["engaging", "engaged"];
export const OF_LINK = ["disconnected", "connected", "engaged", "fault"];
const LINK_OF = { disconnected: 0, lost: 0, silent: 0, connected: 1, engaging: 1, paused: 1, engaged: 2, fault: 3, stopped: 3 };

// Returns the time without a picture or a state, s; 0 while both come in time. A null age is ignored.
export function silence(picture_s, state_s) {
  const late_s = (age_s, limit_s) => (age_s === null || (age_s >= 0 && age_s <= limit_s) ? 0 : Math.max(age_s, limit_s) || Infinity);
  return Math.max(late_s(picture_s, SILENT_S), late_s(state_s, STATE_SILENT_S));
}

// state: the console's state, or null; drawn: the link's state of a newer picture, or null.
export function shownWord({ state, drawn, silent_s, stopping }) {
  if (silent_s > 0 || state === "silent" || state === null) return "unknown";
  if (stopping) return "stopping";
  if (drawn !== null && drawn !== LINK_OF[state]) return OF_LINK[drawn];
  return state;
}
