// @ts-check
// Data-sheet units or SI: the server sends both for each number, the user chooses.

import { radioGroup } from "./dom.js";
import { quantity } from "./format.js";

/** @typedef {import("./types.js").UnitChoice} UnitChoice */
/** @typedef {import("./types.js").ShownUnit} ShownUnit */
/** @typedef {import("./types.js").Figure} Figure */
/** @typedef {import("./types.js").Axis} Axis */
/** @typedef {"field" | "si"} System */

const STORED = "fos-units";

/** @returns {System} */
export const system = () => (localStorage.getItem(STORED) === "si" ? "si" : "field");

/** Unit of a number in the chosen system. @param {UnitChoice} choice @returns {ShownUnit} */
export const chosen = (choice) => choice[system()];

/** A value with its unit. @param {number | null | undefined} value @param {ShownUnit} unit */
export const inUnit = (value, { label, divisor }, digits = 3) => quantity(typeof value === "number" ? value / divisor : value, label, digits);

/** @param {() => void} changed */
export function unitSwitch(changed) {
  return radioGroup({
    legend: "Units",
    name: "units",
    class: "theme",
    options: [
      { value: "field", text: "°/s, mg", hint: "Units of data sheets" },
      { value: "si", text: "SI", hint: "rad/s and m/s²" },
    ],
    chosen: system(),
    choose(value) {
      localStorage.setItem(STORED, value);
      changed();
    },
  });
}

/** `°/s` → `(°/s)²/Hz`, as in figure files. @param {string} unit */
const perHertz = (unit) => (/[/ ·]/.test(unit) ? `(${unit})²/Hz` : `${unit}²/Hz`);

/** A figure with its values in `from` converted to another unit. @param {Figure} figure @param {string} from @param {ShownUnit} to @returns {Figure} */
export function figureIn(figure, from, { label, divisor }) {
  if (from === label) return figure;
  /** @type {(axis: Axis) => {axis: Axis, scale: (value: number | null) => number | null}} */
  const converted = (axis) => {
    for (const [old, now, by] of /** @type {[string, string, number][]} */ ([[`(${from})`, `(${label})`, divisor], [`(${perHertz(from)})`, `(${perHertz(label)})`, divisor ** 2]])) {
      if (axis.label.endsWith(old)) return { axis: { ...axis, label: axis.label.slice(0, -old.length) + now }, scale: (value) => value === null ? null : value / by };
    }
    return { axis, scale: (value) => value };
  };
  return {
    ...figure,
    panels: figure.panels.map((panel) => {
      const [x, y] = [converted(panel.x), converted(panel.y)];
      const series = panel.series.map((one) => ({ ...one, shape: scaled(one.shape, x.scale, y.scale) }));
      return { ...panel, x: x.axis, y: y.axis, series };
    }),
  };
}

/** @typedef {(value: number | null) => number | null} Scale */

/** @param {import("./types.js").Shape} shape @param {Scale} x @param {Scale} y @returns {import("./types.js").Shape} */
function scaled(shape, x, y) {
  if ("Level" in shape) return { Level: y(shape.Level) ?? 0 };
  if ("Line" in shape) return { Line: shape.Line.map(([at, value]) => [x(at), y(value)]) };
  if ("Points" in shape) return { Points: shape.Points.map(([at, value]) => [x(at), y(value)]) };
  if ("Stems" in shape) return { Stems: shape.Stems.map(([at, value]) => [x(at), y(value)]) };
  if ("Band" in shape) return { Band: shape.Band.map(([at, low, high]) => [x(at), y(low), y(high)]) };
  if ("Bars" in shape) return { Bars: shape.Bars.map(([at, value, low, high]) => [x(at), y(value), y(low), y(high)]) };
  /** @type {(cells: [number | null, number | null, number | null, number | null][]) => [number | null, number | null, number | null, number | null][]} */
  const cells = (all) => all.map(([left, right, low, high]) => [x(left), x(right), y(low), y(high)]);
  return "Cells" in shape ? { Cells: cells(shape.Cells) } : { Frames: cells(shape.Frames) };
}
