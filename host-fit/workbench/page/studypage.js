// @ts-check
// One study: its five parts and their shared state.

import { addressOf, columnsAddress, placeOf } from "./address.js";
import { messageOf, post } from "./api.js";
import { axesTable } from "./axestable.js";
import { el, icon, radioGroup, replace } from "./dom.js";
import { follow } from "./follow.js";
import { capitalised, count, duration, fileName, percent } from "./format.js";
import { alertElement, needsMovedRows } from "./notices.js";
import { failsPart } from "./parts/fails.js";
import { fallsPart } from "./parts/falls.js";
import { measuredPart } from "./parts/measured.js";
import { missingPart } from "./parts/missing.js";
import { takePart } from "./parts/take.js";
import { SeriesSource } from "./seriessource.js";
import { TimeWindow } from "./timewindow.js";
import { system, unitSwitch } from "./units.js";
import { OUTCOMES } from "./verdict.js";

/** @typedef {import("./types.js").Page} State */
/** @typedef {import("./types.js").AxisPage} AxisState */
/** @typedef {import("./types.js").ViewKind} ViewName */
/** A stretch that every panel shows; mark: its number among the worst. @typedef {{from: number, to: number, mark: string | null}} Chosen */
/** State drawn by the parts; mean: averaging time, s, null follows the zoom. @typedef {{state: State, axis: AxisState | null, chosen: Chosen | null, view: ViewName, mean: number | null, units: import("./units.js").System}} Scene */
/** @typedef {{element: HTMLElement, update: (scene: Scene) => void}} Part */
/**
 * Shared by the parts.
 * @typedef {object} Context
 * @property {number} study
 * @property {TimeWindow} time
 * @property {SeriesSource} source
 * @property {(chosen: Chosen | null) => void} choose
 * @property {(view: ViewName) => void} setView
 * @property {(mean: number | null) => void} setMean
 * @property {(path: string, body?: unknown) => Promise<boolean>} change posts to the server and shows an error
 * @property {(text: string) => void} announce
 * @property {(part: number, focus?: boolean) => void} goTo
 * @property {(part: number) => void} stayAt scrolls to a part and keeps it in view while others change
 */
/** @typedef {{notices: import("./notices.js").Notices, changed: (state: State) => void, connected: (connected: boolean) => void, gone: () => void}} Surroundings */

/** Pause between changes of the address, ms: a browser refuses more than a few per second. */
const ADDRESS_REST = 300;
/** @type {ViewName[]} */
const VIEWS = ["slow", "coast", "one_step"];

const STEPS = ["Measured", "Fails", "Missing", "Result", "Export"];

export class StudyPage {
  /** @type {number} */
  id;
  element;
  #around;
  #time = new TimeWindow();
  #source = new SeriesSource(this.#time);
  #head = el("div", { class: "study-head" });
  #error = el("div", { class: "study-error" });
  #axes = el("div", { class: "axes-place" });
  #bar = el("div", { class: "sub-bar" });
  #said = el("p", { class: "unseen", role: "status", "aria-live": "polite" });
  #reading = el("div", { class: "reading" });
  #parts = el("div", { class: "parts" });
  /** @type {Part[]} */
  #all;
  #following;
  /** @type {State | null} */
  #state = null;
  /** @type {string | null} */
  #axis = null;
  /** @type {Chosen | null} */
  #chosen = null;
  /** @type {ViewName} */
  #view = "slow";
  /** @type {number | null} */
  #mean = null;
  /** Place of the address that is not shown yet. @type {import("./address.js").Place | null} */
  #wanted;
  #addressTimer = 0;
  /** The part that stays in view until its computation ends or the user scrolls. @type {number | null} */
  #anchored = null;
  #log = "";
  /** @type {Map<string, string>} */
  #drawn = new Map();

  /** @param {number} id @param {Surroundings} around */
  constructor(id, around) {
    this.id = id;
    this.#around = around;
    this.#wanted = placeOf(location.hash);
    this.#view = viewOf(this.#wanted);
    this.#source.failed = (error) => around.notices.show(messageOf(error));
    const context = this.#context();
    this.#all = [measuredPart(context), failsPart(context), missingPart(context), fallsPart(context), takePart(context)];
    this.#parts.append(...this.#all.map((part) => part.element));
    this.element = el("div", { class: "study" }, this.#head, this.#error, this.#reading, this.#axes, this.#bar, this.#parts, this.#said);
    for (const kind of ["wheel", "touchmove", "keydown", "pointerdown"]) this.element.addEventListener(kind, () => (this.#anchored = null), { passive: true });
    this.#time.onChange(() => this.#writeAddress());
    this.#following = follow(id, {
      state: (state) => this.#update(state),
      connected: around.connected,
      gone: around.gone,
      failed: (error) => around.notices.show(messageOf(error)),
    });
    replace(this.#reading, waiting("Opening the study"));
    this.#bar.hidden = true;
    this.#parts.hidden = true;
  }

  /** Shows another place of this study; an address without a place changes nothing. @param {string} hash */
  visit(hash) {
    clearTimeout(this.#addressTimer);
    const place = placeOf(hash);
    if (Object.values(place).every((part) => part === null)) return this.#writeAddress();
    this.#wanted = place;
    this.#view = viewOf(place);
    this.#chosen = null;
    if (!place.window) this.#time.showAll();
    if (this.#state) this.#goToWanted(this.#state);
    this.#draw();
  }

  close() {
    clearTimeout(this.#addressTimer);
    this.#following.close();
    this.#source.look(null);
  }

  /** @returns {Context} */
  #context() {
    return {
      study: this.id,
      time: this.#time,
      source: this.#source,
      choose: (chosen) => {
        this.#chosen = chosen;
        if (chosen) this.#time.showAround(chosen.from, chosen.to);
        else this.#time.showAll();
        this.#draw();
      },
      setView: (view) => {
        this.#view = view;
        this.#draw();
      },
      setMean: (mean) => {
        this.#mean = mean;
        this.#draw();
      },
      change: (path, body) => this.#change(path, body),
      announce: (text) => (this.#said.textContent = text),
      goTo: (part, focus = true) => this.#goTo(part, focus),
      stayAt: (part) => {
        this.#goTo(part, true);
        this.#anchored = part;
      },
    };
  }

  /** @param {string} column */
  #look(column) {
    if (column === this.#axis) return;
    this.#axis = column;
    this.#chosen = null;
    void this.#change("axis", { axis: column });
    this.#draw();
  }

  /** Shows axis, stretch and window of the address once the log is read. @param {State} state */
  #goToWanted(state) {
    const wanted = this.#wanted;
    if (!wanted || !state.logs) return;
    this.#wanted = null;
    // another axis clears the chosen stretch
    if (state.axes.some(({ column }) => column === wanted.axis) && wanted.axis !== state.axis) this.#look(wanted.axis ?? "");
    if (wanted.stretch) {
      const [from, to] = wanted.stretch;
      this.#chosen = { from, to, mark: null };
    }
    if (wanted.window) this.#time.show(...wanted.window);
  }

  #writeAddress() {
    clearTimeout(this.#addressTimer);
    this.#addressTimer = window.setTimeout(() => {
      if (this.#wanted || !this.element.isConnected) return;
      const chosen = this.#chosen;
      const address = addressOf(this.id, {
        axis: this.#axis,
        view: this.#view === "slow" ? null : this.#view,
        window: this.#time.isWhole ? null : this.#time.shown,
        stretch: chosen && [chosen.from, chosen.to],
      });
      if (location.hash !== address) history.replaceState(null, "", address);
    }, ADDRESS_REST);
  }

  /** @param {string} path @param {unknown} [body] */
  async #change(path, body) {
    try {
      await post(`/api/studies/${this.id}/${path}`, body);
      await this.#following.refresh();
      return true;
    } catch (error) {
      this.#around.notices.show(messageOf(error));
      return false;
    }
  }

  /** @param {number} part @param {boolean} focus */
  #goTo(part, focus) {
    this.#anchored = null;
    const heading = this.#all[part - 1]?.element.querySelector("h2");
    if (focus) heading?.focus({ preventScroll: true });
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    heading?.scrollIntoView({ behavior: calm ? "auto" : "smooth", block: "start" });
  }

  /** @param {State} state */
  #update(state) {
    // a finished computation is no longer announced
    if (this.#state?.job && !state.job) this.#said.textContent = "";
    this.#state = state;
    const field = state.logs?.log;
    const log = field ? `${field.sha256} ${field.from_s} ${field.to_s}` : "";
    if (field && log !== this.#log) {
      this.#log = log;
      this.#time.reset([field.from_s, field.to_s], 1 / field.rate_hz);
    }
    this.#axis = state.axis ?? this.#axis ?? state.axes[0]?.column ?? null;
    this.#around.changed(state);
    this.#goToWanted(state);
    this.#draw();
    if (this.#anchored !== null) {
      this.#all[this.#anchored - 1]?.element.querySelector("h2")?.scrollIntoView({ behavior: "auto", block: "start" });
      if (!state.job?.asked_for) this.#anchored = null;
    }
  }

  #draw() {
    const state = this.#state;
    if (!state) return;
    const axis = state.axes.find(({ column }) => column === this.#axis) ?? null;
    this.#once("head", [state.name, state.logs, state.files], () => replace(this.#head, studyHead(state)));
    // viewing the axis again starts computations that were cancelled or failed
    const canGoOn = state.job === null && axis !== null && !axis.diagnosis;
    const error = state.error ?? axis?.failure ?? null;
    this.#once("error", [error, canGoOn, axis?.column], () => {
      const goOn = el("button", { type: "button", "data-key": "go-on", onclick: () => void this.#change("axis", { axis: axis?.column }) }, `Diagnose ${axis?.label}`);
      const include = el("button", { type: "button", "data-key": "include-moved", onclick: () => void this.#change("moved", { keep: true }) }, "Include these rows");
      replace(this.#error, error ? alertElement(error) : null, error && needsMovedRows(error) ? include : canGoOn ? goOn : null);
    });
    const isWorking = state.job !== null;
    this.#once("axes", [state.axes.map((one) => [one.column, one.standing, one.slow_error, one.failure, one.units, one.diagnosis?.findings.length]), this.#axis, isWorking, system()], () => {
      replace(this.#axes, state.axes.length > 0 ? axesTable(state.axes, this.#axis, isWorking, (column) => this.#look(column), unitSwitch(() => this.#draw())) : null);
    });
    this.#once("bar", [state.axes.map((one) => [one.column, one.label, one.standing?.outcome]), this.#axis], () => this.#drawBar(state));
    const isRead = state.logs !== null;
    this.#once("reading", [isRead, state.job?.what, state.error], () => {
      replace(this.#reading, isRead || state.error ? null : waiting(capitalised(state.job?.what ?? "reading the logs")));
    });
    this.#bar.hidden = !isRead;
    this.#parts.hidden = !isRead;
    if (!isRead) return;
    this.#source.look(axis ? { study: this.id, axis: axis.column, view: this.#view, mean: this.#mean, model: modelKey(axis) } : null);
    for (const part of this.#all) part.update({ state, axis, chosen: this.#chosen, view: this.#view, mean: this.#mean, units: system() });
    this.#writeAddress();
  }

  /** Draws a place only if its data changed, so that focus and selection stay. @param {string} name @param {unknown} data @param {() => void} draw */
  #once(name, data, draw) {
    const now = JSON.stringify(data);
    if (this.#drawn.get(name) === now) return;
    this.#drawn.set(name, now);
    draw();
  }

  /** @param {State} state */
  #drawBar(state) {
    const axes = radioGroup({
      legend: "Axis",
      name: "axis",
      class: "axes",
      options: state.axes.map(({ column, label, standing }) => ({
        value: column,
        text: label,
        hint: standing ? OUTCOMES[standing.outcome].word : undefined,
        extra: standing ? icon(standing.outcome) : null,
      })),
      chosen: this.#axis,
      choose: (column) => this.#look(column),
    });
    const step = (/** @type {string} */ name, /** @type {number} */ at) =>
      el("li", {}, el("button", { type: "button", class: "quiet", "data-key": `step:${at}`, onclick: () => this.#goTo(at + 1, true) }, el("b", {}, at + 1), el("span", {}, name)));
    replace(this.#bar, axes, el("nav", { "aria-label": "Parts" }, el("ol", { class: "steps" }, STEPS.map(step))));
  }
}

/** The view of a place. @param {import("./address.js").Place} place @returns {ViewName} */
const viewOf = ({ view }) => VIEWS.find((one) => one === view) ?? "slow";

/** Key that differs between two states of an axis' model. @param {AxisState} axis */
export function modelKey(axis) {
  return JSON.stringify([axis.model, axis.refinement?.steps.length ?? 0, axis.comparison?.errors ?? null]);
}

/** @param {string} what */
function waiting(what) {
  return el("div", { class: "waiting" }, el("p", {}, what), el("div", { class: "skeleton tall" }), el("div", { class: "skeleton" }));
}

/** @param {State} state */
function studyHead({ id, name, logs, files }) {
  const columns = files && el("a", { class: "button", "data-key": "columns", href: columnsAddress(id), title: "Change columns, units, scale, offset and roles of the logs" }, "Columns…");
  const title = el("div", { class: "study-title" }, el("h1", {}, name), columns);
  if (!logs) return title;
  const { log, reference, evaluation } = logs;
  const facts = [
    `${duration(log.seconds)} at ${Number(log.rate_hz.toFixed(2))} Hz`,
    `${count(log.rows)} rows`,
    log.segments > 1 ? `${log.segments} pieces, ${count(log.missing)} samples missing` : log.missing > 0 ? `${count(log.missing)} samples missing` : "no gaps",
    log.still_share === null ? null : `still for ${percent(log.still_share, 0)}`,
  ].filter((fact) => fact !== null);
  const other = (/** @type {string} */ role, /** @type {import("./types.js").LogSummary | null} */ one) =>
    one && el("span", {}, el("b", {}, role), ` ${fileName(one.path)}, ${duration(one.seconds)}`);
  return [
    title,
    el("p", { class: "facts" }, el("span", {}, el("b", {}, "Log to explain"), ` ${fileName(log.path)}, ${facts.join(", ")}`), other("Reference log", reference), other("Evaluated on", evaluation)),
    log.quality.length > 0
      ? el("details", { class: "log-quality", "data-key": "quality" }, el("summary", {}, `${log.quality.length === 1 ? "One remark" : `${log.quality.length} remarks`} on the data`), el("ul", {}, log.quality.map((text) => el("li", {}, text))))
      : null,
  ];
}
