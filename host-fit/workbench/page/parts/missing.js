// @ts-check
// Part 3: the verdict, the missing effects in order, and the evidence.

import { el, icon, replace } from "../dom.js";
import { capitalised, count, number } from "../format.js";
import { figureElement } from "../figure.js";
import { effectName, effectOf, readLibrary } from "../library.js";
import { withParameters } from "../parameters.js";
import { chosen, inUnit, system } from "../units.js";
import { OUTCOMES } from "../verdict.js";
import { onPage } from "../notices.js";
import { findingCard } from "./findingcard.js";
import { section, waitingFor } from "./section.js";

/** @typedef {import("../studypage.js").Context} Context */
/** @typedef {import("../studypage.js").Scene} Scene */
/** @typedef {import("../types.js").Diagnosis} Diagnosis */
/** @typedef {import("../types.js").Page} State */
/** @typedef {import("../types.js").AxisPage} AxisPage */

/** @param {Context} context @returns {import("../studypage.js").Part} */
export function missingPart(context) {
  const verdict = el("div", { class: "verdict-place" });
  const cards = el("ol", { class: "findings" });
  const motion = el("div", {});
  const rest = el("div", { class: "rest" });
  const element = section(3, "Missing effects", "Which physical effect explains the residual, how large is it, and how certain is that?", verdict, cards, motion, rest);
  let drawn = "";
  let drawnRest = "";
  let drawnMotion = "";

  /** @param {Scene} scene */
  function update(scene) {
    const { axis, state } = scene;
    const diagnosis = axis?.diagnosis ?? null;
    const isBusy = state.job?.asked_for ?? false;
    const now = JSON.stringify([axis?.column, diagnosis, axis?.standing, axis?.offers, isBusy, diagnosis ? null : waitingFor(scene, ""), axis?.refinement?.steps.length, system()]);
    if (now !== drawn) {
      drawn = now;
      replace(verdict, axis?.standing ? verdictElement(axis.standing, diagnosis) : el("div", { class: "card" }, el("p", { class: "empty" }, waitingFor(scene, "This axis has not been diagnosed yet."))));
      const entry = (/** @type {import("../types.js").FindingWithRms} */ finding, /** @type {number} */ at) =>
        findingCard({ finding, offer: axis?.offers[at] ?? null, rank: at + 1, isBusy, context, axis: /** @type {AxisPage} */ (axis) });
      const entries = axis ? (diagnosis?.findings.map(entry) ?? []) : [];
      // faults of the data follow the effects
      const firstFault = diagnosis?.findings.findIndex(({ band }) => band === "data") ?? -1;
      if (firstFault >= 0) entries.splice(firstFault, 0, el("li", { class: "faults" }, el("h3", {}, "Faults of the data")));
      replace(cards, entries);
      cards.hidden = !diagnosis || diagnosis.findings.length === 0;
    }
    const nowMotion = JSON.stringify([state.logs, state.keeps_moved, hasEffects(state.axes)]);
    if (nowMotion !== drawnMotion) {
      drawnMotion = nowMotion;
      replace(motion, motionOf(state, context));
    }
    const nowRest = JSON.stringify([axis?.column, diagnosis, system()]);
    if (nowRest !== drawnRest) {
      drawnRest = nowRest;
      replace(rest, axis && diagnosis ? restOf(axis, diagnosis) : null);
    }
  }

  // names replace identifiers once the library is read
  let latest = /** @type {Scene | null} */ (null);
  readLibrary().then(
    () => {
      drawn = drawnRest = "";
      if (latest) update(latest);
    },
    () => {},
  );
  return {
    element,
    update(scene) {
      latest = scene;
      update(scene);
    },
  };
}

/** @param {import("../types.js").Standing} standing @param {Diagnosis | null} diagnosis */
function verdictElement({ outcome, sentence, record }, diagnosis) {
  const { title } = OUTCOMES[outcome];
  // some sentences start with their title
  const says = sentence.startsWith(title) ? sentence.slice(title.length).replace(/^[:. ]+/, "") : sentence;
  return el(
    "div",
    { class: `verdict ${outcome}`, "data-verdict": outcome },
    icon(outcome),
    el("div", {}, el("p", { class: "verdict-word" }, title), el("p", { class: "verdict-sentence" }, capitalised(withParameters(says))), record.length > 0 && el("p", {}, el("b", {}, "What the tests need: "), `${record.join("; ")}.`), outcome === "nothing_missing" && diagnosis && diagnosis.untested.length > 0 && el("p", { class: "note" }, `${diagnosis.tested.length} slow effects were tested. ${diagnosis.untested.length} effects could not be tested on this log; what they need is listed below.`)),
  );
}

/** Largest number of listed stretches per log. */
const MOST_TOLD = 12;

/** True if any axis has an added effect. @param {State["axes"]} axes */
const hasEffects = (axes) => axes.some(({ refinement }) => (refinement?.steps.length ?? 0) > 1);

/** Detected motion, and the button that excludes or keeps it. @param {State} state @param {Context} context */
function motionOf({ logs, keeps_moved: isKept, axes }, context) {
  if (!logs) return null;
  // a stretch shaded in two parts is listed once
  const says = (/** @type {import("../types.js").LogSummary | null} */ log) => [...new Set(log?.moved.ranges.map((range) => range.says))];
  const field = says(logs.log);
  const others = /** @type {[string, string[]][]} */ ([["Reference log", says(logs.reference)], ["Evaluation log", says(logs.evaluation)]]).filter(([, told]) => told.length > 0);
  if (!isKept && field.length === 0 && others.length === 0) return null;
  const list = (/** @type {string[]} */ told) => el("ul", {}, told.slice(0, MOST_TOLD).map((text) => el("li", {}, text)), told.length > MOST_TOLD && el("li", {}, `and ${told.length - MOST_TOLD} more`));
  const turn = el("button", { type: "button", "data-key": "moved", onclick: () => void context.change("moved", { keep: !isKept }) }, isKept ? "Exclude them again" : "Include these rows");
  return el(
    "div",
    { class: "card wide moved" },
    el("h3", {}, "The device moved"),
    el("p", { class: "note" }, isKept ? "Motion is not excluded: fits, comparisons and diagnoses include these rows." : "Motion shows on several axes at once. These stretches are excluded from fits, comparisons and diagnoses."),
    field.length > 0 && list(field),
    others.flatMap(([name, told]) => [el("h4", {}, name), list(told)]),
    el("p", {}, turn, el("span", { class: "note" }, ` This computes everything again${hasEffects(axes) ? " and removes the added effects" : ""}.`)),
  );
}

/** A slow signal of several axes, over time. @param {import("../types.js").SharedSignal} signal */
function sharedSignal({ axes, correlations, mean_s, course }) {
  const low = Math.min(...correlations);
  const high = Math.max(...correlations);
  /** @type {import("../types.js").Figure} */
  const figure = {
    title: "A slow signal that axes share",
    panels: [{ title: `${axes.join(", ")}: correlation of the changes ${number(low, 2)} … ${number(high, 2)}`, x: { label: "Time after the first sample (s)", scale: "Linear", names: [] }, y: { label: "Shared signal (standard deviations)", scale: "Linear", names: [] }, series: [{ label: `${number(mean_s)}-s means`, ink: "Residual", shape: { Line: course } }], shading: [] }],
  };
  return el("div", { class: "card wide", "data-figure": "shared" }, figureElement(figure, { height: 180 }));
}

/** Properties of the log, tests and noise behind the verdict. @param {AxisPage} axis @param {Diagnosis} diagnosis */
function restOf(axis, diagnosis) {
  const { cautions, notes, leads, rejected, tested, untested, noise, shared_signal: shared } = diagnosis;
  const names = ["N, white noise", "B, bias instability", "K, random walk"];
  const { white, flicker, walk } = noise.levels;
  const levels = [white, flicker, walk].map((level, at) => [names[at], inUnit(level, chosen(/** @type {import("../types.js").UnitChoice} */ (axis.units.noise[at])))]);
  return el(
    "div",
    { class: "grid two" },
    shared ? sharedSignal(shared) : null,
    cautions.length > 0 && el("div", { class: "card wide cautions" }, el("h3", {}, icon("caution"), "Cautions"), el("ul", {}, cautions.map((text) => el("li", {}, onPage(text))))),
    notes.length > 0 && el("div", { class: "card wide" }, el("h3", {}, "About the log"), el("ul", {}, notes.map((text) => el("li", {}, capitalised(text))))),
    leads.length > 0 &&
      el(
        "div",
        { class: "card wide" },
        el("h3", {}, "Leads"),
        el("p", { class: "note" }, "Channels that the residual follows best. A lead is not a finding: it shows where to look, not why."),
        el("ul", { class: "scores" }, leads.map(({ follows, score }) => el("li", {}, el("span", {}, follows), el("span", { class: "score" }, `score ${number(score)}`)))),
      ),
    el(
      "div",
      { class: "card" },
      el("h3", {}, "Tested and not chosen"),
      rejected.length === 0
        ? el("p", { class: "note" }, "Nothing else was tested.")
        : [
            el("p", { class: "note" }, "Each effect alone on the log. Scores below 9 are not significant; for higher ones the reason is stated."),
            el("ul", { class: "scores" }, rejected.map(({ effect, score, why }) => el("li", { title: effectOf(effect)?.gives_away }, el("span", {}, effectName(effect), why ? el("span", { class: "note" }, `: ${withParameters(why)}`) : null), el("span", { class: "score" }, number(score))))),
          ],
    ),
    el(
      "div",
      { class: "card" },
      el("h3", {}, "Tested"),
      el("p", { class: "note" }, tested.length === 0 ? "No slow effect could be tested on this log." : tested.map(effectName).join(", ")),
      el("h3", {}, "Not tested"),
      untested.length === 0
        ? el("p", { class: "note" }, "The log allows every test of the library.")
        : [el("p", { class: "note" }, "These tests need:"), el("ul", { class: "scores" }, untested.map(({ effect, needs }) => el("li", {}, el("span", {}, effectName(effect)), el("span", { class: "needs" }, needs.join(", ")))))],
      el("h3", {}, "Noise in these tests"),
      el("p", { class: "note" }, `These levels decide which effects are significant; they are not comparable with N, B and K of the log in part 2. Estimated from ${noise.learnt_from}. Slow effects were tested in ${count(noise.blocks)} blocks of ${number(noise.block_s)} s.`),
      el("dl", { class: "facts-list" }, levels.map(([name, value]) => [el("dt", {}, name ?? ""), el("dd", {}, value ?? "")]).flat()),
    ),
  );
}
