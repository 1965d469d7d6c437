// @ts-check
// Part 3: the answer, the effects that are missing in order, and what the answer rests on.

import { el, icon, replace } from "../dom.js";
import { capitalised, count, number, quantity } from "../format.js";
import { effectName, effectOf, readLibrary } from "../library.js";
import { VERDICTS } from "../verdict.js";
import { findingCard } from "./findingcard.js";
import { section } from "./section.js";

/** @typedef {import("../studypage.js").Context} Context */
/** @typedef {import("../studypage.js").Scene} Scene */
/** @typedef {import("../types.js").Diagnosis} Diagnosis */
/** @typedef {import("../types.js").Page} State */

/** @param {Context} context @returns {import("../studypage.js").Part} */
export function missingPart(context) {
  const verdict = el("div", { class: "verdict-place" });
  const cards = el("ol", { class: "findings" });
  const motion = el("div", {});
  const rest = el("div", { class: "rest" });
  const element = section(3, "What is missing", "Which physical effect explains what is left, how large is it, and how sure is that?", verdict, cards, motion, rest);
  let drawn = "";
  let drawnRest = "";
  let drawnMotion = "";

  /** @param {Scene} scene */
  function update(scene) {
    const { axis, state } = scene;
    const diagnosis = axis?.diagnosis ?? null;
    const isBusy = state.job?.asked_for ?? false;
    const now = JSON.stringify([axis?.column, diagnosis, axis?.offers, isBusy, diagnosis ? null : state.job?.what, axis?.growth?.stairs.length]);
    if (now !== drawn) {
      drawn = now;
      replace(verdict, diagnosis ? verdictElement(diagnosis) : el("div", { class: "card" }, el("p", { class: "empty" }, state.job ? `This comes with the diagnosis: ${state.job.what} …` : "This axis has not been diagnosed yet.")));
      const entry = (/** @type {import("../types.js").Finding} */ finding, /** @type {number} */ at) =>
        findingCard({ finding, offer: axis?.offers[at] ?? null, rank: at + 1, unit: diagnosis?.unit ?? "", isBusy, context, axis: axis?.column ?? "" });
      const entries = diagnosis?.findings.map(entry) ?? [];
      // faults of the data come last, apart from the effects
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
    const nowRest = JSON.stringify([axis?.column, diagnosis]);
    if (nowRest !== drawnRest) {
      drawnRest = nowRest;
      replace(rest, diagnosis ? restOf(diagnosis) : null);
    }
  }

  // names instead of identifiers, as soon as they are known
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

/** @param {Diagnosis} diagnosis */
function verdictElement({ verdict, sentence }) {
  const { title } = VERDICTS[verdict];
  // the sentence of this answer begins with its title
  const says = sentence.startsWith(title) && (verdict === "nothing_missing" || verdict === "not_enough_data") ? sentence.replace(/^[^:.]*[:.]\s*/, "") : sentence;
  return el("div", { class: `verdict ${verdict}`, "data-verdict": verdict }, icon(verdict), el("div", {}, el("p", { class: "verdict-word" }, title), el("p", { class: "verdict-sentence" }, says.charAt(0).toUpperCase() + says.slice(1))));
}

/** Stretches of a log that are told one by one. */
const MOST_TOLD = 12;

/** Whether an effect was added to any. @param {State["axes"]} axes */
const hasEffects = (axes) => axes.some(({ growth }) => (growth?.stairs.length ?? 0) > 1);

/** When the unit was moved, as it is shaded over time, and whether that is left out. @param {State} state @param {Context} context */
function motionOf({ logs, keeps_moved: isKept, axes }, context) {
  if (!logs) return null;
  // a stretch that is shaded in two parts is told once
  const says = (/** @type {import("../types.js").LogSummary | null} */ log) => [...new Set(log?.moved.ranges.map((range) => range.says))];
  const field = says(logs.field);
  const others = /** @type {[string, string[]][]} */ ([["Reference log", says(logs.quiet)], ["Evaluation log", says(logs.judged)]]).filter(([, told]) => told.length > 0);
  if (!isKept && field.length === 0 && others.length === 0) return null;
  const list = (/** @type {string[]} */ told) => el("ul", {}, told.slice(0, MOST_TOLD).map((text) => el("li", {}, text)), told.length > MOST_TOLD && el("li", {}, `and ${told.length - MOST_TOLD} more`));
  const turn = el("button", { type: "button", "data-key": "moved", onclick: () => void context.change("moved", { keep: !isKept }) }, isKept ? "Leave them out again" : "Count them as any others");
  return el(
    "div",
    { class: "card wide moved" },
    el("h3", {}, "The unit was moved"),
    el("p", { class: "note" }, isKept ? "Rows in which the unit was moved are not looked for: they count as any others in fits, comparisons and answers." : "Found from all axes together: what moves the unit shows on several at once. These stretches are left out of fits, comparisons and answers."),
    field.length > 0 && list(field),
    others.flatMap(([name, told]) => [el("h4", {}, name), list(told)]),
    el("p", {}, turn, el("span", { class: "note" }, ` Everything is computed anew${hasEffects(axes) ? "; effects that were added are taken back" : ""}.`)),
  );
}

/** What else is to be known of the answer. @param {Diagnosis} diagnosis */
function restOf(diagnosis) {
  const { cautions, notes, leads, rejected, tested, untested, noise, unit } = diagnosis;
  const levels = [
    ["white", quantity(noise.levels.white, unit)],
    ["flicker", quantity(noise.levels.flicker, unit)],
    ["random walk", quantity(noise.levels.walk, unit)],
  ];
  return el(
    "div",
    { class: "grid two" },
    cautions.length > 0 && el("div", { class: "card wide cautions" }, el("h3", {}, icon("caution"), "To be taken with care"), el("ul", {}, cautions.map((text) => el("li", {}, text)))),
    notes.length > 0 && el("div", { class: "card wide" }, el("h3", {}, "About the log"), el("ul", {}, notes.map((text) => el("li", {}, capitalised(text))))),
    leads.length > 0 &&
      el(
        "div",
        { class: "card wide" },
        el("h3", {}, "Leads"),
        el("p", { class: "note" }, "What the rest follows best. A lead is no finding: it says where to look, not why."),
        el("ul", { class: "scores" }, leads.map(({ follows, score }) => el("li", {}, el("span", {}, follows), el("span", { class: "score" }, `score ${number(score)}`)))),
      ),
    el(
      "div",
      { class: "card" },
      el("h3", {}, "Tried and not chosen"),
      rejected.length === 0
        ? el("p", { class: "note" }, "Nothing else was tried.")
        : [
            el("p", { class: "note" }, "Each alone on the log; a score below 9 is chance. Of a high one that is not chosen it is said why."),
            el("ul", { class: "scores" }, rejected.map(({ effect, score, why }) => el("li", { title: effectOf(effect)?.gives_away }, el("span", {}, effectName(effect), why !== undefined && el("span", { class: "note" }, `: ${why}`)), el("span", { class: "score" }, number(score))))),
          ],
    ),
    el(
      "div",
      { class: "card" },
      el("h3", {}, "Tested"),
      el("p", { class: "note" }, tested.length === 0 ? "No slow effect could be tested on this log." : tested.map(effectName).join(", ")),
      el("h3", {}, "Not tested"),
      untested.length === 0
        ? el("p", { class: "note" }, "The log has every column that the library asks for.")
        : [el("p", { class: "note" }, "What this log lacks to try these:"), el("ul", { class: "scores" }, untested.map(({ effect, needs }) => el("li", {}, el("span", {}, effectName(effect)), el("span", { class: "needs" }, needs.join(", ")))))],
      el("h3", {}, "Noise"),
      el("p", { class: "note" }, `Learnt from ${noise.learnt_from}; slow effects were looked for in ${count(noise.blocks)} blocks of ${number(noise.block_s)} s.`),
      el("dl", { class: "facts-list" }, levels.map(([name, value]) => [el("dt", {}, name ?? ""), el("dd", {}, value ?? "")]).flat()),
    ),
  );
}
