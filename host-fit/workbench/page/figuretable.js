// @ts-check
// The numbers of a panel as a table, for screen readers and for copying.

import { el } from "./dom.js";
import { number } from "./format.js";

/** @typedef {import("./types.js").Panel} Panel */
/** @typedef {import("./types.js").Shape} Shape */
/** @typedef {number | null} Num */

/** Rows of one series that are listed; evenly chosen from more. */
const ROWS = 24;

/** @param {Panel} panel @param {string} title */
export function panelTable(panel, title) {
  const details = el("details", { class: "as-table" }, el("summary", {}, "Data as table", el("span", { class: "unseen" }, `: ${panel.title || title}`)));
  // created when opened, because most never are
  details.addEventListener("toggle", () => {
    if (details.open && details.childElementCount === 1) details.append(table(panel));
  });
  return details;
}

/** @param {Panel} panel */
function table(panel) {
  const x = panel.x.label || "Step";
  const y = panel.y.label;
  let left = 0;
  const rows = panel.series.flatMap(({ label, shape }) => {
    const all = cells(shape);
    const chosen = all.length <= ROWS ? all : Array.from({ length: ROWS }, (_, n) => all[Math.round((n * (all.length - 1)) / (ROWS - 1))] ?? []);
    left += all.length - chosen.length;
    return chosen.map((row) => el("tr", {}, el("th", { scope: "row" }, label), row.map((value, at) => el("td", {}, text(value, at, panel)))));
  });
  const head = el("tr", {}, ["Series", x, y, "low", "high"].map((name) => el("th", { scope: "col" }, name)));
  const note = left > 0 ? el("p", { class: "note" }, `Every series is cut to ${ROWS} evenly chosen rows; ${left} are not listed.`) : null;
  return el("div", { class: "scrolls", tabindex: 0, role: "region", "aria-label": "Data as table" }, note, el("table", {}, el("thead", {}, head), el("tbody", {}, rows)));
}

/** @param {Num | string} value @param {number} at @param {Panel} panel */
function text(value, at, panel) {
  if (typeof value === "string") return value;
  const name = at === 0 && value !== null ? panel.x.names[Math.round(value)] : undefined;
  return name ?? number(value, 4);
}

/** x, y, low, high of every entry. @param {Shape} shape @returns {(Num | string)[][]} */
function cells(shape) {
  if ("Level" in shape) return [["everywhere", shape.Level, "", ""]];
  if ("Band" in shape) return shape.Band.map(([x, low, high]) => [x, "", low, high]);
  if ("Bars" in shape) return shape.Bars;
  if ("Cells" in shape || "Frames" in shape) {
    const all = "Cells" in shape ? shape.Cells : shape.Frames;
    return all.map(([left, right, low, high]) => [`${number(left)} … ${number(right)}`, "", low, high]);
  }
  const points = "Line" in shape ? shape.Line : "Points" in shape ? shape.Points : shape.Stems;
  return points.map(([x, y]) => [x, y, "", ""]);
}
