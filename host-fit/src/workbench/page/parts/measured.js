// @ts-check
// Part 1: the log, measured against predicted, from all of it down to single samples.

import { el, radioGroup, replace } from "../dom.js";
import { seconds } from "../format.js";
import { KEY_ZOOM } from "../gestures.js";
import { Overview } from "../overview.js";
import { TimeChart } from "../timechart.js";
import { section } from "./section.js";
import { movedOf, shadesOf } from "./stretches.js";

/** @typedef {import("../studypage.js").Context} Context */
/** @typedef {import("../types.js").ViewKind} ViewName */

/** @type {{value: ViewName, text: string, hint: string, says: string}[]} */
const VIEWS = [
  { value: "slow", text: "Slow", hint: "Means over one second, the model coasting", says: "Means over one second. Noise at the full rate would hide a slow failure; here it is averaged away." },
  { value: "coast", text: "Coast", hint: "Every sample, the model on its own history", says: "Every sample, and the model running on its own history, as on a device that moves." },
  { value: "one_step", text: "One step", hint: "Every sample, each predicted from the measured ones before it", says: "Every sample, each predicted from the measured ones before it. Slow errors hardly show: the last sample already carries them." },
];

/** Below this stretch, s, means of a second say less than samples. */
const SHORT = 20;

/** @param {Context} context @returns {import("../studypage.js").Part} */
export function measuredPart({ time, source, choose, setView }) {
  const chart = new TimeChart({
    label: "Measured",
    height: 300,
    time,
    traces: [
      { of: "measured", label: "measured", ink: "--ink-measured" },
      { of: "predicted", label: "predicted", ink: "--ink-predicted" },
    ],
    click: (shade) => shade && choose({ from: shade.from, to: shade.to, mark: shade.mark }),
  });
  chart.resized = (width) => source.setWidth(width);
  const overview = new Overview(time);
  const views = el("div", {});
  const says = el("p", { class: "note" });
  const shown = el("span", { class: "shown" });
  const finer = el("button", { type: "button", class: "link", hidden: true, onclick: () => setView("one_step") }, "Show single samples");
  const empty = el("p", { class: "loading" }, "Reading samples …");
  const button = (/** @type {string} */ text, /** @type {string} */ name, /** @type {() => void} */ act) =>
    el("button", { type: "button", class: "small", "aria-label": name, title: name, onclick: act }, text);
  const controls = el(
    "div",
    { class: "controls" },
    button("−", "Zoom out", () => time.zoom(1 / KEY_ZOOM)),
    button("+", "Zoom in", () => time.zoom(KEY_ZOOM)),
    button("All", "All: show the whole log", () => time.showAll()),
    shown,
    finer,
    el("span", { class: "hint" }, "Drag to zoom, shift-drag to pan"),
  );
  const element = section(
    1,
    "Measured against predicted",
    "Does the model follow the sensor?",
    el("div", { class: "card" }, el("div", { class: "card-head" }, views, says), empty, chart.element, overview.element, controls),
  );

  /** @type {ViewName} */
  let view = "slow";
  const say = () => {
    const [from, to] = time.shown;
    const text = `${seconds(from, time.span)} to ${seconds(to, time.span)}${time.isWhole ? ", the whole log" : ""}`;
    if (shown.textContent !== text) shown.textContent = text;
    finer.hidden = !(view === "slow" && time.span < SHORT);
  };
  time.onChange(say);
  /** @type {import("../types.js").AxisSeries | null} */
  let strip = null;
  source.onData((drawn) => {
    empty.hidden = drawn !== null;
    chart.setData(drawn?.shown ?? null);
    if (strip !== (drawn?.whole ?? null)) overview.setData((strip = drawn?.whole ?? null));
  });

  let label = "";
  return {
    element,
    update(scene) {
      view = scene.view;
      const now = `${scene.view} ${scene.axis?.column}`;
      if (label !== now) {
        label = now;
        replace(views, radioGroup({ legend: "What is compared", name: "view", options: VIEWS, chosen: scene.view, choose: (value) => setView(/** @type {ViewName} */ (value)) }));
        says.textContent = VIEWS.find(({ value }) => value === scene.view)?.says ?? "";
        chart.setLabel(scene.axis ? scene.axis.label : "Measured");
      }
      chart.setShades(shadesOf(scene));
      chart.setMoved(movedOf(scene));
      overview.setMoved(movedOf(scene));
      say();
    },
  };
}
