// @ts-check
// A chart over time: bands from the lowest to the highest sample; lines and dots where every sample is loaded.

import uPlot from "./vendor/uplot.esm.js";
import { el } from "./dom.js";
import { capitalised, seconds } from "./format.js";
import { listenToHands, listenToKeys } from "./gestures.js";
import { whileOnPage } from "./onpage.js";
import { downloads } from "./downloads.js";
import { legendEntry, paint, placeOf, rangeOutside, saidAt } from "./shading.js";
import { colour, faint, onTheme } from "./theme.js";
import { linearTicks, spaced } from "./ticks.js";
import { inUnit } from "./units.js";

/** @typedef {import("./types.js").AxisSeries} Series */
/** @typedef {import("./types.js").LowAndHigh} LowAndHigh */
/** @typedef {"measured" | "predicted" | "left" | "predicted_before" | "left_before" | number} TraceName a number: index of an additional channel */
/** @typedef {{of: TraceName, label: string, ink: string, off?: boolean}} Drawn a trace, its name, its colour's custom property; off: hidden until switched on */
/** @typedef {{from: number, to: number, mark: string, chosen: boolean}} Shade */
/** @typedef {{label: string, traces: Drawn[], height: number, time: import("./timewindow.js").TimeWindow, click?: (shade: Shade | null) => void}} Options */

/** Pixels per sample from which dots are drawn. */
const DOT_SPACE = 5;
/** Room for the labels of the y axis, and on the right, pixels; the overview uses the same. */
export const Y_AXIS = 64;
export const RIGHT = 12;
const Y_LABELS = 45; // pixels between labels
/** Height of a label with some room, pixels. */
export const LINE = 15;
const X_LABELS = 110;
/** Rows for the marks of stretches that lie close together. */
const MARK_ROWS = 3;
const FONT = "12px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

export class TimeChart {
  /** The chart with its legend. */
  element;
  /** @type {Options} */
  #options;
  /** @type {uPlot | null} */
  #plot = null;
  /** @type {Series | null} */
  #series = null;
  /** @type {Shade[]} */
  #shades = [];
  /** @type {import("./types.js").Shading | null} */
  #moved = null;
  #host = el("div", { class: "plot" });
  #label;
  #legend = el("div", { class: "legend", role: "group", "aria-label": "Traces" });
  #yLabel = el("p", { class: "y-label" });
  #picture = el("div", { role: "img" });
  #focus;
  /** @type {import("./types.js").ShownUnit} */
  #unit = { label: "", divisor: 1 };
  /** Labels of traces that are switched off. @type {Set<string>} */
  #off;
  /** Where the value under the cursor stands, by label. @type {Map<string, HTMLElement>} */
  #values = new Map();
  #atTime = el("span", { class: "value" });
  #atMoved = el("span", {});
  /** Told whenever the plot gets another width. @type {(width: number) => void} */
  resized = () => {};

  /** @param {Options} options */
  constructor(options) {
    this.#options = options;
    this.#off = new Set(options.traces.filter(({ off }) => off).map(({ label }) => label));
    this.#label = options.label;
    this.#picture.append(this.#host);
    this.#focus = el(
      "div",
      {
        class: "time-chart",
        tabindex: 0,
        role: "group",
        "data-key": `chart:${options.label}`,
        "aria-label": keysOf(options.label),
      },
      this.#picture,
    );
    this.#focus.style.setProperty("--plot-height", `${options.height}px`);
    this.element = el("div", {}, el("div", { class: "chart-head" }, this.#yLabel, this.#legend, downloads(() => this.#figure())), this.#focus);
    listenToKeys(this.#focus, options.time);
    options.time.onChange(() => this.#move());
    const forget = onTheme(() => this.#plot?.redraw(false));
    const gone = () => {
      forget();
      this.#clear();
    };
    whileOnPage(this.#host, (width) => this.#resize(width), gone);
  }

  /** Draws these samples; null clears the chart. @param {Series | null} series */
  setData(series) {
    this.#series = series;
    if (!series) return this.#clear();
    const drawn = this.#drawn(series);
    if (this.#plot && this.#plot.series.length !== 1 + 2 * drawn.length) this.#clear();
    const data = /** @type {uPlot.AlignedData} */ ([
      series.time_s,
      ...drawn.flatMap((trace) => {
        const { low, high } = /** @type {LowAndHigh} */ (traceOf(series, trace));
        return [low, high];
      }),
    ]);
    if (this.#plot) this.#plot.setData(data, false);
    else this.#make(data, drawn);
    this.#drawLegend(drawn);
    this.#move();
    this.#describe();
  }

  /** Name of the axis in the chart. @param {string} label */
  setLabel(label) {
    this.#label = label;
    this.#focus.setAttribute("aria-label", keysOf(label));
    this.#plot?.redraw(false, true);
    this.#describe();
  }

  /** Unit of the shown values. @param {import("./types.js").ShownUnit} unit */
  setUnit(unit) {
    if (unit.label === this.#unit.label) return;
    this.#unit = unit;
    this.#plot?.redraw(true, true);
    this.#describe();
  }

  /** @param {Shade[]} shades */
  setShades(shades) {
    this.#shades = shades;
    this.#plot?.redraw(false);
  }

  /** Shades detected motion. @param {import("./types.js").Shading | null} moved */
  setMoved(moved) {
    if (this.#moved === moved) return;
    this.#moved = moved;
    this.#plot?.redraw();
    this.#describe();
  }

  #clear() {
    this.#plot?.destroy();
    this.#plot = null;
    this.#values.clear();
    this.#legend.replaceChildren();
  }

  /** Traces with data. @param {Series} series */
  #drawn(series) {
    return this.#options.traces.filter((trace) => traceOf(series, trace));
  }

  /** Legend whose entries hide and show traces; created once per set of traces, so that focus stays. @param {Drawn[]} drawn */
  #drawLegend(drawn) {
    const isExact = this.#series?.exact ?? false;
    for (const swatch of this.#legend.querySelectorAll(".toggle .swatch, .single .swatch")) swatch.className = `swatch ${isExact ? "line" : "band"}`;
    if (drawn.length === this.#values.size && drawn.every(({ label }) => this.#values.has(label))) return;
    this.#values.clear();
    const entries = drawn.map(({ label, ink }, at) => {
      const value = el("span", { class: "value", "aria-hidden": "true" });
      this.#values.set(label, value);
      const kind = `entry ${ink.replace("--ink", "ink")}`;
      const swatch = el("i", { class: `swatch ${isExact ? "line" : "band"}` });
      if (drawn.length === 1) return el("span", { class: `${kind} single` }, label ? swatch : null, label, value);
      const toggle = el("button", { type: "button", class: "toggle", "aria-pressed": String(!this.#off.has(label)), onclick: () => this.#toggle(label, at, toggle) }, swatch, label);
      return el("span", { class: kind }, toggle, value);
    });
    this.#legend.replaceChildren(this.#atTime, ...entries, this.#atMoved);
  }

  /** @param {string} label @param {number} at @param {HTMLElement} toggle */
  #toggle(label, at, toggle) {
    if (!this.#off.delete(label)) this.#off.add(label);
    const show = !this.#off.has(label);
    toggle.setAttribute("aria-pressed", String(show));
    for (const side of [2 * at + 1, 2 * at + 2]) this.#plot?.setSeries(side, { show });
  }

  /** The visible range as a figure. @returns {import("./types.js").Figure | null} */
  #figure() {
    const series = this.#series;
    if (!series) return null;
    const [from, to] = this.#options.time.shown;
    const drawn = this.#drawn(series).filter(({ label }) => !this.#off.has(label));
    const scaled = (/** @type {number | null | undefined} */ value) => (typeof value === "number" ? value / this.#unit.divisor : null);
    const lines = drawn.map((trace) => {
      const { low, high } = /** @type {LowAndHigh} */ (traceOf(series, trace));
      const at = series.time_s.map((time, index) => ({ time, index })).filter(({ time }) => time >= from && time <= to);
      /** @type {import("./types.js").Shape} */
      const shape = series.exact ? { Line: at.map(({ time, index }) => [time, scaled(low[index])]) } : { Band: at.map(({ time, index }) => [time, scaled(low[index]), scaled(high[index])]) };
      return { label: trace.label, ink: inkOf(trace), shape };
    });
    const shading = this.#moved ? [this.#moved] : [];
    return { title: `${capitalised(this.#label)} over time`, panels: [{ title: "", x: { label: "Time (s)", scale: "Linear", names: [] }, y: { label: this.#yText(), scale: "Linear", names: [] }, series: lines, shading }] };
  }

  #yText() {
    const mean = this.#series?.mean_s;
    const means = typeof mean === "number" ? `, ${mean}-s means` : "";
    return `${capitalised(this.#label)}${means}${this.#unit.label ? ` (${this.#unit.label})` : ""}`;
  }

  /** @param {uPlot.AlignedData} data @param {Drawn[]} drawn */
  #make(data, drawn) {
    const { height, time, click } = this.#options;
    const exact = () => Boolean(this.#series?.exact);
    /** @type {(trace: Drawn) => uPlot.Series[]} */
    const pair = ({ ink, label }) => {
      const side = {
        label,
        show: !this.#off.has(label),
        stroke: () => (exact() ? colour(ink) : faint(ink, 0.75)),
        width: 1,
        points: { show: () => this.#hasDots(), size: 5, fill: () => colour(ink), stroke: () => colour(ink) },
      };
      return [side, { ...side }];
    };
    /** @type {(trace: Drawn, index: number) => uPlot.Band} */
    const band = ({ ink }, index) => ({ series: [2 * index + 2, 2 * index + 1], fill: () => faint(ink, 0.32) });
    this.#plot = new uPlot(
      {
        width: this.#host.clientWidth || 600,
        height,
        legend: { show: false },
        cursor: {
          drag: { x: false, y: false },
          y: false,
          points: { show: false },
          sync: { key: "time" },
          bind: { dblclick: () => null },
        },
        scales: {
          x: { time: false, range: () => [time.shown[0], time.shown[1]] },
          y: { range: (u, low, high) => padded(...rangeOutside(u, this.#moved, low, high)) },
        },
        axes: [
          { ...axisStyle(), size: 34, label: "Time (s)", labelSize: 20, labelFont: FONT, splits: (u, _, low, high) => split(linearTicks(low, high, plotWidth(u) / X_LABELS)), values: (u, at) => labels(at, u) },
          { ...axisStyle(), size: Y_AXIS, splits: (u, _, low, high) => this.#ySplits(low, high, u.height - 72), values: (u, at) => this.#yLabels(at, u.height - 72) },
        ],
        series: [{}, ...drawn.flatMap(pair)],
        bands: drawn.map(band),
        padding: [18, RIGHT, 0, 0],
        hooks: {
          drawClear: [(u) => this.#shade(u)],
          draw: [(u) => this.#marks(u)],
          setCursor: [(u) => this.#readOut(u)],
        },
      },
      data,
      this.#host,
    );
    listenToHands(this.#plot.over, time, (at, tolerance) => {
      const hit = this.#shades.filter((shade) => at > shade.from - tolerance && at < shade.to + tolerance);
      const distance = (/** @type {Shade} */ shade) => Math.abs(0.5 * (shade.from + shade.to) - at);
      click?.(hit.sort((a, b) => distance(a) - distance(b))[0] ?? null);
    });
    this.resized(plotWidth(this.#plot));
  }

  /** @param {number} width */
  #resize(width) {
    if (!this.#plot || width === this.#plot.width) return;
    this.#plot.setSize({ width, height: this.#options.height });
    this.resized(plotWidth(this.#plot));
  }

  #move() {
    const [min, max] = this.#options.time.shown;
    this.#plot?.setScale("x", { min, max });
  }

  #hasDots() {
    const { time } = this.#options;
    const plot = this.#plot;
    if (!plot || !this.#series?.exact) return false;
    return plotWidth(plot) / (time.span / this.#series.period_s) >= DOT_SPACE;
  }

  /** Ticks of the y axis in the shown unit. @param {number} low @param {number} high @param {number} height */
  #yTicks(low, high, height) {
    const { divisor } = this.#unit;
    return linearTicks(low / divisor, high / divisor, height / Y_LABELS).map((tick) => ({ ...tick, value: tick.value * divisor }));
  }

  /** @param {number} low @param {number} high @param {number} height */
  #ySplits(low, high, height) {
    const text = this.#yText();
    if (this.#yLabel.textContent !== text) this.#yLabel.textContent = text;
    return this.#yTicks(low, high, height).map((tick) => tick.value);
  }

  /** @param {number[]} at @param {number} height */
  #yLabels(at, height) {
    const { min, max } = this.#plot?.scales.y ?? {};
    const ticks = this.#yTicks(min ?? 0, max ?? 1, height);
    const unit = height / ((max ?? 1) - (min ?? 0));
    const kept = spaced(ticks, (value) => value * unit, () => LINE);
    return at.map((value) => kept.find((tick) => tick.value === value)?.label ?? "");
  }

  /** @param {uPlot} u */
  #shade(u) {
    const { ctx, bbox } = u;
    if (this.#moved) paint(u, this.#moved);
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const shade of this.#shades) {
      const { left, width } = placeOf(u, shade);
      ctx.fillStyle = faint("--shade", shade.chosen ? 0.32 : 0.2);
      ctx.fillRect(left, bbox.top, width, bbox.height);
    }
    ctx.restore();
  }

  /** Numbers at the top of the stretches; those that would overlap move one row down. @param {uPlot} u */
  #marks(u) {
    const { ctx, bbox } = u;
    const unit = uPlot.pxRatio;
    const rows = Array(MARK_ROWS).fill(-Infinity);
    ctx.save();
    ctx.font = FONT.replace("12px", `600 ${12 * unit}px`);
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    const places = this.#shades.map((shade) => ({ shade, ...placeOf(u, shade) })).sort((a, b) => a.middle - b.middle);
    for (const { shade, middle, left, width } of places) {
      const [begin, end] = [bbox.left, bbox.left + bbox.width];
      if (left > end || left + width < begin) continue;
      const at = Math.min(Math.max(middle, begin + 8 * unit), end - 8 * unit);
      const free = rows.findIndex((last) => at - last > 18 * unit);
      const row = free < 0 ? MARK_ROWS - 1 : free;
      rows[row] = at;
      const y = bbox.top + (row * 18 - 8) * unit;
      ctx.fillStyle = shade.chosen ? colour("--shade-mark") : colour("--surface");
      ctx.strokeStyle = colour("--shade-mark");
      ctx.lineWidth = unit;
      ctx.beginPath();
      ctx.arc(at, y, 8 * unit, 0, 2 * Math.PI);
      ctx.fill();
      ctx.stroke();
      ctx.fillStyle = shade.chosen ? colour("--surface") : colour("--shade-mark");
      ctx.fillText(shade.mark, at, y + 0.5 * unit);
    }
    ctx.restore();
  }

  /** The values under the cursor, in the legend. @param {uPlot} [u] */
  #readOut(u) {
    const series = this.#series;
    if (!series) return;
    const index = u?.cursor.idx;
    const at = typeof index === "number" && (u?.cursor.left ?? -1) >= 0 ? index : null;
    for (const trace of this.#drawn(series)) {
      const { low, high } = /** @type {LowAndHigh} */ (traceOf(series, trace));
      const [from, to] = at === null ? [null, null] : [low[at], high[at]];
      const value = at === null ? "" : from === to ? inUnit(from, this.#unit) : `${inUnit(from, this.#unit)} … ${inUnit(to, this.#unit)}`;
      const place = this.#values.get(trace.label);
      if (place) place.textContent = value;
    }
    this.#atTime.textContent = at === null ? "" : seconds(Number(series.time_s[at]), this.#options.time.span);
    const moved = this.#moved?.ranges.length ? [legendEntry("span", this.#moved, at === null || !u ? "" : saidAt(u, this.#moved, u.cursor.left ?? -1))] : [];
    this.#atMoved.replaceChildren(...moved);
  }

  #describe() {
    const series = this.#series;
    if (!series) return;
    this.#readOut();
    const parts = this.#drawn(series).map((trace) => {
      const { low, high } = /** @type {LowAndHigh} */ (traceOf(series, trace));
      return `${trace.label} from ${inUnit(extreme(low, Math.min), this.#unit)} to ${inUnit(extreme(high, Math.max), this.#unit)}`;
    });
    if (this.#moved?.ranges.length) parts.push(`${this.#moved.label}, in ${this.#moved.ranges.length === 1 ? "one stretch" : `${this.#moved.ranges.length} stretches`}`);
    const [from, to] = this.#options.time.whole;
    this.#picture.setAttribute("aria-label", `${capitalised(this.#label)} over time, ${seconds(from)} to ${seconds(to)}: ${parts.join("; ")}.`);
  }
}

/** @param {string} label */
const keysOf = (label) => `${capitalised(label)}. Plus and minus zoom, arrows pan, Home shows the whole log.`;

/** @param {Series} series @param {Drawn} trace @returns {LowAndHigh | null} */
const traceOf = (series, { of }) => (typeof of === "number" ? (series.beside[of]?.values ?? null) : series[of]);

/** @param {Drawn} trace @returns {import("./types.js").Ink} */
const inkOf = ({ of }) => (of === "measured" ? "Measured" : of === "predicted" ? "Predicted" : of === "left" ? "Residual" : "Other");

/** @param {(number | null)[]} values @param {(a: number, b: number) => number} of */
export function extreme(values, of) {
  /** @type {number | null} */
  let found = null;
  for (const value of values) if (value !== null) found = found === null ? value : of(found, value);
  return found;
}

/** @param {number | null} low @param {number | null} high @returns {[number, number]} */
export function padded(low, high) {
  if (low === null || high === null) return [0, 1];
  const room = 0.06 * (high - low) || Math.abs(high) || 1;
  return [low - room, high + room];
}

/** Style of all axes. @returns {uPlot.Axis} */
export function axisStyle() {
  return {
    font: FONT,
    stroke: () => colour("--text-2"),
    grid: { stroke: () => colour("--grid"), width: 1 },
    ticks: { stroke: () => colour("--axis"), width: 1, size: 5 },
    border: { show: true, stroke: () => colour("--axis"), width: 1 },
    gap: 6,
  };
}

/** Between the axes, pixels; known before the chart is laid out. @param {uPlot} u */
const plotWidth = (u) => u.width - Y_AXIS - RIGHT;

/** Width of a label, pixels. @param {string} label */
export const widthOf = (label) => 7.2 * label.length;

/** @param {import("./ticks.js").Tick[]} ticks */
const split = (ticks) => ticks.map((tick) => tick.value);

/** @param {number[]} at @param {uPlot} u */
function labels(at, u) {
  const { min = 0, max = 1 } = u.scales.x ?? {};
  const width = plotWidth(u);
  const [low, high] = [min ?? 0, max ?? 1];
  const ticks = linearTicks(low, high, width / X_LABELS);
  const kept = spaced(ticks, (value) => (width * (value - low)) / (high - low), widthOf, width + RIGHT);
  return at.map((value) => kept.find((tick) => tick.value === value)?.label ?? "");
}
