// @ts-check
// What all five parts look like.

import { el, uniqueId } from "../dom.js";
import { capitalised } from "../format.js";

/** Stands in for what is not computed: the work on this axis while there is any, else `nothing`. @param {import("../studypage.js").Scene} scene @param {string} nothing */
export function waitingFor({ state, axis }, nothing) {
  if (axis?.failure) return `${axis.label} cannot be diagnosed; the reason stands at the top.`;
  return state.job ? `${capitalised(state.job.what)} …` : nothing;
}

/**
 * @param {number} number
 * @param {string} title
 * @param {string} question what it answers, in a sentence
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
