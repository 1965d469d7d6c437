// @ts-check
// One missing effect: physics, size, evidence, cost, and the button that adds it.

import { el } from "../dom.js";
import { capitalised, count, firstSentence, interval, isNumber, number, percent, quantity, seconds } from "../format.js";
import { figureElement } from "../figure.js";
import { effectName } from "../library.js";
import { parameterLimit, parameterName, parameterValue, withParameters } from "../parameters.js";
import { chosen, figureIn } from "../units.js";

/** @typedef {import("../studypage.js").Context} Context */
/** @typedef {import("../types.js").FindingWithRms} Finding */
/** @typedef {import("../types.js").Offer} Offer */
/** @typedef {{finding: Finding, offer: Offer | null, rank: number, isBusy: boolean, context: Context, axis: import("../types.js").AxisPage}} Given */

/** @param {Given} given */
export function findingCard({ finding, offer, rank, isBusy, context, axis }) {
  const { effect, band } = finding;
  const card = offer?.card;
  const [mechanism, more] = firstSentence(card?.mechanism ?? "");
  return el(
    "li",
    { class: "card finding", "data-effect": effect },
    el(
      "header",
      { class: "finding-head" },
      el("span", { class: "rank" }, el("span", { class: "unseen" }, "Rank "), rank),
      el("div", { class: "finding-name" }, el("h3", {}, capitalised(finding.name)), finding.score === null ? null : el("p", { class: "note" }, "score ", number(finding.score), " (9 is enough)")),
      adding(finding, offer, isBusy, context, axis.column),
    ),
    offer && !offer.can_be_added && offer.why_not && !finding.doubt ? el("p", { class: "why-not" }, el("b", {}, "Cannot be added. "), `${capitalised(offer.why_not)}${/[.:!?]$/.test(offer.why_not) ? "" : "."}`) : null,
    el(
      "div",
      { class: "finding-body" },
      el(
        "div",
        { class: "finding-words" },
        finding.doubt ? el("p", { class: "why-not" }, el("b", {}, "Not conclusive. "), `${capitalised(withParameters(finding.doubt))}.`, card?.experiment ? [el("br", {}), el("b", {}, "To decide: "), card.experiment] : null) : null,
        mechanism ? el("p", { class: "mechanism" }, mechanism) : null,
        band === "data" ? null : fall(finding, band, rank > 1),
        el("dl", { class: "facts-list" }, facts(finding, offer, axis)),
        shows(finding, context),
        rivals(finding),
        card ? physics(effect, card, more) : null,
      ),
      offer?.evidence ? el("div", { class: "evidence" }, figureElement(figureIn(offer.evidence, axis.unit, chosen(axis.units.errors)), { height: 240, heading: "h4" })) : null,
    ),
  );
}

/** @param {Finding} finding @param {Offer | null} offer @param {boolean} isBusy @param {Context} context @param {string} axis */
function adding({ effect, name, doubt }, offer, isBusy, { change, announce, stayAt }, axis) {
  if (doubt) return el("p", { class: "cannot" }, "Not conclusive");
  if (!offer?.can_be_added) return el("p", { class: "cannot" }, "Cannot be added");
  return el(
    "button",
    {
      type: "button",
      class: "primary",
      "data-key": `add:${effect}`,
      "aria-disabled": isBusy ? "true" : "false",
      async onclick() {
        if (isBusy) return announce("Something is being computed; it can be cancelled at the top.");
        announce(`Adding ${name}.`);
        if (await change("add", { axis, effect })) stayAt(4);
        else announce("");
      },
    },
    "Add",
    el("span", { class: "unseen" }, ` ${name}`),
  );
}

/** @param {string} effect @param {import("../types.js").Effect} card @param {string} more */
function physics(effect, card, more) {
  const rows = [
    ["Signature in a plot", card.gives_away],
    ["Typical size", card.typical_size],
    ["Source", card.source],
    ["Experiment that shows it", card.experiment],
    ["On the device", card.device],
  ];
  return el(
    "details",
    { class: "physics", "data-key": `physics:${effect}` },
    el("summary", {}, "Physics, typical size and experiment"),
    more ? el("p", {}, more) : null,
    card.equation ? el("p", { class: "equation" }, card.equation) : null,
    el("dl", { class: "explained" }, rows.filter(([, text]) => text).map(([name, text]) => [el("dt", {}, name ?? ""), el("dd", {}, text ?? "")]).flat()),
  );
}

/** The predicted reduction, as numbers and as a bar, and the measured one. @param {Finding} finding @param {import("../types.js").Band} band @param {boolean} withOthers */
function fall({ rms_reduction: reduction, rms_reduction_interval: range, measured_rms_reduction: measured }, band, withOthers) {
  if (!isNumber(reduction) || !range || reduction <= 0) return null;
  const bar = el("span", { class: "fall-bar", "aria-hidden": "true" });
  const piece = (/** @type {string} */ kind, /** @type {number} */ from, /** @type {number} */ to) => {
    const element = el("i", { class: kind });
    element.style.left = `${100 * clamp(from)}%`;
    element.style.width = `${100 * (clamp(to) - clamp(from))}%`;
    bar.append(element);
  };
  piece("fall-expected", 0, reduction);
  piece("fall-interval", range[0], range[1]);
  return el(
    "div",
    { class: "fall" },
    el("p", {}, el("strong", {}, percent(reduction)), ` predicted reduction of the RMS ${band === "wide" ? "of the samples" : "of the slow error"}`, el("span", { class: "note" }, ` (90 % interval ${interval(range, (value) => percent(value))})`)),
    bar,
    isNumber(measured) ? el("p", { class: "fall-measured" }, el("strong", {}, percent(measured)), " measured reduction on the evaluation data", withOthers ? el("span", { class: "note" }, " (with the findings above it in the model)") : null) : null,
  );
}

/** @param {number} share */
const clamp = (share) => Math.min(Math.max(isNumber(share) ? share : 0, 0), 1);

/** @param {Finding} finding @param {Offer | null} offer @param {import("../types.js").AxisPage} axis */
function facts(finding, offer, axis) {
  /** @type {HTMLElement[]} */
  const rows = [];
  const add = (/** @type {string} */ name, /** @type {string} */ value, /** @type {string} */ detail) =>
    rows.push(el("dt", {}, name), el("dd", {}, el("span", { class: "number" }, value), detail ? el("span", { class: "note" }, ` ${detail}`) : null));
  for (const size of finding.sizes) {
    const choice = axis.units.sizes[size.unit];
    const unit = choice ? chosen(choice) : { label: size.unit, divisor: 1 };
    const inSize = (/** @type {number} */ value) => quantity(value / unit.divisor, unit.label);
    add(finding.sizes.length > 1 ? `Size of ${shortRegressor(size.of)}` : "Size", inSize(size.value), `95 %: ${interval(size.interval, (value) => number(isNumber(value) ? value / unit.divisor : value))}`);
  }
  for (const [name, value] of Object.entries(finding.params)) {
    const range = finding.params_interval[name];
    add(parameterName(name, finding.effect), parameterValue(name, value), range ? `95 %: ${interval(range, (one) => parameterLimit(name, one))}` : "");
  }
  if (finding.shows_against) add("Shows against", finding.shows_against, "");
  const cost = offer?.cost;
  if (cost) add("Cost on the device", `${count(cost.terms)} ${cost.terms === 1 ? "term" : "terms"}, ${count(cost.ram_bytes)} bytes of RAM`, `about ${count(cost.instructions)} instructions a sample`);
  return rows;
}

/** Name without its long numbers. @param {string} of */
const shortRegressor = (of) => of.replace(/\d+\.\d{3,}/g, (digits) => number(Number(digits), 3));

/** @param {Finding} finding @param {Context} context */
function shows({ effect, shows_from_to_s: where }, { choose, goTo }) {
  if (!where) return null;
  const [from, to] = where;
  const act = () => {
    choose({ from, to, mark: null });
    goTo(1);
  };
  return el("p", { class: "shows" }, "Largest from ", el("button", { type: "button", class: "link", "data-key": `shows:${effect}`, onclick: act }, `${seconds(from)} to ${seconds(to)}`), " of the log.");
}

/** @param {Finding} finding */
function rivals({ confounded_with, separate }) {
  if (confounded_with.length === 0) return el("p", { class: "note" }, "Nothing else in the library explains this log as well.");
  const experiment = (/** @type {string} */ id) => separate.find(({ effect }) => effect === id)?.experiment;
  return el(
    "div",
    { class: "rivals" },
    el("p", {}, el("b", {}, "In this log indistinguishable from: ")),
    el("ul", {}, confounded_with.map((id) => el("li", {}, el("b", {}, effectName(id)), experiment(id) ? `. To distinguish them: ${experiment(id)}` : ""))),
  );
}
