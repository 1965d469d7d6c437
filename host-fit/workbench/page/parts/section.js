// @ts-check
// Frame of the five parts.

import { el, uniqueId } from "../dom.js";
import { capitalised } from "../format.js";

/** Placeholder for a missing result: the running computation, else `nothing`. @param {import("../studypage.js").Scene} scene @param {string} nothing */
export function waitingFor({ state, axis }, nothing) {
  if (axis?.failure) return `${axis.label} cannot be diagnosed; see the reason at the top.`;
  return state.job ? `${capitalised(state.job.what)} …` : nothing;
}

/**
 * @param {number} number
 * @param {string} title
 * @param {string} question that the part answers
 * @param {...HTMLElement} children
 */
export function section(number, title, question, ...children) {
  const id = uniqueId("part");
  return el(
    "section",
    { class: "part", "aria-labelledby": id, "data-part": number },
    el("header", { class: "part-head" }, el("span", { class: "part-number", "aria-hidden": "true" }, number), el("div", {}, el("h2", { id, tabindex: -1 }, title), el("p", { class: "question" }, question))),
    children,
  );
}
