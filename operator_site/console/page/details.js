// Key D in a small window shows drawing, chart and two table rows over the map.
import { byId } from "./dom.js";

const SMALL = window.matchMedia("(min-width: 64em) and (min-height: 44em) and (not ((min-width: 90em) and (min-height: 52em)))");
let shown = false;

export function startDetails(redraw) {
  SMALL.addEventListener("change", () => { shown = false; place(); redraw(); });
  return () => { shown = SMALL.matches && !shown; place(); redraw(); };
}

function place() {
  byId("details").hidden = !shown;
  if (shown) {
    byId("details-hand").prepend(byId("drawing-place"));
    byId("details-chart").append(byId("chart"));
  } else {
    byId("finger-table").before(byId("drawing-place"));
    byId("properties").before(byId("chart"));
  }
}
