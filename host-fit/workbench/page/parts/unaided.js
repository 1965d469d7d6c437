// @ts-check
// Heading or position error without aiding, before the model and with it.

import { el, replace } from "../dom.js";
import { count, number } from "../format.js";
import { chosen as unitOf } from "../units.js";

/** @param {number} seconds */
const words = (seconds) => (seconds > 60 ? `${seconds / 60} min` : `${seconds} s`);

/** @param {HTMLElement} host @param {import("../types.js").AxisPage | null | undefined} axis */
export function drawUnaided(host, axis) {
  const errors = axis?.comparison?.errors ?? [];
  const [before, after] = ["constant mean", "model"].map((name) => errors.find(({ model }) => model === name)?.unaided ?? []);
  if (!axis || !before?.length || !after?.length) return replace(host);
  const { label, divisor } = unitOf(axis.units.unaided);
  /** @param {import("../types.js").UnaidedError | undefined} error */
  const cell = (error) => {
    const found = error?.heading_rad ?? error?.position_m;
    return found ? `${number(found.rms / divisor)} (${number(found.low / divisor)} … ${number(found.high / divisor)})` : "too few windows";
  };
  const quantity = axis.units.unaided.si.label === "m" ? "Position error" : "Heading error";
  replace(
    host,
    el("h3", {}, `${quantity} without aiding`),
    el(
      "table",
      {},
      el("thead", {}, el("tr", {}, ["after", `before the model, ${label}`, `with the model, ${label}`, "windows"].map((name) => el("th", { scope: "col" }, name)))),
      el("tbody", {}, after.map((error, at) => el("tr", {}, el("th", { scope: "row" }, words(error.window_s)), [cell(before[at]), cell(error), count(error.windows)].map((text) => el("td", {}, text))))),
    ),
    el("p", { class: "note" }, "RMS over whole windows at rest of the evaluated rows, with 90 % interval. Before: raw error minus the constant bias estimated in training. With the model: a free run, which does not use the error measured in the window."),
  );
}
