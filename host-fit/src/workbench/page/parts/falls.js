// @ts-check
// Part 4: the staircase. The predicted reduction of every step, the measured one, and the way back.

import { el, icon, replace } from "../dom.js";
import { capitalised, count, fileName, interval, isNumber, number, prefixed, rmsPercent, seconds } from "../format.js";
import { figureElement } from "../figure.js";
import { section } from "./section.js";

/** @typedef {import("../studypage.js").Context} Context */
/** @typedef {import("../studypage.js").Scene} Scene */
/** @typedef {import("../types.js").Refinement} Refinement */
/** @typedef {import("../types.js").RefinementStep} Stair */

/** Coast horizons that the table shows, s. */
const HORIZONS = [1, 10, 60];

/** @param {Context} context @returns {import("../studypage.js").Part} */
export function fallsPart(context) {
  const body = el("div", {});
  const element = section(4, "The error falls", "Did the error fall as predicted, on data that nothing was fitted to?", body);
  let drawn = "";
  return {
    element,
    update(scene) {
      const { axis, state } = scene;
      const isBusy = state.job?.asked_for ?? false;
      const now = JSON.stringify([axis?.column, axis?.growth, axis?.staircase, isBusy, axis?.growth ? null : state.job?.what]);
      if (now === drawn) return;
      drawn = now;
      const steps = axis?.growth?.stairs.length ?? 0;
      if (!axis?.growth || steps < 2) return replace(body, emptyCard(scene));
      replace(
        body,
        el("div", { class: "card" }, el("p", { class: "judged" }, judgedOn(axis.growth, scene)), table(axis.growth, axis.unit, isBusy, context)),
        axis.staircase ? el("div", { class: "card" }, figureElement(axis.staircase, { height: 210 })) : null,
      );
    },
  };
}

/** @param {Scene} scene */
function emptyCard({ state, axis }) {
  const text = state.job ? `${capitalised(state.job.what)} …` : axis?.diagnosis?.verdict === "missing" ? "Nothing has been added yet. Add an effect above, and the error after it stands here beside what was predicted." : "Nothing has been added to this axis.";
  return el("div", { class: "card" }, el("p", { class: "empty" }, text));
}

/** @param {Refinement} refinement @param {Scene} scene */
function judgedOn({ logs }, { axis }) {
  if (logs.judged) return ["Evaluated on ", el("b", {}, fileName(logs.judged.path)), ", a later log that nothing was fitted to; the effects were estimated from ", el("b", {}, fileName(logs.field.path)), "."];
  const where = axis?.judged_s ? ` (${seconds(axis.judged_s[0])} to ${seconds(axis.judged_s[1])})` : "";
  return ["Evaluated on the rows of ", el("b", {}, fileName(logs.field.path)), ` from row ${count(logs.fitted_rows)} on${where}, which nothing was fitted to.`];
}

/** @param {Refinement} refinement @param {string} unit @param {boolean} isBusy @param {Context} context */
function table({ column, stairs }, unit, isBusy, { change, announce }) {
  const largest = Math.max(...stairs.map((stair) => Math.sqrt(stair.left.wide)));
  const suited = prefixed(largest / 30, unit);
  const root = (/** @type {number | null | undefined} */ square) => (isNumber(square) ? number(Math.sqrt(square) / suited.scale) : number(null));
  const coast = (/** @type {Stair} */ { errors }, /** @type {number} */ horizon) => root(errors.coast.find(({ horizon_s }) => horizon_s === horizon)?.mse);

  const undo = (/** @type {number} */ at) => {
    const isLast = at === stairs.length - 1;
    const name = stairs[at]?.added?.finding.name ?? "";
    return el(
      "button",
      {
        type: "button",
        class: "small",
        "data-key": `undo:${at}`,
        "aria-disabled": isBusy ? "true" : "false",
        async onclick() {
          if (isBusy) return announce("Something is being computed; it can be cancelled at the top.");
          announce(isLast ? `Taking ${name} back.` : `Taking back ${name} and all after it.`);
          await change("undo", { axis: column, keep: at - 1 });
        },
      },
      isLast ? "Undo" : "Undo from here",
      el("span", { class: "unseen" }, isLast ? `: take ${name} back` : `: take ${name} and what follows back`),
    );
  };

  const row = (/** @type {Stair} */ stair, /** @type {number} */ at) => {
    const { added, left, errors, cost } = stair;
    return el(
      "tr",
      { "data-step": added?.effect.id ?? "before" },
      el("th", { scope: "row" }, el("span", { class: "step-number" }, at), added ? capitalised(added.finding.name) : "Before", added ? undo(at) : null),
      el("td", {}, added ? [el("b", {}, rmsPercent(added.finding.expected_drop)), el("br"), el("span", { class: "note" }, interval(added.finding.expected_drop_ci, (value) => rmsPercent(value)))] : null),
      el("td", {}, added ? measured(added.realised_fall, added.finding.expected_drop_ci) : null),
      [root(left.slow), root(left.wide), root(errors.one_step_mse), ...HORIZONS.map((horizon) => coast(stair, horizon)), count(cost.terms), count(cost.ram_bytes), count(cost.instructions)].map((text) => el("td", { class: "right" }, text)),
    );
  };

  const head = (/** @type {string} */ text, /** @type {Record<string, string | number>} */ attributes = {}) => el("th", { scope: "col", ...attributes }, text);
  const inUnit = ` (${suited.unit})`;
  return el(
    "div",
    { class: "scrolls", tabindex: 0, role: "region", "aria-label": "The error after every step" },
    el(
      "table",
      { class: "stairs" },
      el(
        "thead",
        {},
        el("tr", {}, head("Step", { rowspan: 2 }), head("Reduction of the RMS", { colspan: 2, scope: "colgroup" }), head(`Residual RMS${inUnit}`, { colspan: 2, scope: "colgroup" }), head(`Rms${inUnit}`, { colspan: 4, scope: "colgroup" }), head("Cost", { colspan: 3, scope: "colgroup" })),
        el("tr", {}, head("predicted (90 %)"), head("measured"), ["slow", "wide", "one step", ...HORIZONS.map((horizon) => `coast ${horizon} s`), "terms", "RAM, bytes", "instructions"].map((text) => head(text, { class: "right" }))),
      ),
      el("tbody", {}, stairs.map(row)),
    ),
  );
}

/** @param {number} fall @param {[number, number]} predicted */
function measured(fall, [low, high]) {
  const held = fall >= low && fall <= high;
  return [el("b", {}, rmsPercent(fall)), el("br"), el("span", { class: `held ${held ? "yes" : "no"}` }, icon(held ? "held" : "not_held"), held ? "as predicted" : fall > high ? "more than predicted" : "less than predicted")];
}
