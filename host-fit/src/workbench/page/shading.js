// @ts-check
// Stretches that are set apart by their background: painted, named in the legend, told where somebody points at them.

import uPlot from "./vendor/uplot.esm.js";
import { el } from "./dom.js";
import { faint } from "./theme.js";

/** @typedef {import("./types.js").Shading} Shading */
/** @typedef {import("./types.js").ShadedRange} Range */

/** Colours by why a stretch is set apart: the custom property, and its opacity. */
const TONES = { Apart: { ink: "shade", opacity: 0.25 }, LeftOut: { ink: "left-out", opacity: 0.3 } };
/** Pixels beside a stretch that still point at it. */
const REACH = 4;

/** Where a stretch lies on the canvas; one too short to see is widened about its middle. @param {uPlot} u @param {{from: number, to: number}} range */
export function placeOf(u, range) {
  const [from, to] = [u.valToPos(range.from, "x", true), u.valToPos(range.to, "x", true)];
  const half = Math.max(0.5 * (to - from), 1.5 * uPlot.pxRatio);
  return { left: 0.5 * (from + to) - half, width: 2 * half, middle: 0.5 * (from + to) };
}

/** The stretches that reach between two values of x. @param {Shading} shading @param {number} low @param {number} high */
export const within = (shading, low, high) => shading.ranges.filter(({ from, to }) => to >= low && from <= high);

/** Paints the stretches that are in view. @param {uPlot} u @param {Shading} shading */
export function paint(u, shading) {
  const { ctx, bbox } = u;
  const { min, max } = u.scales.x ?? {};
  const { ink, opacity } = TONES[shading.tone];
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.fillStyle = faint(`--ink-${ink}`, opacity);
  for (const range of within(shading, min ?? -Infinity, max ?? Infinity)) {
    const { left, width } = placeOf(u, range);
    ctx.fillRect(left, bbox.top, width, bbox.height);
  }
  ctx.restore();
}

/** What is said of the stretch that is `left` pixels into the plot; nothing where there is none. @param {uPlot} u @param {Shading} shading @param {number} left */
export function saidAt(u, shading, left) {
  const [low, high] = [u.posToVal(left - REACH, "x"), u.posToVal(left + REACH, "x")];
  const at = 0.5 * (low + high);
  const distance = (/** @type {Range} */ { from, to }) => Math.max(from - at, at - to, 0);
  return within(shading, low, high).sort((a, b) => distance(a) - distance(b))[0]?.says ?? "";
}

/** An entry of a legend. @param {"li" | "span"} tag @param {Shading} shading @param {string} said of the stretch that is pointed at */
export const legendEntry = (tag, { label, tone }, said = "") =>
  el(tag, { class: `entry ink-${TONES[tone].ink}` }, el("i", { class: "swatch cells shade" }), label, el("span", { class: "value" }, said));
