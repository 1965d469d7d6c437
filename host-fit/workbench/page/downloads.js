// @ts-check
// A figure as CSV and as SVG.

import { messageOf } from "./api.js";
import { el } from "./dom.js";

/** @typedef {import("./types.js").Figure} Figure */
/** @typedef {import("./types.js").Shape} Shape */
/** @typedef {number | null} Num */

/** Buttons that save the figure. @param {() => Figure | null} figure */
export function downloads(figure) {
  const button = (/** @type {string} */ text, /** @type {(figure: Figure) => Promise<Blob> | Blob} */ write) => {
    const act = async () => {
      const drawn = figure();
      if (!drawn) return;
      try {
        save(`${drawn.title.toLowerCase().replace(/[^a-z0-9]+/g, "_").replace(/^_|_$/g, "").slice(0, 60)}.${text.toLowerCase()}`, await write(drawn));
        save_.textContent = text;
      } catch (error) {
        save_.textContent = `${text}: ${messageOf(error)}`;
      }
    };
    const save_ = el("button", { type: "button", class: "link save", title: `Save this figure as ${text}`, onclick: () => void act() }, text);
    return save_;
  };
  return el("span", { class: "saves" }, button("CSV", (drawn) => new Blob([csvOf(drawn)], { type: "text/csv" })), button("SVG", svgOf));
}

/** @param {string} name @param {Blob} content */
function save(name, content) {
  const href = URL.createObjectURL(content);
  el("a", { href, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(href), 10_000);
}

/** One row for each value. @param {Figure} figure */
export function csvOf(figure) {
  const quoted = (/** @type {string} */ text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const lines = figure.panels.flatMap((panel) => {
    const head = ["series", panel.x.label || "step", panel.y.label, "low", "high"];
    const rows = panel.series.flatMap(({ label, shape }) => cells(shape).map((row) => [quoted(label), ...row.map((value) => value ?? "")]));
    return [head.map(quoted), ...rows].map((row) => row.join(","));
  });
  return `${lines.join("\n")}\n`;
}

/** x, y, low, high of every entry. @param {Shape} shape @returns {Num[][]} */
function cells(shape) {
  if ("Level" in shape) return [[null, shape.Level, null, null]];
  if ("Band" in shape) return shape.Band.map(([x, low, high]) => [x, null, low, high]);
  if ("Bars" in shape) return shape.Bars;
  if ("Cells" in shape || "Frames" in shape) return ("Cells" in shape ? shape.Cells : shape.Frames).flatMap(([left, right, low, high]) => [[left, null, low, high], [right, null, low, high]]);
  const points = "Line" in shape ? shape.Line : "Points" in shape ? shape.Points : shape.Stems;
  return points.map(([x, y]) => [x, y, null, null]);
}

/** Drawn by the server, as `--figures` does on the command line. @param {Figure} figure */
async function svgOf(figure) {
  const response = await fetch("/api/draw", {
    method: "POST",
    headers: { "x-fos-workbench": "1", "content-type": "application/json" },
    body: JSON.stringify({ ...figure, panels: figure.panels.map((panel) => ({ ...panel, series: panel.series.flatMap(known) })) }),
  });
  if (!response.ok) throw new Error((await response.json()).error ?? response.statusText);
  return response.blob();
}

/** The pieces of a series between unknown values. @param {import("./types.js").Series} series @returns {import("./types.js").Series[]} */
function known(series) {
  const { shape } = series;
  if ("Level" in shape) return [series];
  const [kind, values] = /** @type {[string, Num[][]]} */ (Object.entries(shape)[0]);
  /** @type {Num[][][]} */
  const pieces = [[]];
  for (const value of values) {
    if (value.every((number) => number !== null)) pieces[pieces.length - 1]?.push(value);
    else if (pieces[pieces.length - 1]?.length) pieces.push([]);
  }
  return pieces.filter((piece) => piece.length > 0).map((piece) => ({ ...series, shape: /** @type {Shape} */ (/** @type {unknown} */ ({ [kind]: piece })) }));
}
