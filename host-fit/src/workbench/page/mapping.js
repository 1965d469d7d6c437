// @ts-check
// Which column is what: the guesses of the server, to be confirmed or corrected.

import { el, icon, replace, uniqueId } from "./dom.js";

/** @typedef {import("./types.js").Preview} Preview */
/** @typedef {import("./types.js").ColumnPreview} PreviewColumn */
/** What a column is taken for; target null: kept under its own name; unit null: as its target says. @typedef {{column: PreviewColumn, target: string | null, unit: string | null}} Choice */

const TIME = "t_s";
/** Channels that a model can be of. */
const SENSOR = /^[ag][xyz]_/;
/** In place of a target. */
const LEFT_OUT = "!";

export class MappingTable {
  element = el("div", { class: "mapping" });
  /** Called when a choice changes. */
  changed = () => {};
  /** @type {Choice[]} */
  #choices = [];
  #rate = el("input", { type: "number", min: 0, step: "any", id: uniqueId("rate"), inputmode: "decimal" });
  #clash = el("p", { class: "clash", role: "alert" });
  #rateRow = el("p", { class: "rate" }, el("label", { for: this.#rate.id }, "There is no column of time. Sample rate, Hz "), this.#rate);

  /** Shows the columns of these files, each name once; nothing where all are as the log format has them and one is a sensor. @param {Preview[]} previews */
  show(previews) {
    const before = this.#choices;
    /** @type {Map<string, Choice>} */
    const choices = new Map();
    for (const column of previews.flatMap((preview) => preview.columns)) {
      const kept = before.find((choice) => choice.column.name === column.name);
      if (!choices.has(column.name)) choices.set(column.name, kept ?? { column, target: column.target, unit: column.unit });
    }
    this.#choices = [...choices.values()];
    const first = previews[0];
    const isStandard = this.#choices.every(({ column }) => column.spec === null && column.sure) && this.#hasTime() && this.hasSensor();
    if (!first || isStandard) return replace(this.element);
    const unsure = this.#choices.filter(({ column }) => !column.sure).length;
    const head = ["Column", "First values", "Is", "In", "Why"].map((text) => el("th", { scope: "col" }, text));
    replace(
      this.element,
      el("h2", {}, "What the columns are"),
      el("p", { class: "note" }, unsure > 0 ? `Guessed from names and values. ${unsure === 1 ? "One guess is" : `${unsure} guesses are`} unsure: look at ${unsure === 1 ? "it" : "them"} before reading.` : "Guessed from names and values."),
      this.#clash,
      el("div", { class: "scrolls", tabindex: 0, role: "region", "aria-label": "What the columns are" }, el("table", {}, el("thead", {}, el("tr", {}, head)), el("tbody", {}, this.#choices.map((choice) => this.#row(choice, first))))),
      this.#rateRow,
    );
    this.#check();
  }

  /** The column map, as fos takes it. */
  specs() {
    return this.#choices.flatMap(({ column, target, unit }) => {
      if (target === LEFT_OUT) return `!${column.name}`;
      if (target === column.target && unit === column.unit) return column.spec ?? [];
      if (target === null) return [];
      return unit === null ? `${target}=${column.quoted}` : `${target}=${column.quoted}:${unit}`;
    });
  }

  /** Sample rate, where no column says when, Hz. */
  rate() {
    return !this.#hasTime() && this.#rate.valueAsNumber > 0 ? this.#rate.valueAsNumber : null;
  }

  /** A column is a gyro or an accelerometer. */
  hasSensor() {
    return this.#choices.some(({ target, column }) => SENSOR.test(target ?? "") || (target === null && SENSOR.test(column.name)));
  }

  #hasTime() {
    return this.#choices.some(({ target }) => target === TIME);
  }

  /** @param {Choice} choice @param {Preview} preview */
  #row(choice, preview) {
    const { column } = choice;
    const targets = [...new Set([...preview.targets, ...(column.target ? [column.target] : [])])];
    const units = el("select", { "aria-label": `Unit of ${column.name}`, onchange: () => (choice.unit = units.value || null) });
    const drawUnits = () => {
      const known = (choice.target && preview.units[choice.target]) || [];
      const all = choice.unit && !known.includes(choice.unit) ? [choice.unit, ...known] : known;
      units.hidden = all.length === 0;
      units.replaceChildren(...all.map((unit) => el("option", { value: unit, selected: unit === choice.unit }, unit)));
    };
    const target = el(
      "select",
      {
        "aria-label": `What ${column.name} is`,
        onchange: () => {
          choice.target = target.value || null;
          choice.unit = choice.target === column.target ? column.unit : null;
          drawUnits();
          this.#check();
        },
      },
      el("option", { value: "", selected: choice.target === null }, "kept as it is"),
      el("option", { value: LEFT_OUT, selected: choice.target === LEFT_OUT }, "excluded"),
      targets.map((name) => el("option", { value: name, selected: name === choice.target }, name)),
    );
    drawUnits();
    return el(
      "tr",
      { "data-column": column.name, "data-sure": column.sure },
      el("th", { scope: "row" }, el("code", {}, column.name)),
      el("td", { class: "values" }, column.values.slice(0, 3).join(", ")),
      el("td", {}, target),
      el("td", {}, units),
      el("td", { class: "why" }, column.sure ? column.why : [el("span", { class: "unsure" }, icon("caution"), "unsure"), column.why ? `, ${column.why}` : ""]),
    );
  }

  /** Two columns cannot be one channel. */
  #check() {
    const targets = this.#choices.map(({ target }) => target).filter((target) => target !== null && target !== LEFT_OUT);
    const twice = [...new Set(targets.filter((target, at) => targets.indexOf(target) !== at))];
    this.#clash.textContent = twice.length > 0 ? `${twice.join(", ")} is chosen for two columns; the log can be read when it is one.` : "";
    this.#clash.hidden = twice.length === 0;
    this.#rateRow.hidden = this.#hasTime();
    this.changed();
  }
}
