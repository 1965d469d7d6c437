// @ts-check
// The value nearest to the pointer on a figure.

import uPlot from "./vendor/uplot.esm.js";
import { isNumber, number } from "./format.js";
import { corners } from "./figuredata.js";

/** @typedef {import("./types.js").Panel} Panel */
/** @typedef {import("./types.js").Series} Series */

/** Largest distance between the pointer and a value that is shown, pixels. */
const REACH = 40;

/** @param {uPlot} u @param {Panel} panel @param {(series: Series) => boolean} isShown @param {number} left @param {number} top pixels into the plot */
export function readingAt(u, panel, isShown, left, top) {
  let nearest = REACH;
  let text = "";
  for (const series of panel.series) {
    if (!isShown(series) || "Level" in series.shape) continue;
    const isWide = "Cells" in series.shape || "Frames" in series.shape;
    for (const [x, y] of corners(series.shape)) {
      if (isWide || !isNumber(x) || !isNumber(y)) continue;
      const distance = Math.hypot(u.valToPos(x, "x") - left, u.valToPos(y, "y") - top);
      if (!(distance < nearest)) continue;
      nearest = distance;
      const place = panel.x.names[Math.round(x)] ?? number(x, 4);
      text = `${series.label ? `${series.label.replace(/^([NBK]) .*/, "$1")}: ` : ""}${number(y, 4)} at ${place}`;
    }
  }
  return text;
}
