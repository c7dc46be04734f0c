// Key D shows drawing, chart and signals over the map, in a small window also two rows of the table.
// A window that scrolls shows all of them already.
import { byId } from "./dom.js";

const FOLDED = window.matchMedia("(min-width: 64em) and (min-height: 48em), (min-width: 50em) and (min-height: 70em)");
let shown = false;

export function startDetails(redraw) {
  FOLDED.addEventListener("change", () => { shown = false; place(); redraw(); });
  return () => { shown = FOLDED.matches && !shown; place(); redraw(); };
}

function place() {
  byId("details").hidden = !shown;
  if (shown) {
    byId("details-hand").prepend(byId("drawing-place"));
    byId("details-chart").append(byId("chart"));
    byId("details-signals").append(byId("signals"));
  } else {
    byId("finger-table").before(byId("drawing-place"));
    byId("properties").before(byId("chart"));
    byId("identification").after(byId("signals"));
  }
}
