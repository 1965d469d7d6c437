// @ts-check
// The stretches with the largest slow error: shading, buttons and text.

import { el, replace } from "../dom.js";
import { number, seconds } from "../format.js";
import { chosen as unitOf, inUnit } from "../units.js";

/** @typedef {import("../studypage.js").Scene} Scene */
/** @typedef {import("../studypage.js").Chosen} Chosen */

/** Shading of the charts over time: the worst stretches and the chosen one. @param {Scene} scene @returns {import("../timechart.js").Shade[]} */
export function shadesOf({ axis, chosen }) {
  const worst = axis?.comparison?.worst ?? [];
  const shades = worst.map(({ begin_s, end_s }, at) => ({ from: begin_s, to: end_s, mark: String(at + 1), chosen: isSame(chosen, begin_s, end_s) }));
  if (chosen && !shades.some((shade) => shade.chosen)) shades.push({ from: chosen.from, to: chosen.to, mark: "•", chosen: true });
  return shades;
}

/** Detected motion: shaded too, and not part of any stretch. @param {Scene} scene */
export const movedOf = ({ state }) => state.logs?.log.moved ?? null;

/** @param {Chosen | null} chosen @param {number} from @param {number} to */
const isSame = (chosen, from, to) => chosen !== null && chosen.from === from && chosen.to === to;

/** @param {Chosen} chosen */
export const wordsFor = ({ from, to, mark }) =>
  `${mark && mark !== "•" ? `stretch ${mark}, ` : ""}${seconds(from, to - from < 10 ? 10 : 100)} to ${seconds(to, to - from < 10 ? 10 : 100)}`;

/**
 * The list of the worst stretches.
 * @param {HTMLElement} list
 * @param {Scene} scene
 * @param {(chosen: Chosen | null) => void} choose
 */
export function drawStretches(list, { axis, chosen }, choose) {
  const comparison = axis?.comparison;
  if (!axis || !comparison) return replace(list);
  const unit = unitOf(axis.units.errors);
  const entry = (/** @type {import("../types.js").Stretch} */ stretch, /** @type {number} */ at) => {
    const isChosen = isSame(chosen, stretch.begin_s, stretch.end_s);
    return el(
      "li",
      {},
      el(
        "button",
        {
          type: "button",
          class: "stretch",
          "aria-pressed": isChosen ? "true" : "false",
          "data-key": `stretch:${at}`,
          onclick: () => choose(isChosen ? null : { from: stretch.begin_s, to: stretch.end_s, mark: String(at + 1) }),
        },
        el("b", { class: "mark" }, at + 1),
        el("span", { class: "when" }, `${seconds(stretch.begin_s)} to ${seconds(stretch.end_s)}`),
        el("span", { class: "size" }, `slow error ${inUnit(stretch.rms, unit)} RMS, ${number(stretch.ratio)} times the usual`),
        stretch.special.length > 0 ? el("span", { class: "special" }, stretch.special.join("; ")) : null,
      ),
    );
  };
  const none = el("li", { class: "note" }, "No stretch stands out: the slow error is equally large everywhere, within noise.");
  replace(list, comparison.worst.length > 0 ? comparison.worst.map(entry) : none);
}
