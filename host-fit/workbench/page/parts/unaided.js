// @ts-check
// Heading and position error without aiding, before the model and with it: of one axis, and of six axes together.

import { get, isAbort, messageOf } from "../api.js";
import { el, replace } from "../dom.js";
import { count, number } from "../format.js";
import { alertElement } from "../notices.js";
import { modelKey } from "../studypage.js";
import { chosen as unitOf, system } from "../units.js";

/** @typedef {import("../types.js").UnaidedError} UnaidedError */
/** @typedef {import("../types.js").RmsInterval} RmsInterval */
/** @typedef {import("../types.js").ShownUnit} ShownUnit */
/** @typedef {import("../types.js").AxisPage} AxisPage */

const RMS = "RMS over whole windows at rest of the evaluated rows, with 90 % interval.";

/** @param {number} seconds */
const words = (seconds) => (seconds > 60 ? `${seconds / 60} min` : `${seconds} s`);

/** The errors of one quantity, a row for each time. @param {string} of @param {[UnaidedError, UnaidedError][]} errors before and after @param {"heading_rad" | "position_m"} quantity @param {ShownUnit} unit */
function table(of, errors, quantity, { label, divisor }) {
  const cell = (/** @type {RmsInterval | undefined} */ found) => (found ? `${number(found.rms / divisor)} (${number(found.low / divisor)} … ${number(found.high / divisor)})` : "too few windows");
  const name = quantity === "position_m" ? "Position error" : "Heading error";
  const head = [`${name} after`, `before the model, ${label}`, `with the model, ${label}`, "windows"];
  return el(
    "div",
    { class: "scrolls", tabindex: 0, role: "region", "aria-label": `${name} of ${of} without aiding` },
    el(
      "table",
      {},
      el("thead", {}, el("tr", {}, head.map((text) => el("th", { scope: "col" }, text)))),
      el("tbody", {}, errors.map(([before, after]) => el("tr", {}, el("th", { scope: "row" }, words(after.window_s)), [cell(before[quantity]), cell(after[quantity]), count(after.windows)].map((text) => el("td", {}, text))))),
    ),
  );
}

/** @param {HTMLElement} host @param {AxisPage | null | undefined} axis */
export function drawUnaided(host, axis) {
  const errors = axis?.comparison?.errors ?? [];
  const [before, after] = ["constant mean", "model"].map((name) => errors.find(({ model }) => model === name)?.unaided ?? []);
  if (!axis || !before?.length || !after?.length) return replace(host);
  const pairs = after.map((error, at) => /** @type {[UnaidedError, UnaidedError]} */ ([before[at], error]));
  replace(
    host,
    el("h3", {}, "Without aiding"),
    table("the axis", pairs, axis.units.unaided.si.label === "m" ? "position_m" : "heading_rad", unitOf(axis.units.unaided)),
    el("p", { class: "note" }, `${RMS} Before: raw error minus the constant bias estimated in training. With the model: a free run, which does not use the error measured in the window.`),
  );
}

/** Errors of the whole study, requested once every axis has its model. @param {number} study */
export function sixAxes(study) {
  const element = el("div", { class: "unaided" });
  let asked = "";
  let request = new AbortController();

  /** @param {import("../studypage.js").Scene} scene */
  async function update({ state }) {
    const [gyro, accelerometer] = ["gx_rads", "ax_mps2"].map((column) => state.axes.find((axis) => axis.column === column));
    const isReady = gyro && accelerometer && state.is_whole && !state.job?.asked_for;
    const key = isReady ? JSON.stringify([state.axes.map((axis) => [axis.column, modelKey(axis)]), system()]) : "";
    if (key === asked) return;
    asked = key;
    request.abort();
    replace(element);
    if (!isReady) return;
    request = new AbortController();
    const { signal } = request;
    try {
      const errors = /** @type {[UnaidedError, UnaidedError][]} */ (await get(`/api/studies/${study}/strapdown`, signal));
      if (signal.aborted || errors.length === 0) return;
      replace(
        element,
        el("h3", {}, "Six axes without aiding"),
        table("six axes", errors, "heading_rad", unitOf(gyro.units.unaided)),
        table("six axes", errors, "position_m", unitOf(accelerometer.units.unaided)),
        el("p", { class: "note" }, `${RMS} A strapdown of all six axes, where an attitude error tilts gravity into the position; position is a distance in space.`),
      );
    } catch (error) {
      if (signal.aborted || isAbort(error)) return;
      replace(element, alertElement(messageOf(error)));
    }
  }

  return { element, update };
}
