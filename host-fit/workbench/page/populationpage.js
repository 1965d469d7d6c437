// @ts-check
// A population: scatter of the devices, odd devices, and one device compared with the others.

import { get, messageOf, post } from "./api.js";
import { el, radioGroup, replace, uniqueId } from "./dom.js";
import { UNKNOWN, capitalised, count, duration, isNumber, number, percent } from "./format.js";
import { figureElement } from "./figure.js";

/** @typedef {import("./types.js").PopulationPage} Population */
/** @typedef {import("./types.js").PartReport} Part */
/** @typedef {import("./types.js").CoefficientReport} Coefficient */
/** @typedef {import("./types.js").UnitPage} Unit */
/** @typedef {import("./types.js").UnitEntry} UnitEntry */
/** @typedef {import("./dom.js").Child} Child */
/** Which population, and which of its units. @typedef {{path: string, part: string | null, unit: string | null}} Address */
/** @typedef {{notices: import("./notices.js").Notices, opened: (study: number) => void}} Surroundings */

const START = "#/population?";

/** The population of the address. @param {string} hash @returns {Address | null} */
export function addressedPopulation(hash) {
  if (!hash.startsWith(START)) return null;
  const named = new URLSearchParams(hash.slice(START.length));
  const path = named.get("path");
  return path === null ? null : { path, part: named.get("part"), unit: named.get("unit") };
}

/** @param {string} path @param {{part: string, unit: string}} [unit] */
export function populationAddress(path, unit) {
  return START + String(new URLSearchParams({ path, ...(unit ? { part: unit.part, unit: unit.unit } : {}) }));
}

export class PopulationPage {
  path;
  element;
  #around;
  #head = el("div", { class: "study-head" });
  #parts = el("div", { class: "parts" });
  #unit = el("section", { class: "part unit", "aria-labelledby": "unit-title", hidden: true });
  #shown = "";

  /** @param {string} path @param {Surroundings} around */
  constructor(path, around) {
    this.path = path;
    this.#around = around;
    this.element = el("div", { class: "study population" }, this.#head, this.#unit, this.#parts);
    replace(this.#head, el("p", { class: "loading" }, "Reading the population …"));
    this.#ask(`/api/population?${new URLSearchParams({ path })}`, (/** @type {Population} */ found) => this.#draw(found));
  }

  /** Shows the unit of the address, or none. @param {Address} address */
  show({ part, unit }) {
    const wanted = unit === null ? "" : String(new URLSearchParams({ path: this.path, part: part ?? "", unit }));
    if (wanted === this.#shown) return;
    this.#shown = wanted;
    this.#unit.hidden = true;
    if (!wanted) return;
    this.#ask(`/api/population/unit?${wanted}`, (/** @type {Unit} */ found) => {
      if (wanted !== this.#shown) return; // another was chosen meanwhile
      this.#drawUnit(found);
    });
  }

  /** @template Found @param {string} at @param {(found: Found) => void} then */
  #ask(at, then) {
    get(at).then(then, (error) => {
      replace(this.#head, el("h1", {}, this.path));
      this.#around.notices.show(messageOf(error));
    });
  }

  /** @param {Population} population */
  #draw({ report, units }) {
    replace(this.#head, el("h1", {}, report.path), this.#chooser(units));
    replace(this.#parts, report.parts.flatMap((part) => this.#part(part)));
  }

  /** @param {UnitEntry[]} units */
  #chooser(units) {
    const id = uniqueId("unit");
    const select = el("select", { id, "data-key": "unit" }, units.map(({ part, unit, lot }, at) => el("option", { value: at }, [part, unit, lot && `lot ${lot}`].filter(Boolean).join(", "))));
    const open = () => {
      const chosen = units[Number(select.value)];
      if (chosen) location.hash = populationAddress(this.path, chosen);
    };
    return el("div", { class: "row" }, el("label", { for: id }, `One of ${count(units.length)} devices`), select, el("button", { type: "button", "data-key": "show-unit", onclick: open }, "Show device"));
  }

  /** @param {Part} part @returns {HTMLElement[]} */
  #part(part) {
    const { read } = part;
    // names of parts keep their lower case: bmi270
    const title = (/** @type {string} */ text) => (part.part ? `${part.part}: ${text}` : capitalised(text));
    return [
      titled(
        title("which devices were read"),
        el(
          "div",
          { class: "card" },
          el("p", {}, wordsOfRead(read)),
          part.cautions.map((caution) => el("p", {}, caution)),
          read.not_read.length === 0 ? null : table(title("devices with incomplete data"), ["device", "lot", "why"], read.not_read.map((unit) => [this.#link(part, unit.unit), unit.lot ?? "", [...unit.reasons, ...unit.help].map((line) => el("div", {}, line))]), 0),
          read.more > 0 ? el("p", { class: "note" }, `And ${count(read.more)} more.`) : null,
        ),
      ),
      titled(
        title("odd devices"),
        el(
          "div",
          { class: "card" },
          part.odd.length === 0
            ? el("p", {}, part.not_conclusive ?? "No device differs from the others.")
            : table(
                title("odd devices"),
                ["device", "lot", "axis", "most in", "off by, standard deviations", "its own log", "90 % of its lot", "p"],
                part.odd.map((odd) => [this.#link(part, odd.unit), odd.lot ?? "", odd.label, odd.coefficient, number(odd.by), odd.estimate ? `${about(odd.estimate)} ${odd.unit_of_size}` : UNKNOWN, odd.expected ? `${range(odd.expected)} ${odd.unit_of_size}` : UNKNOWN, number(odd.p_value)]),
                4,
              ),
        ),
      ),
      titled(title("how devices differ"), el("div", { class: "card" }, differences(part, title("scatter of devices and lots"))), ...figures(part)),
      ...shipped(part, title("effects by axis")).map((shares) => titled(title("effects of the part"), el("div", { class: "card" }, shares))),
    ];
  }

  /** @param {Part} part @param {string} unit */
  #link({ part }, unit) {
    return el("a", { href: populationAddress(this.path, { part, unit }), "data-key": `unit:${part}:${unit}` }, unit);
  }

  /** @param {Unit} found */
  #drawUnit({ report, log }) {
    const rows = report.axes.flatMap((axis) => axis.coefficients.map((one) => [axis.label, one.name, one.own ? about(one.own) : UNKNOWN, about(one.expected), about(one.together), one.unit, isNumber(one.by) ? number(one.by) : UNKNOWN]));
    const effects = report.axes.filter((axis) => axis.effects.length > 0).map((axis) => `${axis.label}: ${axis.effects.join(", ")}`);
    const facts = [
      report.lot ? `lot ${report.lot}` : "",
      isNumber(report.seconds) ? `a log of ${duration(report.seconds)}` : "",
      report.temperature_c ? `${range(report.temperature_c)} °C` : "",
      report.is_odd ? "odd" : "",
    ].filter(Boolean);
    const open = el("button", { type: "button", class: "primary", "data-key": "open-log", onclick: () => void this.#open(log ?? "") }, "Open its log");
    replace(
      this.#unit,
      el("header", { class: "part-head" }, el("div", {}, el("h2", { id: "unit-title", tabindex: -1 }, `Device ${report.unit}`), el("p", { class: "question" }, facts.join(", ")))),
      el(
        "div",
        { class: "card" },
        report.failed.flatMap((reason) => reason.split("\n")).map((line) => el("p", {}, line)),
        rows.length === 0 ? null : table("The device and its population", ["axis", "coefficient", "its own log", "expected from its lot", "both combined", "unit", "off by, standard deviations"], rows, 2),
        rows.length === 0 ? null : el("p", { class: "note" }, "Each value is given with half of its 90 % interval. A device of the population is part of both estimates: its own log also counts in the population."),
        effects.length === 0 ? null : el("p", {}, `Effects that were found: ${effects.join("; ")}.`),
        log ? el("p", {}, open, ` ${log}`) : el("p", { class: "note" }, "Its log is not in a folder that may be read here, or has changed."),
      ),
    );
    this.#unit.hidden = false;
    this.#unit.scrollIntoView({ block: "start" });
    this.#unit.querySelector("h2")?.focus({ preventScroll: true });
  }

  /** @param {string} log */
  async #open(log) {
    try {
      this.#around.opened((await post("/api/studies", { log })).id);
    } catch (error) {
      this.#around.notices.show(messageOf(error));
    }
  }
}

/** How many devices were read, and how completely. @param {Part["read"]} read */
function wordsOfRead({ units, lots, whole, partly, nothing }) {
  const devices = (/** @type {number} */ one) => `${count(one)} ${one === 1 ? "device" : "devices"}`;
  const incomplete = [partly > 0 ? ` Some axes of ${devices(partly)} were read.` : "", nothing > 0 ? ` No axis of ${devices(nothing)} was read.` : ""];
  return `${devices(units)} in ${count(lots)} ${lots === 1 ? "lot" : "lots"}. All axes of ${devices(whole)} were read.${incomplete.join("")}`;
}

/** @param {string} title @param {...HTMLElement} children */
function titled(title, ...children) {
  const id = uniqueId("part");
  return el("section", { class: "part", "aria-labelledby": id }, el("header", { class: "part-head" }, el("h2", { id, tabindex: -1 }, title)), children);
}

/**
 * @param {string} label @param {string[]} head @param {(Child | Child[])[][]} rows
 * @param {number} words so many columns are of words, the others of numbers
 */
function table(label, head, rows, words = head.length) {
  const side = (/** @type {number} */ at) => (words > 0 && at >= words ? "right" : null);
  const row = (/** @type {(Child | Child[])[]} */ cells) => el("tr", {}, cells.map((cell, at) => (at === 0 ? el("th", { scope: "row" }, cell) : el("td", { class: side(at) }, cell))));
  return el("div", { class: "scrolls", tabindex: 0, role: "region", "aria-label": label }, el("table", {}, el("thead", {}, el("tr", {}, head.map((name, at) => el("th", { scope: "col", class: side(at) }, name)))), el("tbody", {}, rows.map(row))));
}

/** @param {[number, number]} valueAndHalf */
const about = ([value, half]) => `${number(value)} ± ${number(half)}`;

/** @param {[number, number]} ends */
const range = ([low, high]) => `${number(low)} to ${number(high)}`;

/** @param {Part} part @param {string} label */
function differences({ axes }, label) {
  const row = (/** @type {string} */ label, /** @type {Coefficient} */ one) => {
    // a value too small to matter beside its uncertainty and scatter is 0, so that one notation is enough
    const scale = Math.max(one.mean_interval[1] - one.mean_interval[0], one.between_units, one.error_of_log);
    const write = (/** @type {number} */ value) => number(Math.abs(value) < 0.01 * scale ? 0 : value);
    const from = (/** @type {number} */ value, /** @type {[number, number]} */ [low, high]) => `${write(value)} (${write(low)} to ${write(high)})`;
    return [
      label,
      one.name,
      one.unit,
      count(one.units),
      from(one.mean, one.mean_interval),
      from(one.between_units, one.between_units_interval),
      isNumber(one.between_lots) ? from(one.between_lots, one.between_lots_interval) : UNKNOWN,
      write(one.error_of_log),
      number(one.lots_alike),
    ];
  };
  const rows = axes.flatMap((axis) => axis.coefficients.map((one) => row(axis.label, one)));
  const without = axes.filter((axis) => axis.without).map((axis) => el("p", {}, `${capitalised(axis.label)}: ${axis.without}`));
  return [
    table(label, ["axis", "coefficient", "unit", "devices", "mean", "between devices", "between lots", "error of a log", "lots alike, p"], rows, 3),
    el("p", { class: "note" }, "Standard deviations, with their 90 % intervals. Lots alike: probability of such a difference between lots that do not differ."),
    ...without,
  ];
}

/** The figures of the chosen axis. @param {Part} part */
function figures({ part, axes, variance }) {
  const drawn = axes.filter((axis) => axis.coefficients.length > 0);
  if (drawn.length === 0) return [];
  const host = el("div", {});
  const show = (/** @type {string} */ column) => {
    const axis = drawn.find((one) => one.column === column);
    const cautioned = (/** @type {Coefficient} */ one) => el("div", { class: "card" }, figureElement(one.figure), one.cautions.length > 0 ? el("p", {}, `Caution: ${one.cautions.join(" ")}`) : null);
    replace(host, (axis?.coefficients ?? []).map(cautioned));
  };
  const first = /** @type {typeof drawn[number]} */ (drawn[0]);
  show(first.column);
  return [
    ...(variance ? [el("div", { class: "card" }, figureElement(variance))] : []),
    radioGroup({ legend: "Axis", name: uniqueId(`axis-${part}`), options: drawn.map(({ column, label }) => ({ value: column, text: label })), chosen: first.column, choose: show }),
    host,
  ];
}

/** @param {Part} part @param {string} label @returns {HTMLElement[]} */
function shipped({ axes }, label) {
  const rows = axes.flatMap((axis) => axis.effects.map((one) => [axis.label, one.effect, one.device, `${count(one.units[0])} of ${count(one.units[1])}`, `${percent(one.share_interval[0])} to ${percent(one.share_interval[1])}`, percent(one.mean_reduction)]));
  return rows.length === 0 ? [] : [table(label, ["axis", "effect", "costs on the device", "devices that have it", "share of the part, 90 %", "reduction of the error if all models had it"], rows, 3)];
}
