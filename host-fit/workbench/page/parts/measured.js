// @ts-check
// Part 1: measured against predicted, from the whole log down to single samples.

import { el, radioGroup, replace, uniqueId } from "../dom.js";
import { isNumber, seconds } from "../format.js";
import { KEY_ZOOM } from "../gestures.js";
import { onPage } from "../notices.js";
import { Overview } from "../overview.js";
import { TimeChart } from "../timechart.js";
import { chosen as unitOf, inUnit } from "../units.js";
import { section } from "./section.js";
import { movedOf, shadesOf } from "./stretches.js";

/** @typedef {import("../studypage.js").Context} Context */
/** @typedef {import("../types.js").ViewKind} ViewName */

/** @type {{value: ViewName, text: string, hint: string, says: string}[]} */
const VIEWS = [
  { value: "slow", text: "Slow", hint: "Means, the model in a free run", says: "Means of samples, the model in a free run of at most 60 s. Averaging removes the noise that would hide a slow failure." },
  { value: "coast", text: "Free run", hint: "Every sample, the model on its own output", says: "Every sample, and the model on its own output for at most 60 s, as on a device that moves." },
  { value: "one_step", text: "One step", hint: "Every sample, each predicted from the measured ones before it", says: "Every sample, each predicted from the measured ones before it. Slow errors hardly show, because the previous sample contains them." },
];

/** Window below which samples show more than 1-s means, s. */
const SHORT = 20;

/** Share of the log after which a late begin of the predictions is explained. */
const LATE = 0.02;

/** @param {Context} context @returns {import("../studypage.js").Part} */
export function measuredPart({ time, source, choose, setView, setMean }) {
  const chart = new TimeChart({
    label: "Measured",
    height: 300,
    time,
    traces: [
      { of: "measured", label: "measured", ink: "--ink-measured" },
      { of: "predicted", label: "predicted", ink: "--ink-predicted" },
      { of: "predicted_before", label: "predicted before any effect was added", ink: "--ink-other", off: true },
    ],
    click: (shade) => shade && choose({ from: shade.from, to: shade.to, mark: shade.mark }),
  });
  chart.resized = (width) => source.setWidth(width);
  const beside = [0, 1].map((at) => new TimeChart({ label: `channel ${at + 1}`, height: 124, time, traces: [{ of: at, label: "", ink: "--ink-other" }] }));
  const means = el("div", { class: "means" });
  const overview = new Overview(time);
  const views = el("div", {});
  const says = el("p", { class: "note" });
  const shown = el("span", { class: "shown" });
  const finer = el("button", { type: "button", class: "link", hidden: true, onclick: () => setView("one_step") }, "Show single samples");
  const inspect = el("button", { type: "button", class: "link", hidden: true, onclick: () => inspectShown() }, "Show this range in every panel");
  const inspectShown = () => {
    const [from, to] = time.shown;
    choose({ from, to, mark: null });
    time.show(from, to);
  };
  const empty = el("p", { class: "loading" }, "Reading samples …");
  const button = (/** @type {string} */ text, /** @type {string} */ name, /** @type {() => void} */ act) =>
    el("button", { type: "button", class: "small", "aria-label": name, title: name, onclick: act }, text);
  const late = el("p", { class: "note late", hidden: true });
  const cautions = el("div");
  const fit = el("p", { class: "goodness" });
  const controls = el(
    "div",
    { class: "controls" },
    button("−", "Zoom out", () => time.zoom(1 / KEY_ZOOM)),
    button("+", "Zoom in", () => time.zoom(KEY_ZOOM)),
    button("All", "All: show the whole log", () => time.showAll()),
    shown,
    inspect,
    finer,
    el("span", { class: "hint" }, "Drag to zoom, shift-drag to pan"),
  );
  const element = section(
    1,
    "Measured against predicted",
    "Does the model follow the sensor?",
    fit,
    el("div", { class: "card" }, el("div", { class: "card-head" }, views, means, says), empty, chart.element, beside.map((one) => one.element), overview.element, controls, late, cautions),
  );

  /** @type {ViewName} */
  let view = "slow";
  const say = () => {
    const [from, to] = time.shown;
    const text = `${seconds(from, time.span)} to ${seconds(to, time.span)}${time.isWhole ? ", the whole log" : ""}`;
    if (shown.textContent !== text) shown.textContent = text;
    finer.hidden = !(view === "slow" && time.span < SHORT);
    inspect.hidden = time.isWhole;
  };
  time.onChange(say);
  /** @type {import("../types.js").AxisSeries | null} */
  let strip = null;
  source.onData((drawn) => {
    empty.hidden = drawn !== null;
    chart.setData(drawn?.shown ?? null);
    for (const [at, one] of beside.entries()) {
      const channel = drawn?.shown.beside[at];
      one.element.hidden = !channel;
      if (channel) {
        one.setLabel(channel.label);
        one.setUnit({ label: channel.unit, divisor: 1 });
      }
      one.setData(channel ? (drawn?.shown ?? null) : null);
    }
    if (strip !== (drawn?.whole ?? null)) overview.setData((strip = drawn?.whole ?? null));
  });

  let label = "";
  return {
    element,
    update(scene) {
      view = scene.view;
      const now = `${scene.view} ${scene.axis?.column} ${scene.mean}`;
      if (label !== now) {
        label = now;
        replace(views, radioGroup({ legend: "What is compared", name: "view", options: VIEWS, chosen: scene.view, choose: (value) => setView(/** @type {ViewName} */ (value)) }));
        replace(means, scene.view === "slow" ? meansSelect(scene.mean, setMean) : null);
        says.textContent = VIEWS.find(({ value }) => value === scene.view)?.says ?? "";
        chart.setLabel(scene.axis ? scene.axis.label : "Measured");
      }
      if (scene.axis) chart.setUnit(unitOf(scene.axis.units.measured));
      replace(fit, scene.axis ? goodness(scene.axis) : null);
      const begin = scene.axis?.evaluated_s?.[0];
      const field = scene.state.logs?.log;
      late.hidden = begin === undefined || !field || begin - field.from_s < LATE * (field.to_s - field.from_s);
      if (begin !== undefined) late.textContent = `Predictions begin at ${seconds(begin)}: the model was fitted to the rows before.`;
      replace(cautions, (scene.axis?.comparison?.cautions ?? []).map((caution) => el("p", { class: "note" }, `Caution: ${onPage(caution)}.`)));
      chart.setShades(shadesOf(scene));
      chart.setMoved(movedOf(scene));
      overview.setMoved(movedOf(scene));
      say();
    },
  };
}

/** Slow error of the model and of the constant mean, and how close the samples are to the noise floor. @param {import("../types.js").AxisPage} axis */
function goodness({ comparison, slow_error: slow, units }) {
  if (!comparison || !slow || slow[1] === null) return null;
  const unit = unitOf(units.errors);
  const entry = (/** @type {string} */ name, /** @type {string} */ value) => el("span", {}, `${name} `, el("b", {}, value));
  const squares = comparison.errors.find(({ model }) => model === "model")?.one_step_mse;
  const floor = comparison.noise_floor?.[0];
  return [
    el("span", {}, "Slow error in a free run: "),
    entry("model", inUnit(slow[1], unit)),
    entry("constant mean", inUnit(slow[0], unit)),
    ...(isNumber(squares) && isNumber(floor) ? [el("span", {}, "One-step prediction error: "), entry("model", inUnit(Math.sqrt(squares), unit)), entry("noise floor", inUnit(Math.sqrt(floor), unit))] : []),
  ];
}

/** Averaging times to choose from, s. */
const MEANS = [1, 10, 60, 600];

/** @param {number | null} mean @param {(mean: number | null) => void} choose */
function meansSelect(mean, choose) {
  const id = uniqueId("mean");
  const options = [el("option", { value: "", selected: mean === null }, "follows the zoom"), ...MEANS.map((one) => el("option", { value: one, selected: one === mean }, `${one} s`))];
  const select = el("select", { id, "data-key": "mean", onchange: () => choose(select.value === "" ? null : Number(select.value)) }, options);
  return [el("label", { for: id }, "Averaging time "), select];
}
