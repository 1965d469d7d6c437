// @ts-check
// Draws a figure of the server: headline, panels, legends, and a table of its numbers.

import uPlot from "./vendor/uplot.esm.js";
import { el } from "./dom.js";
import { panelTable } from "./figuretable.js";
import { describe, extent } from "./figuredata.js";
import { downloads } from "./downloads.js";
import { readingAt } from "./figurehover.js";
import { drawShape } from "./figureshapes.js";
import { whileOnPage } from "./onpage.js";
import { legendEntry, paint, placeOf, within } from "./shading.js";
import { colour, faint, onTheme } from "./theme.js";
import { linearTicks, logTicks, spaced } from "./ticks.js";
import { LINE as LABEL, RIGHT, Y_AXIS, axisStyle, widthOf } from "./timechart.js";

/** @typedef {import("./types.js").Figure} Figure */
/** @typedef {import("./types.js").Panel} Panel */
/** @typedef {import("./types.js").Ink} Ink */
/** @typedef {import("./types.js").Axis} FigureAxis */
/** @typedef {import("./types.js").Series} FigureSeries */
/** @typedef {import("./figuredata.js").Extent} Extent */
/** @typedef {{height?: number, heading?: "h3" | "h4" | "none"}} Looks */

/** Height of a further line of a name on the x axis, pixels. */
const LINE = 15;

/** Room for a name on the x axis, pixels a letter. */
const LETTER = 7.2;
/** Pixels between labels. */
const X_LABELS = 84;
const Y_LABELS = 36;
const STEP_COLOURS = 6;
const METHOD_COLOURS = 7;

/**
 * @param {Figure} figure
 * @param {Looks} [looks]
 */
export function figureElement(figure, { height = 220, heading = "h3" } = {}) {
  const headline = heading === "none" ? null : el(heading, { class: "figure-title" }, figure.title);
  const panels = figure.panels.map((panel) => panelElement(panel, figure.title, height));
  return el("figure", { class: "figure", "data-panels": panels.length }, headline, panels, el("figcaption", {}, downloads(() => figure)));
}

/** @param {Panel} panel @param {string} figureTitle @param {number} height */
function panelElement(panel, figureTitle, height) {
  const host = el("div", { class: "plot", role: "img", "aria-label": `${figureTitle}. ${describe(panel)}` });
  const reading = el("p", { class: "reading-at", "aria-hidden": "true" });
  const drawing = new Drawing(panel, host, height, reading);
  return el(
    "div",
    { class: "panel" },
    panel.title ? el("p", { class: "panel-title" }, panel.title) : null,
    el("div", { class: "chart-head" }, el("p", { class: "y-label" }, panel.y.label), reading, legend(panel, drawing)),
    drawing.isEmpty ? el("p", { class: "empty" }, "no data") : host,
    panelTable(panel, figureTitle),
  );
}

/** Entries switch their series off and on. @param {Panel} panel @param {Drawing} drawing */
function legend(panel, drawing) {
  /** @type {Map<string, HTMLElement>} */
  const entries = new Map();
  for (const { label, ink, shape } of panel.series) {
    if (!label || entries.has(label)) continue;
    const kind = Object.keys(shape)[0]?.toLowerCase();
    const swatch = el("i", { class: `swatch ${kind}` });
    const toggle = el("button", { type: "button", class: "toggle", "aria-pressed": "true", onclick: () => toggle.setAttribute("aria-pressed", String(drawing.toggle(label))) }, swatch, label);
    entries.set(label, el("li", { class: `entry ${inkClass(ink)}` }, toggle));
  }
  if (entries.size === 1) for (const [label, entry] of entries) entry.replaceChildren(...(entry.querySelector("i") ? [/** @type {Node} */ (entry.querySelector("i"))] : []), label);
  const x = extent(panel, "x");
  const shadings = panel.shading.filter((shading) => x && within(shading, x.low, x.high).length > 0);
  return el("ul", { class: "legend" }, [...entries.values(), ...shadings.map((shading) => legendEntry("li", shading))]);
}

/** @param {Ink} ink */
function inkClass(ink) {
  if (typeof ink === "string") return `ink-${ink.toLowerCase()}`;
  return "Step" in ink ? `ink-step-${Math.min(ink.Step, STEP_COLOURS - 1)}` : `ink-method-${ink.Method % METHOD_COLOURS}`;
}

/** One panel on a canvas. */
class Drawing {
  #panel;
  #host;
  #height;
  /** @type {uPlot | null} */
  #plot = null;
  #x;
  #y;
  #reading;
  /** Labels of the series that are switched off. @type {Set<string>} */
  #off = new Set();

  /** @param {Panel} panel @param {HTMLElement} host @param {number} height @param {HTMLElement} reading */
  constructor(panel, host, height, reading) {
    this.#reading = reading;
    this.#panel = panel;
    this.#host = host;
    this.#height = height;
    this.#x = extent(panel, "x");
    this.#y = extent(panel, "y");
    host.style.setProperty("--plot-height", `${height}px`);
    if (this.isEmpty) return;
    const forget = onTheme(() => this.#plot?.redraw(false));
    const gone = () => {
      forget();
      this.#plot?.destroy();
    };
    whileOnPage(host, (width) => this.#resize(width), gone);
  }

  /** Switches the series with a label off or on. @param {string} label @returns {boolean} it is on now */
  toggle(label) {
    if (!this.#off.delete(label)) this.#off.add(label);
    this.#plot?.redraw(false);
    return !this.#off.has(label);
  }

  get isEmpty() {
    return !this.#x || !this.#y;
  }

  /** @param {number} width */
  #resize(width) {
    if (!this.#x || !this.#y) return;
    if (!this.#plot) this.#plot = this.#make(width, this.#x, this.#y);
    else if (width !== this.#plot.width) this.#plot.setSize({ width, height: this.#plot.height });
  }

  /** @param {number} width @param {Extent} x @param {Extent} y */
  #make(width, x, y) {
    const { names } = this.#panel.x;
    const labels = fitted(names, (width - Y_AXIS - RIGHT) / Math.max(1, names.length));
    const more = LINE * Math.max(0, ...labels.map((label) => label.split("\n").length - 1));
    const plot = new uPlot(
      {
        width,
        height: this.#height + more,
        legend: { show: false },
        cursor: { show: false },
        scales: {
          x: { time: false, distr: this.#panel.x.scale === "Log" ? 3 : 1, range: () => [x.low, x.high] },
          y: { distr: this.#panel.y.scale === "Log" ? 3 : 1, range: () => [y.low, y.high] },
        },
        axes: [
          {
            ...axisStyle(),
            ...ticksOf({ ...this.#panel.x, names: labels }, x, "x", (u) => (u.width - Y_AXIS - RIGHT) / X_LABELS),
            size: 34 + more,
            lineGap: 1.2,
            label: this.#panel.x.label || undefined,
            labelSize: this.#panel.x.label ? 22 : 0,
            labelFont: "12px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif",
          },
          { ...axisStyle(), ...ticksOf(this.#panel.y, y, "y", () => (this.#height - 64) / Y_LABELS), size: Y_AXIS },
        ],
        series: [{}, { paths: () => null, points: { show: false } }],
        padding: [this.#panel.shading.some(({ ranges }) => ranges.some((range) => range.mark)) ? 18 : 8, RIGHT, 0, 0],
        hooks: { drawClear: [(u) => shade(u, this.#panel)], draw: [(u) => this.#shapes(u)] },
      },
      [
        [x.low, x.high],
        [y.low, y.high],
      ],
      this.#host,
    );
    const isShown = (/** @type {FigureSeries} */ series) => !this.#off.has(series.label);
    plot.over.addEventListener("pointermove", ({ clientX, clientY }) => {
      const { left, top } = plot.over.getBoundingClientRect();
      this.#reading.textContent = readingAt(plot, this.#panel, isShown, clientX - left, clientY - top);
    });
    plot.over.addEventListener("pointerleave", () => (this.#reading.textContent = ""));
    return plot;
  }

  /** @param {uPlot} u */
  #shapes(u) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const { label, ink, shape } of this.#panel.series) {
      if (this.#off.has(label)) continue;
      const property = `--${inkClass(ink)}`;
      drawShape(u, shape, { full: colour(property), faint: faint(property, 0.26) });
    }
    ctx.restore();
  }
}

/** Names as they fit into `room` pixels each: folded into lines, or else their numbers. @param {string[]} names @param {number} room */
function fitted(names, room) {
  const folded = names.map((name) => name.replaceAll(/(?<=\w)[_ ]/g, "\n"));
  const widest = Math.max(0, ...folded.flatMap((name) => name.split("\n")).map((line) => line.length));
  return widest * LETTER <= room ? folded : names.map((_, place) => String(place));
}

/**
 * Marks of an axis for the chart library, which asks for places first and texts afterwards.
 * @param {FigureAxis} axis @param {Extent} range @param {"x" | "y"} scale @param {(u: uPlot) => number} count
 */
function ticksOf(axis, range, scale, count) {
  const named = axis.names.map((label, value) => ({ value, label }));
  const ticks = (/** @type {uPlot} */ u) => {
    if (named.length > 0) return named;
    return axis.scale === "Log" ? logTicks(range.low, range.high, count(u)) : linearTicks(range.low, range.high, count(u));
  };
  return {
    splits: (/** @type {uPlot} */ u) => ticks(u).map((tick) => tick.value),
    values(/** @type {uPlot} */ u, /** @type {number[]} */ at) {
      const place = (/** @type {number} */ value) => u.valToPos(value, scale);
      const kept = named.length > 0 ? named : scale === "x" ? spaced(ticks(u), place, widthOf, u.width - Y_AXIS) : spaced(ticks(u), place, () => LABEL);
      return at.map((value) => kept.find((tick) => tick.value === value)?.label ?? "");
    },
    filter: (/** @type {uPlot} */ _, /** @type {number[]} */ at) => at,
  };
}

/** @param {uPlot} u @param {Panel} panel */
function shade(u, panel) {
  const { ctx, bbox } = u;
  const { min, max } = u.scales.x ?? {};
  for (const shading of panel.shading) paint(u, shading);
  ctx.save();
  ctx.font = `600 ${12 * uPlot.pxRatio}px system-ui, sans-serif`;
  ctx.textAlign = "center";
  ctx.fillStyle = colour("--shade-mark");
  for (const shading of panel.shading) {
    for (const range of within(shading, min ?? -Infinity, max ?? Infinity)) {
      if (range.mark) ctx.fillText(range.mark, placeOf(u, range).middle, bbox.top - 5 * uPlot.pxRatio);
    }
  }
  ctx.restore();
}
