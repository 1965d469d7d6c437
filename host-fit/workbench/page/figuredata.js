// @ts-check
// Range of a panel, and its description in a sentence.

import { isNumber, number } from "./format.js";

/** @typedef {import("./types.js").Panel} Panel */
/** @typedef {import("./types.js").Shape} Shape */
/** @typedef {number | null} Num */
/** @typedef {{low: number, high: number}} Extent */

/**
 * Every (x, y) that a shape reaches; a level has no x.
 * @param {Shape} shape
 * @returns {[Num, Num][]}
 */
export function corners(shape) {
  if ("Line" in shape) return shape.Line;
  if ("Points" in shape) return shape.Points;
  if ("Stems" in shape) return shape.Stems.flatMap(([x, y]) => /** @type {[Num, Num][]} */ ([[x, y], [x, 0]]));
  if ("Band" in shape) return shape.Band.flatMap(([x, low, high]) => /** @type {[Num, Num][]} */ ([[x, low], [x, high]]));
  if ("Bars" in shape) return shape.Bars.flatMap(([x, y, low, high]) => /** @type {[Num, Num][]} */ ([[x, y], [x, low], [x, high]]));
  if ("Level" in shape) return [[null, shape.Level]];
  const cells = "Cells" in shape ? shape.Cells : shape.Frames;
  return cells.flatMap(([left, right, low, high]) => /** @type {[Num, Num][]} */ ([[left, low], [right, high]]));
}

/**
 * The range of an axis: that of what is drawn, with a little room.
 * @param {Panel} panel
 * @param {"x" | "y"} which
 * @returns {Extent | null} none: nothing is drawn
 */
export function extent(panel, which) {
  const isLog = panel[which].scale === "Log";
  let low = Infinity;
  let high = -Infinity;
  for (const { shape } of panel.series) {
    for (const corner of corners(shape)) {
      const value = corner[which === "x" ? 0 : 1];
      if (!isNumber(value) || (isLog && value <= 0)) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  if (low > high) return null;
  const room = which === "x" ? 0.01 : 0.06;
  if (isLog) {
    const factor = high > low ? (high / low) ** room : 2;
    return { low: low / factor, high: high * factor };
  }
  if (panel[which].names.length > 0) return { low: low - 0.15, high: high + 0.15 };
  const margin = (high - low) * room || Math.abs(high) || 1;
  return { low: low - margin, high: high + margin };
}

/** The quantity of an axis label, and its unit if there is one. @param {string} label */
function quantityOf(label) {
  return label.replace(/\s*\([^()]*\)(?=[^()]*$)/, "");
}

/** Description of a panel for screen readers. @param {Panel} panel */
export function describe(panel) {
  /** @type {Map<string, [Num, Num][]>} */
  const named = new Map();
  for (const { label, shape } of panel.series) {
    if (label) named.set(label, [...(named.get(label) ?? []), ...corners(shape)]);
  }
  const parts = [...named].map(([label, points]) => {
    const values = points.map((point) => point[1]).filter(isNumber);
    if (values.length === 0) return `${label}: none`;
    const low = values.reduce((a, b) => Math.min(a, b));
    const high = values.reduce((a, b) => Math.max(a, b));
    return low === high ? `${label} at ${number(low)}` : `${label} from ${number(low)} to ${number(high)}`;
  });
  const against = panel.x.names.length > 0 ? `for ${panel.x.names.join(", ")}` : panel.x.label ? `against ${panel.x.label}` : "";
  return `${panel.title ? `${panel.title}. ` : ""}${quantityOf(panel.y.label)} ${against}: ${parts.join("; ")}.`;
}
