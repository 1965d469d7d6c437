// @ts-check
// Part 2: the residual, its worst stretches, and figures of it.

import { get, isAbort, messageOf } from "../api.js";
import { el, replace } from "../dom.js";
import { figureElement } from "../figure.js";
import { alertElement } from "../notices.js";
import { modelKey } from "../studypage.js";
import { TimeChart } from "../timechart.js";
import { chosen as unitOf, figureIn, system } from "../units.js";
import { section, waitingFor } from "./section.js";
import { drawStretches, movedOf, shadesOf, wordsFor } from "./stretches.js";
import { drawUnaided, sixAxes } from "./unaided.js";

/** @typedef {import("../studypage.js").Context} Context */
/** @typedef {import("../studypage.js").Scene} Scene */
/** @typedef {import("../types.js").NamedFigure} NamedFigure */

/** Channels shown at first; the others unfold. */
const CHANNELS = 4;
const AGAINST = "against:";
/** Pause after a failed request, ms. */
const RETRY = 2000;

/** @param {Context} context @returns {import("../studypage.js").Part} */
export function failsPart({ study, time, source, choose, announce }) {
  const chart = new TimeChart({
    label: "Residual",
    height: 220,
    time,
    traces: [
      { of: "left", label: "residual: measured − predicted", ink: "--ink-residual" },
      { of: "left_before", label: "before any effect was added", ink: "--ink-other", off: true },
    ],
    click: (shade) => shade && choose({ from: shade.from, to: shade.to, mark: shade.mark }),
  });
  const empty = el("p", { class: "empty" });
  const list = el("ol", { class: "stretches" });
  const listTitle = el("h3", {}, "The worst stretches");
  const unaided = el("div", { class: "unaided" });
  const together = sixAxes(study);
  const note = el("div", { class: "chosen", role: "status" });
  const panels = el("div", { class: "panels" });
  const element = section(2, "Where the model fails", "How large is the residual, when is it worst, and what does it follow?", el("div", { class: "card" }, empty, chart.element, listTitle, list, unaided, together.element), note, panels);

  source.onData((drawn) => chart.setData(drawn?.shown.left ? drawn.shown : null));

  let request = new AbortController();
  let asked = "";
  let marked = "";
  /** Axis of the figures. */
  let pictured = "";

  /** @param {Scene} scene */
  async function readFigures({ axis, chosen, state }) {
    // the previous figures stay until those of the refined model are ready
    if (axis && !axis.comparison && state.job && axis.column === pictured) return panels.setAttribute("aria-busy", "true");
    const key = axis?.comparison ? JSON.stringify([axis.column, modelKey(axis), chosen?.from, chosen?.to, system()]) : "";
    if (key === asked) return;
    asked = key;
    request.abort();
    request = new AbortController();
    const { signal } = request;
    if (!axis?.comparison) return replace(panels);
    if (panels.childElementCount === 0) replace(panels, Array.from({ length: 4 }, () => el("div", { class: "card skeleton tall" })));
    panels.setAttribute("aria-busy", "true");
    const query = new URLSearchParams({ axis: axis.column });
    if (chosen) {
      query.set("from", String(chosen.from));
      query.set("to", String(chosen.to));
    }
    try {
      const figures = /** @type {NamedFigure[]} */ (await get(`/api/studies/${study}/figures?${query}`, signal));
      if (signal.aborted) return;
      drawFigures(panels, figures.map(({ name, figure }) => ({ name, figure: figureIn(figure, axis.unit, unitOf(axis.units.errors)) })), axis.comparison);
      pictured = axis.column;
      if (!chosen) void readNoise(axis, signal);
    } catch (error) {
      if (signal.aborted || isAbort(error)) return;
      setTimeout(() => (asked = ""), RETRY);
      replace(panels, alertElement(messageOf(error)));
    }
    panels.removeAttribute("aria-busy");
  }

  /** N, B and K take a while on a long log, so they are requested after the other figures. @param {import("../types.js").AxisPage} axis @param {AbortSignal} signal */
  async function readNoise(axis, signal) {
    const query = new URLSearchParams({ axis: axis.column, units: system() });
    // the other figures stay if this one fails
    const figure = /** @type {import("../types.js").Figure | null} */ (await get(`/api/studies/${study}/noise?${query}`, signal).catch(() => null));
    if (signal.aborted || !figure) return;
    panels.querySelector('[data-figure="allan"]')?.after(noiseCard(figureIn(figure, axis.unit, unitOf(axis.units.errors))));
  }

  return {
    element,
    update(scene) {
      const { axis, chosen } = scene;
      const isCompared = Boolean(axis?.comparison);
      chart.element.hidden = !isCompared;
      empty.hidden = isCompared;
      empty.textContent = waitingFor(scene, "There is no model of this axis to compare with yet.");
      if (axis) {
        chart.setUnit(unitOf(axis.units.errors));
        chart.setLabel(`${axis.label}, residual`);
      }
      listTitle.hidden = !isCompared;
      chart.setShades(shadesOf(scene));
      chart.setMoved(movedOf(scene));
      const now = JSON.stringify([axis?.column, axis?.comparison?.worst, axis?.comparison?.errors, chosen, system()]);
      if (now !== marked) {
        marked = now;
        drawStretches(list, scene, choose);
        drawUnaided(unaided, axis);
        replace(note, chosen ? chosenNote(chosen, choose) : null);
        if (chosen) announce(`Every panel shows ${wordsFor(chosen)}.`);
      }
      void together.update(scene);
      void readFigures(scene);
    },
  };
}

/** @param {import("../studypage.js").Chosen} chosen @param {(chosen: null) => void} choose */
function chosenNote(chosen, choose) {
  return el(
    "p",
    {},
    el("span", {}, "Every panel shows ", el("b", {}, wordsFor(chosen)), "."),
    el("button", { type: "button", "data-key": "whole", onclick: () => choose(null) }, "Whole log"),
  );
}

/** @param {NamedFigure} named */
const figureCard = ({ name, figure }) => el("div", { class: "card", "data-figure": name }, figureElement(figure));

/** @param {import("../types.js").Figure} figure */
function noiseCard(figure) {
  const card = figureCard({ name: "noise", figure });
  card.classList.add("noted");
  card.append(el("p", { class: "note" }, "N, B and K of the log itself, before any model is subtracted."));
  return card;
}

/** @param {HTMLElement} host @param {NamedFigure[]} figures @param {import("../types.js").AxisComparison} comparison */
function drawFigures(host, figures, comparison) {
  // likeliest channels first
  const order = comparison.dependence?.channels.map(({ channel }) => channel) ?? [];
  const place = (/** @type {NamedFigure} */ { name }) => {
    const at = order.indexOf(name.slice(AGAINST.length));
    return at < 0 ? order.length : at;
  };
  const against = figures.filter(({ name }) => name.startsWith(AGAINST)).sort((a, b) => place(a) - place(b));
  
  const named = (/** @type {string} */ wanted) => figures.find(({ name }) => name === wanted);
  const known = ["allan", "spectrum", "autocorrelation"].map(named).filter((figure) => figure !== undefined);
  const dependence = named("dependence");
  const [first, rest] = [against.slice(0, CHANNELS), against.slice(CHANNELS)];
  replace(
    host,
    el("h3", {}, "In time and frequency"),
    el("div", { class: "grid two" }, known.map(figureCard)),
    against.length > 0 ? el("h3", {}, "Against everything that was logged") : null,
    el("div", { class: "grid two" }, first.map(figureCard)),
    rest.length > 0 ? unfolding("channels", rest.length === 1 ? "1 more channel" : `${rest.length} more channels`, () => el("div", { class: "grid two" }, rest.map(figureCard))) : null,
    dependence ? unfolding("dependence", "Which delay explains most, and when the model fails at which frequency", () => figureCard(dependence)) : null,
  );
}

/** Drawn when it is unfolded. @param {string} key @param {string} title @param {() => HTMLElement} content */
function unfolding(key, title, content) {
  const details = el("details", { class: "more", "data-key": key }, el("summary", {}, title));
  details.addEventListener("toggle", () => {
    if (details.open && details.childElementCount === 1) details.append(content());
  });
  return details;
}
