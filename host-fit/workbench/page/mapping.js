// @ts-check
// The meaning of each column: guesses of the server, to be confirmed or corrected.

import { el, icon, replace, uniqueId } from "./dom.js";

/** @typedef {import("./types.js").Preview} Preview */
/** @typedef {import("./types.js").ColumnPreview} PreviewColumn */
/** The meaning of a column; target null: kept under its own name; unit null: the unit of its target. @typedef {{column: PreviewColumn, target: string | null, unit: string | null, arithmetic: string}} Choice */

const TIME = "t_s";
/** Channels that can have a model. */
const SENSOR = /^[ag][xyz]_/;
/** Target of a column that is excluded. */
const LEFT_OUT = "!";
/** Scale and offset of a column map: a chain of operations from left to right. */
const ARITHMETIC = /^([+\-*/]\s*\d+(\.\d*)?(e[+-]?\d+)?\s*)*$/i;

export class MappingTable {
  element = el("div", { class: "mapping" });
  /** Called when a choice changes. */
  changed = () => {};
  /** Shows the table also where every column has a name of the log format. */
  isAlwaysShown = false;
  /** @type {Choice[]} */
  #choices = [];
  #rate = el("input", { type: "number", min: 0, step: "any", id: uniqueId("rate"), inputmode: "decimal" });
  #clash = el("p", { class: "clash", role: "alert" });
  #impossible = el("p", { class: "values-caution", role: "status" });
  /** Cautions by column. @type {Map<string, HTMLElement>} */
  #cautions = new Map();
  #rateRow = el("p", { class: "rate" }, el("label", { for: this.#rate.id }, "There is no column of time. Sampling rate, Hz "), this.#rate);

  /** Shows the columns of these files, each name once; nothing if all have names of the log format and one is a sensor. @param {Preview[]} previews */
  show(previews) {
    const before = this.#choices;
    /** @type {Map<string, Choice>} */
    const choices = new Map();
    for (const column of previews.flatMap((preview) => preview.columns)) {
      const kept = before.find((choice) => choice.column.name === column.name);
      const target = column.spec?.startsWith("!") ? LEFT_OUT : column.target;
      if (!choices.has(column.name)) choices.set(column.name, kept ?? { column, target, unit: column.unit, arithmetic: column.arithmetic ?? "" });
    }
    this.#choices = [...choices.values()];
    this.#cautions.clear();
    const first = previews[0];
    const isStandard = this.#choices.every(({ column }) => column.spec === null && column.sure && column.caution === null) && this.#hasTime() && this.hasSensor();
    if (!first || (isStandard && !this.isAlwaysShown)) return replace(this.element);
    const unsure = this.#choices.filter(({ column }) => !column.sure).length;
    const head = ["Column", "First values", "Is", "Scale and offset", "In", "Why"].map((text) => el("th", { scope: "col" }, text));
    replace(
      this.element,
      el("h2", {}, "Columns"),
      el("p", { class: "note" }, unsure > 0 ? `Guessed from names and values. ${unsure === 1 ? "One guess is" : `${unsure} guesses are`} unsure: look at ${unsure === 1 ? "it" : "them"} before reading.` : "Guessed from names and values.", " For raw counts enter scale and offset as in the data sheet, applied from left to right: ", el("code", {}, "-32768*0.061"), " with the unit mdps subtracts 32768 and multiplies by 0.061."),
      this.#clash,
      this.#impossible,
      el("div", { class: "scrolls", tabindex: 0, role: "region", "aria-label": "Columns" }, el("table", {}, el("thead", {}, el("tr", {}, head)), el("tbody", {}, this.#choices.map((choice) => this.#row(choice, first))))),
      this.#rateRow,
    );
    this.#sayImpossible();
    this.#check();
  }

  /** The column map, as on the command line. */
  specs() {
    return this.#choices.flatMap(({ column, target, unit, arithmetic }) => {
      if (target === LEFT_OUT) return `!${column.name}`;
      if (target === column.target && unit === column.unit && arithmetic === (column.arithmetic ?? "")) return column.spec ?? [];
      if (target === null) return [];
      return [`${target}=${column.quoted}`, arithmetic, unit].filter((part) => part).join(":");
    });
  }

  /** @param {number | null} rate sampling rate of logs without a column of time, Hz */
  setRate(rate) {
    this.#rate.value = rate === null ? "" : String(rate);
  }

  /** Shows the cautions of columns as they are mapped now. @param {Preview[]} previews */
  setCautions(previews) {
    for (const [name, place] of this.#cautions) {
      const caution = previews.flatMap(({ columns }) => columns).find((column) => column.name === name && column.caution)?.caution ?? null;
      drawCaution(place, caution);
    }
    this.#sayImpossible();
  }

  /** Names the columns with a caution above the table, whose cautions are out of view on a narrow screen. */
  #sayImpossible() {
    const columns = [...this.#cautions].filter(([, place]) => place.textContent !== "").map(([name]) => name);
    drawCaution(this.#impossible, columns.length > 0 ? `Values that are impossible in their unit: ${columns.join(", ")}` : null);
  }

  get hasProblem() {
    return !this.#clash.hidden;
  }

  /** Shows why the column map cannot be used. @param {string} message */
  setProblem(message) {
    this.#clash.textContent = message.split(/\n?^help: /m).join(": ");
    this.#clash.hidden = false;
  }

  /** Sampling rate of a log without a column of time, Hz. */
  rate() {
    return !this.#hasTime() && this.#rate.valueAsNumber > 0 ? this.#rate.valueAsNumber : null;
  }

  /** True if a column is a gyro or an accelerometer. */
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
    const units = el("select", { "aria-label": `Unit of ${column.name}`, onchange: () => chooseUnit(units.value || null) });
    const chooseUnit = (/** @type {string | null} */ unit) => {
      choice.unit = unit;
      this.#check();
    };
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
    const arithmetic = el("input", {
      type: "text",
      class: "arithmetic",
      "aria-label": `Scale and offset of ${column.name}`,
      placeholder: "none",
      value: choice.arithmetic,
      spellcheck: "false",
      oninput: () => {
        choice.arithmetic = arithmetic.value.replace(/\s/g, "");
        this.#check();
      },
    });
    const caution = el("span", { class: "values-caution", role: "status" });
    drawCaution(caution, column.caution);
    this.#cautions.set(column.name, caution);
    return el(
      "tr",
      { "data-column": column.name, "data-sure": column.sure },
      el("th", { scope: "row" }, el("code", {}, column.name)),
      el("td", { class: "values" }, column.values.slice(0, 3).join(", ")),
      el("td", {}, target),
      el("td", {}, column.values.length > 0 ? arithmetic : null),
      el("td", {}, units),
      el("td", { class: "why" }, column.sure ? column.why : [el("span", { class: "unsure" }, icon("caution"), "unsure"), column.why ? `, ${column.why}` : ""], caution),
    );
  }

  /** Two columns cannot be one channel. */
  #check() {
    const targets = this.#choices.map(({ target }) => target).filter((target) => target !== null && target !== LEFT_OUT);
    const twice = [...new Set(targets.filter((target, at) => targets.indexOf(target) !== at))];
    const unreadable = this.#choices.find(({ arithmetic }) => !ARITHMETIC.test(arithmetic));
    const problems = [
      twice.length > 0 && `${twice.join(", ")} is chosen for two columns: choose one.`,
      unreadable && `${unreadable.column.name}: "${unreadable.arithmetic}" is not scale and offset: write + - * / with numbers, as in -32768*0.061.`,
    ].filter((problem) => problem);
    this.#clash.textContent = problems.join(" ");
    this.#clash.hidden = problems.length === 0;
    this.#rateRow.hidden = this.#hasTime();
    this.changed();
  }
}

/** @param {HTMLElement} place @param {string | null} caution */
function drawCaution(place, caution) {
  if (place.textContent === (caution ?? "")) return;
  replace(place, caution === null ? null : [icon("caution"), caution]);
}
