// @ts-check
// Shaded stretches: painted, with an entry in the legend and a description under the pointer.

import uPlot from "./vendor/uplot.esm.js";
import { el } from "./dom.js";
import { faint } from "./theme.js";

/** @typedef {import("./types.js").Shading} Shading */
/** @typedef {import("./types.js").ShadedRange} Range */

/** Colour and opacity by the reason for the shading: the custom property, and its opacity. */
const TONES = { Apart: { ink: "shade", opacity: 0.25 }, LeftOut: { ink: "left-out", opacity: 0.3 } };
/** Distance from a stretch at which it is described, pixels. */
const REACH = 4;

/** Position of a stretch on the canvas; one too short to see is widened about its middle. @param {uPlot} u @param {{from: number, to: number}} range */
export function placeOf(u, range) {
  const [from, to] = [u.valToPos(range.from, "x", true), u.valToPos(range.to, "x", true)];
  const half = Math.max(0.5 * (to - from), 1.5 * uPlot.pxRatio);
  return { left: 0.5 * (from + to) - half, width: 2 * half, middle: 0.5 * (from + to) };
}

/** The stretches between two values of x. @param {Shading} shading @param {number} low @param {number} high */
export const within = (shading, low, high) => shading.ranges.filter(({ from, to }) => to >= low && from <= high);

/**
 * Lowest and highest visible value outside of excluded stretches; of all values where every visible one is excluded.
 * @param {uPlot} u @param {Shading | null} shading @param {number | null} low of all visible values @param {number | null} high
 * @returns {[number | null, number | null]}
 */
export function rangeOutside(u, shading, low, high) {
  if (shading?.tone !== "LeftOut" || shading.ranges.length === 0) return [low, high];
  const time = u.data[0];
  const [first, last] = u.series[0]?.idxs ?? [0, time.length - 1];
  const shown = u.series.slice(1).flatMap(({ show }, at) => (show ? [/** @type {(number | null)[]} */ (u.data[at + 1])] : []));
  // means and buckets at the edge of a stretch contain excluded samples too
  const reach = (/** @type {number} */ at) => 0.5 * Math.min(...[at - 1, at].map((of) => Number(time[of + 1]) - Number(time[of])).filter((gap) => gap > 0));
  let [least, most] = [Infinity, -Infinity];
  for (let at = first; at <= last; at += 1) {
    const now = Number(time[at]);
    const half = reach(at);
    if (shading.ranges.some(({ from, to }) => now > from - half && now < to + half)) continue;
    for (const values of shown) {
      const value = values[at];
      if (typeof value !== "number") continue;
      least = Math.min(least, value);
      most = Math.max(most, value);
    }
  }
  return least <= most ? [least, most] : [low, high];
}

/** Paints the visible stretches. @param {uPlot} u @param {Shading} shading */
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

/** Description of the stretch at `left` pixels into the plot; empty if there is none. @param {uPlot} u @param {Shading} shading @param {number} left */
export function saidAt(u, shading, left) {
  const [low, high] = [u.posToVal(left - REACH, "x"), u.posToVal(left + REACH, "x")];
  const at = 0.5 * (low + high);
  const distance = (/** @type {Range} */ { from, to }) => Math.max(from - at, at - to, 0);
  return within(shading, low, high).sort((a, b) => distance(a) - distance(b))[0]?.says ?? "";
}

/** An entry of a legend. @param {"li" | "span"} tag @param {Shading} shading @param {string} said description of the stretch under the pointer */
export const legendEntry = (tag, { label, tone }, said = "") =>
  el(tag, { class: `entry ink-${TONES[tone].ink}` }, el("i", { class: "swatch cells shade" }), label, el("span", { class: "value" }, said));
