// @ts-check
// Opens logs (dropped, chosen, by path, or the built-in example) and populations (by path).

import { get, messageOf, post, upload } from "./api.js";
import { el, replace, uniqueId } from "./dom.js";
import { bytes, fileName } from "./format.js";
import { MappingTable } from "./mapping.js";
import { alertElement } from "./notices.js";
import { populationAddress } from "./populationpage.js";

/** @typedef {import("./types.js").Preview} Preview */
/** @typedef {import("./types.js").Listed} LogEntry */
/** @typedef {"log" | "reference" | "evaluation" | "none"} Role */
/** A log that was picked. @typedef {{path: string, preview: Preview, role: Role}} Picked */
/** @typedef {import("./types.js").Page} Study */

/** @type {{role: Role, text: string}[]} */
const ROLES = [
  { role: "log", text: "the log to explain" },
  { role: "reference", text: "reference log (optional)" },
  { role: "evaluation", text: "evaluation log (optional)" },
  { role: "none", text: "not used" },
];
const MOST = 3;
/** Pause after a change before its cautions are requested, ms. */
const CAUTIONS_REST = 250;

export class OpenPanel {
  #opened;
  #problems = el("div", { class: "problems" });
  #progress = el("p", { class: "loading", role: "status", "aria-live": "polite" });
  #files = el("div", { class: "picked" });
  #paths = el("div", { class: "by-path" });
  #populations = el("div", { class: "by-path" });
  #mapping = new MappingTable();
  #chooser = el("input", { type: "file", multiple: true, class: "unseen", id: uniqueId("file"), accept: ".csv,.tsv,.txt,.gz,.parquet,.ulg,.bin,.cwa,.mcap,.bag,.zip", onchange: () => void this.take([...(this.#chooser.files ?? [])]) });
  #example = el("button", { type: "button", class: "primary large", onclick: () => void this.#open({ example: true }) }, "Open the example with a hidden effect");
  #read = el("button", { type: "button", class: "primary", onclick: () => void this.#readLogs() }, "Read the log");
  #reading = el("div", { class: "read", hidden: true });
  #unreadable = el("p", { class: "clash", role: "status", hidden: true }, "No column is a gyro or an accelerometer yet. Choose the columns and their units above.");
  /** @type {Picked[]} */
  #picked = [];
  #isBusy = false;
  #timer = 0;
  /** The study whose logs are read again; none while a new one is opened. @type {number | null} */
  #study = null;
  #intro;
  element;

  /** @param {(id: number) => void} opened */
  constructor(opened) {
    this.#opened = opened;
    const drop = el(
      "div",
      { class: "drop" },
      el("p", { class: "drop-title" }, "Drop a log here"),
      el("p", { class: "note" }, "CSV, Parquet, PX4 ULog, ArduPilot BIN, MCAP, a ROS bag, the zip of a phone app; one log, or up to three: the log to explain, a reference log and an evaluation log. Nothing leaves this machine."),
      el("p", {}, this.#chooser, el("label", { for: this.#chooser.id, class: "button" }, "Choose files")),
    );
    for (const kind of ["dragenter", "dragover"]) drop.addEventListener(kind, () => (drop.dataset.over = ""));
    for (const kind of ["dragleave", "drop"]) drop.addEventListener(kind, () => delete drop.dataset.over);
    this.#reading.append(this.#unreadable, this.#read);
    this.#mapping.changed = () => this.#mapped();
    this.#intro = el(
      "div",
      { class: "intro" },
      el("h1", { id: "opening-title" }, "Why does your sensor drift?"),
      el("p", { class: "lead" }, "Open a log of an accelerometer or gyro. fos fits a model of its error, shows where the model fails, and identifies the missing physical effect."),
      el("div", { class: "ways" }, drop, el("div", { class: "card example" }, el("h2", {}, "No log at hand?"), el("p", {}, "A simulated phone on a desk: the processor works, the phone warms up, and gyro x drifts because of an effect that the model does not contain."), this.#example, this.#paths, this.#populations)),
    );
    this.element = el(
      "section",
      { class: "opening", "aria-labelledby": "opening-title" },
      this.#intro,
      this.#problems,
      this.#progress,
      this.#files,
      this.#mapping.element,
      this.#reading,
    );
  }

  /** Shows the columns of a study, so that its logs can be read again. @param {number} id */
  async edit(id) {
    this.#study = id;
    const back = el("a", { href: `#/study/${id}` }, "Back to the study");
    replace(this.#intro, el("h1", { id: "opening-title" }, "Columns"), el("p", { class: "lead" }, back));
    this.#read.textContent = "Read the log again";
    this.#reading.prepend(el("p", { class: "note again" }, "All axes are fitted again. Added effects are removed."));
    this.#mapping.isAlwaysShown = true;
    try {
      const { name, files } = /** @type {Study} */ (await get(`/api/studies/${id}`));
      replace(this.#intro, el("h1", { id: "opening-title" }, `Columns of ${name}`), el("p", { class: "lead" }, back));
      if (!files) return this.#problem("The example is still being simulated.\nhelp: wait until the study shows its chart, then open its columns again");
      const { columns, rate_hz } = files.read;
      this.#mapping.setRate(rate_hz ?? null);
      for (const role of /** @type {const} */ (["log", "reference", "evaluation"])) {
        const path = files[role];
        if (path) this.#picked.push({ path, role, preview: await post("/api/preview", { path, columns }) });
      }
    } catch (error) {
      this.#problem(messageOf(error));
    }
    this.#draw();
  }

  /** Reads the lists of logs and populations again. */
  refresh() {
    get("/api/logs").then(
      (logs) => this.#drawPaths(logs),
      (error) => this.#problem(messageOf(error)),
    );
    get("/api/populations").then(
      (populations) => this.#drawPopulations(populations),
      (error) => this.#problem(messageOf(error)),
    );
  }

  /** Takes files that were dropped or chosen. @param {File[]} files */
  async take(files) {
    this.#chooser.value = "";
    const most = Math.max(MOST - this.#picked.length, 1);
    await this.#pick(files.slice(0, most), async (file) => {
      this.#say(`Sending ${file.name}, ${bytes(file.size)} …`);
      return (await upload(file)).path;
    });
    const left = files.slice(most).map((file) => file.name);
    if (left.length > 0) this.#problem(`Not opened: ${left.join(", ")}.\nhelp: a study has at most ${MOST} logs; open the others as another study`);
  }

  /**
   * Reads the columns of logs, one after the other; a file that is not a log is reported and skipped.
   * @template Given
   * @param {Given[]} all
   * @param {(given: Given) => Promise<string>} pathOf
   */
  async #pick(all, pathOf) {
    if (this.#isBusy) return;
    this.#isBusy = true;
    replace(this.#problems);
    for (const one of all) {
      try {
        const path = await pathOf(one);
        this.#say(`Reading the columns of ${fileName(path)} …`);
        const preview = /** @type {Preview} */ (await post("/api/preview", { path }));
        const free = ROLES.find(({ role }) => !this.#picked.some((picked) => picked.role === role));
        this.#picked = [...this.#picked.filter((picked) => picked.path !== path), { path, preview, role: free?.role ?? "none" }];
      } catch (error) {
        this.#problem(messageOf(error));
      }
    }
    this.#isBusy = false;
    this.#say("");
    this.#draw();
    if (this.#picked.length > 0) this.#read.focus();
  }

  /** @param {LogEntry[]} logs */
  #drawPaths(logs) {
    if (logs.length === 0) return replace(this.#paths);
    const id = uniqueId("path");
    const select = el("select", { id, "data-key": "path" }, logs.map(({ path, bytes: size }) => el("option", { value: path }, `${path} (${bytes(size)})`)));
    const open = el("button", { type: "button", "data-key": "take-path", onclick: () => void this.#pick([select.value], async (path) => path) }, "Use this log");
    replace(this.#paths, el("h2", {}, el("label", { for: id }, "A log on this machine")), el("div", { class: "row" }, select, open));
  }

  /** @param {LogEntry[]} populations */
  #drawPopulations(populations) {
    if (populations.length === 0) return replace(this.#populations);
    const id = uniqueId("population");
    const select = el("select", { id, "data-key": "population" }, populations.map(({ path }) => el("option", { value: path }, path)));
    const open = () => (location.hash = populationAddress(select.value));
    replace(this.#populations, el("h2", {}, el("label", { for: id }, "A population on this machine")), el("div", { class: "row" }, select, el("button", { type: "button", "data-key": "open-population", onclick: open }, "Open population")));
  }

  #draw() {
    const picked = this.#picked;
    const entry = (/** @type {Picked} */ one) => {
      const id = uniqueId("role");
      const change = (/** @type {Event} */ event) => {
        const role = /** @type {Role} */ (/** @type {HTMLSelectElement} */ (event.target).value);
        for (const other of picked) if (other.role === role && role !== "none") other.role = one.role;
        one.role = role;
        this.#draw();
      };
      return el(
        "li",
        {},
        el("label", { for: id }, fileName(one.path)),
        el("select", { id, "data-key": `role:${one.path}`, onchange: change }, ROLES.map(({ role, text }) => el("option", { value: role, selected: role === one.role }, text))),
        el("button", { type: "button", class: "quiet", "data-key": `drop:${one.path}`, "aria-label": `Remove ${fileName(one.path)}`, onclick: () => this.#leaveOut(one) }, "Remove"),
      );
    };
    replace(this.#files, picked.length > 0 ? [el("h2", {}, "Roles of the files"), el("ul", {}, picked.map(entry))] : null);
    this.#mapping.show(picked.map(({ preview }) => preview));
    this.#reading.hidden = !picked.some(({ role }) => role === "log");
    this.#sayReadable();
  }

  /** Takes a change of the columns; the server knows which values are impossible in the chosen units. */
  #mapped() {
    this.#sayReadable();
    clearTimeout(this.#timer);
    if (!this.#mapping.hasProblem) this.#timer = window.setTimeout(() => void this.#readCautions(), CAUTIONS_REST);
  }

  async #readCautions() {
    const columns = this.#mapping.specs();
    try {
      /** @type {Preview[]} */
      const previews = [];
      for (const { path } of this.#picked) previews.push(await post("/api/preview", { path, columns }));
      if (columns.join() === this.#mapping.specs().join()) this.#mapping.setCautions(previews);
    } catch (error) {
      this.#mapping.setProblem(messageOf(error));
    }
  }

  /** A log without a gyro or accelerometer cannot be read; its columns have to be chosen first. */
  #sayReadable() {
    const isReadable = this.#mapping.hasSensor();
    this.#read.setAttribute("aria-disabled", String(!isReadable));
    this.#unreadable.hidden = isReadable;
  }

  /** @param {Picked} one */
  #leaveOut(one) {
    this.#picked = this.#picked.filter((picked) => picked !== one);
    const [first] = this.#picked;
    if (first && !this.#picked.some(({ role }) => role === "log")) first.role = "log";
    this.#draw();
  }

  async #readLogs() {
    const path = (/** @type {Role} */ role) => this.#picked.find((picked) => picked.role === role)?.path ?? null;
    const log = path("log");
    if (!log || !this.#mapping.hasSensor()) return;
    await this.#open({ log, reference: path("reference"), evaluation: path("evaluation"), columns: this.#mapping.specs(), rate_hz: this.#mapping.rate() });
  }

  /** @param {import("./types.js").Wanted} study */
  async #open(study) {
    if (this.#isBusy) return;
    this.#isBusy = true;
    replace(this.#problems);
    this.#say("Opening …");
    try {
      const { id } = await post(this.#study === null ? "/api/studies" : `/api/studies/${this.#study}/logs`, study);
      this.#opened(id);
    } catch (error) {
      this.#problem(messageOf(error));
    }
    this.#isBusy = false;
    this.#say("");
  }

  /** @param {string} text */
  #say(text) {
    this.#progress.textContent = text;
  }

  /** @param {string} message */
  #problem(message) {
    const alert = alertElement(message, () => alert.remove());
    this.#problems.append(alert);
    this.#problems.scrollIntoView({ block: "nearest" });
  }
}
