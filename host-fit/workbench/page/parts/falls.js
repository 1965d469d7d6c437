// @ts-check
// Part 4: predicted and measured reduction of every step, the error before and after over time, and undo.

import { el, icon, replace } from "../dom.js";
import { capitalised, count, fileName, interval, isNumber, number, percent, seconds } from "../format.js";
import { figureElement } from "../figure.js";
import { TimeChart } from "../timechart.js";
import { chosen, figureIn, system } from "../units.js";
import { section, waitingFor } from "./section.js";

/** @typedef {import("../studypage.js").Context} Context */
/** @typedef {import("../studypage.js").Scene} Scene */
/** @typedef {import("../types.js").Refinement} Refinement */
/** @typedef {import("../types.js").StepWithRms} Step */
/** @typedef {import("../types.js").AxisPage} AxisPage */

/** Free-run horizons in the table, s. */
const HORIZONS = [1, 10, 60];

/** @param {Context} context @returns {import("../studypage.js").Part} */
export function fallsPart(context) {
  const body = el("div", { class: "steps-card" });
  const chart = new TimeChart({
    label: "Before and after",
    height: 240,
    time: context.time,
    traces: [
      { of: "left_before", label: "residual before", ink: "--ink-other" },
      { of: "left", label: "residual after", ink: "--ink-residual" },
      { of: "measured", label: "measured", ink: "--ink-measured", off: true },
      { of: "predicted_before", label: "predicted before", ink: "--ink-shade", off: true },
      { of: "predicted", label: "predicted after", ink: "--ink-predicted", off: true },
    ],
  });
  const overlay = el("div", { class: "card", hidden: true, "data-figure": "before-after" }, el("h3", {}, "Before and after, on the log to explain"), chart.element);
  const picture = el("div", {});
  const element = section(4, "The improvement", "Did the error fall as predicted, on data that were not fitted?", body, overlay, picture);
  context.source.onData((drawn) => chart.setData(drawn?.shown.left_before ? drawn.shown : null));
  let drawn = "";
  return {
    element,
    update(scene) {
      const { axis, state } = scene;
      const isBusy = state.job?.asked_for ?? false;
      const steps = axis?.refinement?.steps.length ?? 0;
      overlay.hidden = steps < 2;
      if (axis) {
        chart.setUnit(chosen(axis.units.errors));
        chart.setLabel(axis.label);
      }
      const now = JSON.stringify([axis?.column, axis?.refinement, axis?.pays, axis?.units, isBusy, steps < 2 ? emptyText(scene) : null, system()]);
      if (now === drawn) return;
      drawn = now;
      if (!axis?.refinement || steps < 2) {
        replace(picture);
        return replace(body, el("div", { class: "card" }, el("p", { class: "empty" }, emptyText(scene))));
      }
      replace(body, el("div", { class: "card" }, el("p", { class: "evaluated" }, evaluatedOn(axis.refinement, scene)), table(axis, axis.refinement, isBusy, context)));
      replace(picture, axis.staircase ? el("div", { class: "card" }, figureElement(figureIn(axis.staircase, axis.unit, chosen(axis.units.errors)), { height: 210 })) : null);
    },
  };
}

/** @param {Scene} scene */
function emptyText(scene) {
  const { state, axis } = scene;
  if (state.job?.asked_for || !axis?.diagnosis) return waitingFor(scene, "Nothing has been added to this axis.");
  return axis.standing?.outcome === "missing" ? "Nothing has been added yet. Add an effect above to see the error before and after it." : "Nothing has been added to this axis.";
}

/** @param {Refinement} refinement @param {Scene} scene */
function evaluatedOn({ logs }, { axis }) {
  if (logs.evaluation) return ["Evaluated on ", el("b", {}, fileName(logs.evaluation.path)), ", a later log that nothing was fitted to; the effects were estimated from ", el("b", {}, fileName(logs.log.path)), "."];
  const where = axis?.evaluated_s ? ` (${seconds(axis.evaluated_s[0])} to ${seconds(axis.evaluated_s[1])})` : "";
  return ["Evaluated on the rows of ", el("b", {}, fileName(logs.log.path)), ` from row ${count(logs.fitted_rows)} on${where}, which were not fitted.`];
}

/** @param {AxisPage} axis @param {Refinement} refinement @param {boolean} isBusy @param {Context} context */
function table({ units, pays }, { column, steps }, isBusy, { change, announce }) {
  const unit = chosen(units.errors);
  const root = (/** @type {number | null | undefined} */ square) => (isNumber(square) ? number(Math.sqrt(square) / unit.divisor) : number(null));
  const coast = (/** @type {Step} */ { errors }, /** @type {number} */ horizon) => root(errors.coast.find(({ horizon_s }) => horizon_s === horizon)?.mse);

  const undo = (/** @type {number} */ at) => {
    const isLast = at === steps.length - 1;
    const name = steps[at]?.added?.finding.name ?? "";
    return el(
      "button",
      {
        type: "button",
        class: "small",
        "data-key": `undo:${at}`,
        "aria-disabled": isBusy ? "true" : "false",
        async onclick() {
          if (isBusy) return announce("A computation is running; cancel it at the top.");
          announce(isLast ? `Undoing ${name}.` : `Undoing ${name} and later effects.`);
          await change("undo", { axis: column, keep: at - 1 });
        },
      },
      isLast ? "Undo" : "Undo from here",
      el("span", { class: "unseen" }, isLast ? ` ${name}` : `: ${name} and later effects`),
    );
  };

  const row = (/** @type {Step} */ step, /** @type {number} */ at) => {
    const { added, left, errors, cost } = step;
    return el(
      "tr",
      { "data-step": added?.effect.id ?? "before" },
      el("th", { scope: "row" }, el("span", { class: "step-number" }, at), added ? capitalised(added.finding.name) : "Before", added ? undo(at) : null),
      el("td", {}, added ? [el("b", {}, percent(added.finding.rms_reduction)), el("br"), el("span", { class: "note" }, interval(added.finding.rms_reduction_interval, (value) => percent(value)))] : null),
      el("td", {}, added ? measured(step, pays[at] ?? true) : null),
      [root(left.slow), root(left.wide), root(errors.one_step_mse), ...HORIZONS.map((horizon) => coast(step, horizon)), count(cost.terms), count(cost.ram_bytes), count(cost.instructions)].map((text) => el("td", { class: "right" }, text)),
    );
  };

  const head = (/** @type {string} */ text, /** @type {Record<string, string | number>} */ attributes = {}) => el("th", { scope: "col", ...attributes }, text);
  const inUnit = ` (${unit.label})`;
  return el(
    "div",
    { class: "scrolls", tabindex: 0, role: "region", "aria-label": "The error after every step" },
    el(
      "table",
      { class: "stairs" },
      el(
        "thead",
        {},
        el("tr", {}, head("Step", { rowspan: 2 }), head("Reduction of the RMS", { colspan: 2, scope: "colgroup" }), head(`Residual RMS${inUnit}`, { colspan: 2, scope: "colgroup" }), head(`RMS${inUnit}`, { colspan: 4, scope: "colgroup" }), head("Cost", { colspan: 3, scope: "colgroup" })),
        el("tr", {}, head("predicted (90 %)"), head("measured"), ["slow", "samples", "one step", ...HORIZONS.map((horizon) => `${horizon} s ahead`), "terms", "RAM, bytes", "instructions"].map((text) => head(text, { class: "right" }))),
      ),
      el("tbody", {}, steps.map(row)),
    ),
  );
}

/** @param {Step} step @param {boolean} pays */
function measured({ rms_reduction: reduction, added }, pays) {
  const [low, high] = added?.finding.rms_reduction_interval ?? [0, 0];
  const fell = reduction ?? 0;
  const held = pays && fell >= low && fell <= high;
  const says = !pays ? "no more than noise" : held ? "as predicted" : fell > high ? "more than predicted" : "less than predicted";
  return [el("b", {}, percent(reduction)), el("br"), el("span", { class: `held ${held ? "yes" : "no"}` }, icon(held ? "held" : "not_held"), says)];
}
