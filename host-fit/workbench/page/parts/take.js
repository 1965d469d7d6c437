// @ts-check
// Part 5: the model as files, the result of the exported image, and the equivalent commands.

import { get, messageOf } from "../api.js";
import { el, icon, replace } from "../dom.js";
import { count, fileName } from "../format.js";
import { alertElement } from "../notices.js";
import { modelKey } from "../studypage.js";
import { chosen, inUnit, system } from "../units.js";
import { section } from "./section.js";

/** @typedef {import("../studypage.js").Context} Context */
/** @typedef {import("../studypage.js").Scene} Scene */
/** @typedef {import("../types.js").Replayed} Replay */
/** @typedef {import("../types.js").Hubs} Hubs */

const FORMATS = [
  { format: "image", name: "Model image", says: "What a device stores and runs" },
  { format: "rust", name: "Rust source", says: "A constant, checked when it is compiled" },
  { format: "c", name: "C header", says: "The image, with a check for start-up" },
  { format: "report.html", name: "Report, HTML", says: "One file, with every figure" },
  { format: "report.md", name: "Report, Markdown", says: "For a repository" },
  { format: "study", name: "Study", says: "To continue with fos" },
];

/** @param {Context} context @returns {import("../studypage.js").Part} */
export function takePart({ study, announce }) {
  const downloads = el("ul", { class: "downloads" });
  const refusal = el("div", { class: "refusal" });
  const numbers = el("div", { class: "replay" });
  const commands = el("div", { class: "commands" });
  const element = section(
    5,
    "Downloads",
    "The model for the device, the report for people, the commands for scripts.",
    el("div", { class: "card" }, refusal, downloads),
    el("div", { class: "card" }, el("h3", {}, "Result of the exported image"), numbers),
    el("div", { class: "card" }, el("h3", {}, "The same on a command line"), commands),
  );
  let drawn = "";
  let asked = "";
  let request = new AbortController();

  /** Shows before the download which hubs refuse the image. @param {AbortSignal} signal */
  async function readRefusal(signal) {
    const said = /** @type {Hubs} */ (await get(`/api/studies/${study}/hubs`, signal)).refusal;
    if (!signal.aborted) replace(refusal, said === null ? null : alertElement(said));
  }

  /** @param {Scene} scene */
  async function readReplay({ state }) {
    const modelled = state.axes.filter((axis) => axis.model);
    if (modelled.length === 0) {
      asked = "";
      replace(refusal);
      return replace(numbers, el("p", { class: "empty" }, state.job?.what ? `The models are being fitted: ${state.job.what} …` : "There is no model to export yet."));
    }
    const key = JSON.stringify([modelled.map((axis) => [axis.column, modelKey(axis)]), system()]);
    if (key === asked) return;
    // numbers of another model must not be shown for this one
    replace(numbers, el("p", { class: "loading" }, "Running the image over the log, as a device does …"));
    request.abort();
    replace(refusal);
    if (!isReady(state)) return;
    asked = key;
    request = new AbortController();
    const { signal } = request;
    numbers.setAttribute("aria-busy", "true");
    try {
      await readRefusal(signal);
      const replay = /** @type {Replay} */ (await get(`/api/studies/${study}/replay`, signal));
      if (!signal.aborted) drawReplay(numbers, replay, state, announce);
    } catch (error) {
      if (signal.aborted) return;
      asked = "";
      replace(numbers, alertElement(messageOf(error)));
    }
    numbers.removeAttribute("aria-busy");
  }

  return {
    element,
    update(scene) {
      const { state } = scene;
      const hasModel = state.axes.some((axis) => axis.model);
      const now = JSON.stringify([hasModel, isReady(state), state.is_turned, state.commands]);
      if (now !== drawn) {
        drawn = now;
        const files = FORMATS.map(({ format, name, says }) => download(study, format, name, hasModel ? says : "when there is a model", isReady(state)));
        replace(downloads, state.is_turned ? [...files, certificate(study)] : files);
        replace(commands, state.commands.length > 0 ? state.commands.map((command, at) => commandElement(command, `command:${at}`, announce)) : el("p", { class: "empty" }, "The commands appear when the first axis is fitted."));
      }
      void readReplay(scene);
    },
  };
}

/** True if every axis has its model and none is about to change; an incomplete model is not exported. @param {import("../types.js").Page} state */
const isReady = (state) => state.is_whole && !state.job?.asked_for;

/** @param {number} study @param {string} format @param {string} name @param {string} says @param {boolean} isReady */
function download(study, format, name, says, isReady) {
  const text = [icon("drop"), el("span", {}, el("b", {}, name), el("span", { class: "note" }, says))];
  return el("li", {}, isReady ? el("a", { href: `/api/studies/${study}/export/${format}`, download: "", "data-key": `export:${format}` }, text) : el("span", { class: "off" }, text));
}

/** The log lies in enough orientations for a calibration by hand. @param {number} study */
function certificate(study) {
  const text = [icon("drop"), el("span", {}, el("b", {}, "Calibration certificate"), el("span", { class: "note" }, "Bias, sensitivity and cross-axis from its orientations, and the one to record next"))];
  return el("li", {}, el("a", { href: `/api/studies/${study}/certificate`, download: "", "data-key": "certificate" }, text));
}

/** @param {string} command @param {string} key @param {(text: string) => void} announce */
function commandElement(command, key, announce) {
  const copy = el("button", { type: "button", class: "small", "data-key": key, onclick: () => void write() }, "Copy");
  const write = async () => {
    await navigator.clipboard.writeText(command).then(
      () => say("Copied"),
      () => say("Select and copy by hand"),
    );
  };
  const say = (/** @type {string} */ text) => {
    copy.textContent = text;
    announce(text);
    setTimeout(() => (copy.textContent = "Copy"), 2000);
  };
  return el("div", { class: "command" }, el("pre", { tabindex: 0 }, el("code", {}, command)), copy);
}

/** @param {number | null | undefined} square */
const root = (square) => (typeof square === "number" ? Math.sqrt(square) : null);

/** @param {HTMLElement} host @param {Replay} replay @param {import("../types.js").Page} state @param {(text: string) => void} announce */
function drawReplay(host, { log, summary, command }, state, announce) {
  const named = (/** @type {string} */ column) => state.axes.find((axis) => axis.column === column);
  const row = (/** @type {import("../types.js").AxisSummary} */ axis) => {
    const units = named(axis.column)?.units;
    const write = (/** @type {number | null} */ value) => (axis.innovations === 0 || !units ? "–" : inUnit(value, chosen(units.errors)));
    return el(
      "tr",
      { "data-axis": axis.column },
      el("th", { scope: "row" }, named(axis.column)?.label ?? axis.column),
      [count(axis.innovations), write(axis.innovation_rms_f32), write(root(axis.errors?.slow_error_coast)), write(root(axis.errors?.coast.at(-1)?.mse))].map((text) => el("td", { class: "right" }, text)),
    );
  };
  const head = ["Axis", "innovations", "innovation, RMS in f32", "slow error, free run", "RMS after the longest free run"];
  replace(
    host,
    el("p", {}, "Run over ", el("b", {}, fileName(log)), ` on fos-core in f32, bit for bit as on a device: ${count(summary.rows)} rows, ${count(summary.tracked)} of them tracked.`),
    el("p", {}, "Digest of all corrections of the predictor in f32: ", el("code", { class: "digest" }, summary.corrections_digest), "."),
    el("div", { class: "scrolls", tabindex: 0, role: "region", "aria-label": "Numbers of the exported image" }, el("table", {}, el("thead", {}, el("tr", {}, head.map((text, at) => el("th", { scope: "col", class: at ? "right" : null }, text)))), el("tbody", {}, summary.axes.map(row)))),
    commandElement(command, "command:replay", announce),
  );
}
