// @ts-check
// Table of all axes of a study: outcome, slow error, suggested effect. A click shows the axis.

import { el, icon } from "./dom.js";
import { capitalised, number, percent } from "./format.js";
import { effectName } from "./library.js";
import { chosen } from "./units.js";
import { OUTCOMES, SLOW_ERROR } from "./verdict.js";

/** @typedef {import("./types.js").AxisPage} AxisPage */

const HEAD = ["Axis", "Outcome", "Slow error", "With the model", "Unit", "Suggested effect", "Predicted reduction of the RMS"];
const RIGHT = new Set([2, 3, 6]);

/**
 * @param {AxisPage[]} axes
 * @param {string | null} viewed
 * @param {boolean} isWorking
 * @param {(column: string) => void} choose
 * @param {HTMLElement} units the choice of units
 */
export function axesTable(axes, viewed, isWorking, choose, units) {
  const row = (/** @type {AxisPage} */ axis) => {
    const { column, label, standing, diagnosis, failure, slow_error: slow } = axis;
    const unit = chosen(axis.units.errors);
    const rms = (/** @type {number | null | undefined} */ value) => number(typeof value === "number" ? value / unit.divisor : value);
    const suggested = diagnosis?.findings.find(({ doubt, band }) => !doubt && band !== "data") ?? null;
    const unknown = failure ? "cannot be diagnosed" : isWorking ? "being diagnosed" : "not diagnosed";
    const cells = [
      standing ? [icon(standing.outcome), ` ${capitalised(OUTCOMES[standing.outcome].word)}`] : [el("span", { class: "note" }, capitalised(unknown))],
      [rms(slow?.[0])],
      [rms(slow?.[1])],
      [unit.label],
      [suggested ? capitalised(suggested.name || effectName(suggested.effect)) : "–"],
      [suggested && suggested.expected_drop > 0 ? `${percent(suggested.rms_reduction)} of the ${suggested.band === "wide" ? "samples" : "slow error"}` : "–"],
    ];
    const isViewed = column === viewed;
    const name = el("button", { type: "button", class: "link", "data-key": `overview:${column}`, "aria-current": isViewed ? "true" : null, onclick: () => choose(column) }, label);
    return el(
      "tr",
      { "data-overview": column, "data-outcome": standing?.outcome ?? null, "data-current": isViewed ? "true" : null, onclick: () => choose(column) },
      el("th", { scope: "row" }, name),
      cells.map((cell, at) => el("td", { class: RIGHT.has(at + 1) ? "right" : null }, cell)),
    );
  };
  const head = HEAD.map((text, at) => el("th", { scope: "col", class: RIGHT.has(at) ? "right" : null }, text));
  return el(
    "div",
    { class: "card axes-table" },
    el("div", { class: "scrolls", tabindex: 0, role: "region", "aria-label": "All axes" }, el("table", {}, el("thead", {}, el("tr", {}, head)), el("tbody", {}, axes.map(row)))),
    el("div", { class: "axes-foot" }, el("p", { class: "note" }, SLOW_ERROR), units),
  );
}
