// @ts-check
// Several studies in one table: viewed axis, missing effect, and reduction of the error.

import { el, icon } from "./dom.js";
import { percent } from "./format.js";
import { withParameters } from "./parameters.js";
import { chosen, inUnit } from "./units.js";
import { OUTCOMES, SLOW_ERROR } from "./verdict.js";

/** @typedef {import("./types.js").Entry} StudyEntry */

/** Empty for fewer than two studies. @param {StudyEntry[]} studies */
export function sideBySide(studies) {
  if (studies.length < 2) return [];
  const head = ["Study", "Axis", "Result", "Added", "Slow error", "With the model", "Reduction of the slow error"];
  const right = (/** @type {string} */ text) => el("td", { class: "right" }, text);
  const row = (/** @type {StudyEntry} */ { id, name, outcome, working, axis }) => {
    const [before, after] = axis?.slow_error ?? [null, null];
    const isReduced = before !== null && after !== null && before > 0;
    return el(
      "tr",
      { "data-study": id },
      el("th", { scope: "row" }, el("a", { href: `#/study/${id}` }, name)),
      el("td", {}, axis?.label ?? "–"),
      el("td", {}, outcome ? icon(outcome) : null, outcome ? ` ${axis?.sentence ? withParameters(axis.sentence) : OUTCOMES[outcome].title}` : working ? "being computed" : "–"),
      el("td", {}, axis && axis.added.length > 0 ? axis.added.join(", ") : "–"),
      right(axis ? inUnit(before, chosen(axis.errors_in)) : "–"),
      right(axis ? inUnit(after, chosen(axis.errors_in)) : "–"),
      right(isReduced ? percent(1 - after / before) : "–"),
    );
  };
  const table = el("table", {}, el("thead", {}, el("tr", {}, head.map((text, at) => el("th", { scope: "col", class: at > 3 ? "right" : null }, text)))), el("tbody", {}, studies.map(row)));
  return [
    el(
      "section",
      { class: "opening beside", "aria-labelledby": "beside-title" },
      el("h2", { id: "beside-title" }, "Open studies, side by side"),
      el("div", { class: "card" }, el("div", { class: "scrolls", tabindex: 0, role: "region", "aria-label": "Open studies" }, table)),
      el("p", { class: "note" }, SLOW_ERROR),
    ),
  ];
}
