// @ts-check
// How numbers and axes are written; needs no browser.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";
import { count, firstSentence, number, percent, quantity, raised } from "../../host-fit/workbench/page/format.js";
import { addressOf, addressedStudy, placeOf } from "../../host-fit/workbench/page/address.js";
import { csvOf } from "../../host-fit/workbench/page/downloads.js";
import { meanFor } from "../../host-fit/workbench/page/seriessource.js";
import { figureIn } from "../../host-fit/workbench/page/units.js";
import { linearTicks, logTicks, spaced as thinned } from "../../host-fit/workbench/page/ticks.js";
import { parameterName, parameterValue, withParameters } from "../../host-fit/workbench/page/parameters.js";
import { onPage as inPageTerms } from "../../host-fit/workbench/page/notices.js";
import { TimeWindow } from "../../host-fit/workbench/page/timewindow.js";

const spaced = (/** @type {string} */ text) => text.replaceAll("\u202f", " ");

test("numbers have three digits, a real minus and powers of ten where they are needed", () => {
  assert.equal(number(52.66568), "52.7");
  assert.equal(number(-0.26061), "−0.261");
  assert.equal(number(1271.73), "1272");
  assert.equal(number(3.0912e-7), "3.09×10⁻⁷");
  assert.equal(number(0.000648), "0.000648");
  assert.equal(number(0), "0");
  assert.equal(number(null), "–");
  assert.equal(number(Number.NaN), "–");
});

test("quantities have their unit", () => {
  assert.equal(spaced(quantity(0.0033094, "rad/s")), "0.00331 rad/s");
  assert.equal(spaced(quantity(0, "°/s")), "0 °/s");
  assert.equal(quantity(null, "°/s"), "–");
});

test("a figure in field units keeps its values and states their unit", () => {
  const axis = (/** @type {string} */ label) => ({ label, scale: /** @type {const} */ ("Linear"), names: [] });
  /** @type {import("../../host-fit/workbench/page/types.js").Figure} */
  const figure = {
    title: "",
    panels: [
      { title: "", x: axis("Time (s)"), y: axis("Residual (rad/s)"), series: [{ label: "", ink: "Residual", shape: { Line: [[1, Math.PI], [2, null]] } }], shading: [] },
      { title: "", x: axis("Frequency (Hz)"), y: axis("Power spectral density ((rad/s)²/Hz)"), series: [{ label: "", ink: "Residual", shape: { Level: Math.PI ** 2 } }], shading: [] },
    ],
  };
  const [time, density] = figureIn(figure, "rad/s", { label: "°/s", divisor: Math.PI / 180 }).panels;
  assert.equal(time?.y.label, "Residual (°/s)");
  assert.deepEqual(time?.series[0]?.shape, { Line: [[1, 180], [2, null]] });
  assert.equal(density?.y.label, "Power spectral density ((°/s)²/Hz)");
  const level = density?.series[0]?.shape;
  assert.ok(level && "Level" in level && Math.abs(level.Level - 180 ** 2) < 1e-6);
});

test("an address names axis, view, time and stretch, and a broken one names the study alone", () => {
  const place = { axis: "gx_rads", view: "coast", window: /** @type {[number, number]} */ ([10, 20.5]), stretch: /** @type {[number, number]} */ ([12, 13]) };
  const address = addressOf(3, place);
  assert.equal(addressedStudy(address), 3);
  assert.deepEqual(placeOf(address), place);
  assert.equal(addressOf(3, { axis: null, view: null, window: null, stretch: null }), "#/study/3");
  assert.deepEqual(placeOf("#/study/3?time=5_x&stretch=9_2"), { axis: null, view: null, window: null, stretch: null });
  assert.equal(addressedStudy("#/study/x"), null);
});

test("means follow the zoom in steps of 1, 2 and 5", () => {
  assert.deepEqual([10, 1500, 2500, 7200, 184_000].map(meanFor), [1, 1, 2, 5, 100]);
});

test("a figure is saved with a row for each value", () => {
  const axis = (/** @type {string} */ label) => ({ label, scale: /** @type {const} */ ("Linear"), names: [] });
  const series = [{ label: 'residual, "after"', ink: /** @type {const} */ ("Residual"), shape: { Band: /** @type {[number, number, number][]} */ ([[1, 2, 3]]) } }];
  assert.equal(csvOf({ title: "", panels: [{ title: "", x: axis("Time (s)"), y: axis("Error (mg)"), series, shading: [] }] }), 'series,Time (s),Error (mg),low,high\n"residual, ""after""",1,,2,3\n');
});

test("counts are grouped, shares are percent", () => {
  assert.equal(spaced(count(181_900)), "181 900");
  assert.equal(count(2888), "2888");
  assert.equal(spaced(percent(0.95238)), "95.2 %");
});

test("a first sentence ends where the next begins", () => {
  assert.deepEqual(firstSentence("Off by 0.5 K. Then more. And more."), ["Off by 0.5 K.", "Then more. And more."]);
  assert.deepEqual(firstSentence("One only."), ["One only.", ""]);
});

/** A label of the table in the page's notation. @param {string} label @param {string} scale */
function onPage(label, scale) {
  const [mantissa, exponent] = label.split("e");
  if (exponent === undefined) return label;
  const power = `10${raised(Number(exponent.replace("−", "-")))}`;
  return scale === "Log" && mantissa === "1" ? power : `${mantissa}×${power}`;
}

test("an axis has the marks that a picture of the program has", async () => {
  const table = new URL("../../host-fit/figures/src/ticks.json", import.meta.url);
  /** @type {{scale: string, low: number, high: number, count: number, values: number[], labels: string[]}[]} */
  const cases = JSON.parse(await readFile(table, "utf8"));
  for (const { scale, low, high, count, values, labels } of cases) {
    const named = (scale === "Log" ? logTicks : linearTicks)(low, high, count).filter((tick) => tick.label);
    assert.deepEqual(named.map((tick) => tick.label), labels.map((label) => onPage(label, scale)));
    for (const [at, { value }] of named.entries()) {
      const wanted = Number(values[at]);
      // each is a few roundings from its decimal
      assert.ok(Math.abs(value - wanted) <= 1e-12 * Math.abs(wanted), `${value} is not ${wanted}`);
    }
  }
});

test("what a chart alone is asked for: few pixels, single samples late in a log, and nothing", () => {
  assert.deepEqual(linearTicks(0, 3600, 1).map((tick) => tick.label), ["0", "1000", "2000", "3000"]);
  assert.deepEqual(linearTicks(1000, 1000.0021, 4).map((tick) => tick.label), ["1000.000", "1000.001", "1000.002"]);
  assert.deepEqual(linearTicks(1000, 1000.0011, 5).map((tick) => tick.label), ["1000.0000", "1000.0005", "1000.0010"]);
  for (const tick of linearTicks(-0.37, 12.2, 7)) assert.ok(tick.value >= -0.37 && tick.value <= 12.2);
  assert.deepEqual(linearTicks(1, 1, 5), []);
  assert.deepEqual(logTicks(0, 1, 4), []);
});

test("labels that would overlap or pass the end of the canvas are omitted", () => {
  const ticks = linearTicks(0, 40, 4);
  const labels = (/** @type {number} */ pixels, end = Infinity) => thinned(ticks, (value) => value * pixels, (label) => 7 * label.length, end).map(({ label }) => label);
  assert.deepEqual(labels(10), ["0", "10", "20", "30", "40"]);
  assert.deepEqual(labels(1), ["0", "20", "40"]);
  assert.deepEqual(labels(10, 402), ["0", "10", "20", "30"]);
  // a log that begins late: round numbers stay
  const late = linearTicks(10, 50, 4);
  assert.deepEqual(thinned(late, (value) => value, () => 12).map(({ label }) => label), ["20", "40"]);
});

test("parameters are written in words with their units", () => {
  assert.equal(spaced(withParameters("Most likely missing: thermal lag (tau_s = 52.7) and hysteresis (half_width_k = 4.28).")), "Most likely missing: thermal lag (time constant 52.7 s) and hysteresis (half width 4.28 K).");
  assert.equal(spaced(withParameters("Faults of the data: dropped samples (frac = 7.80e-4).")), "Faults of the data: dropped samples (0.078 %).");
  assert.equal(parameterName("frac", "dropped_samples"), "Missing samples");
  assert.equal(parameterName("freq_hz"), "Frequency");
  assert.equal(spaced(parameterValue("freq_hz", 116.16)), "116 Hz");
});

test("messages name the buttons of the page, not the options of the library", () => {
  assert.equal(inPageTerms("or read the log with `keep_moved` if the device did lie still"), "or press Include these rows if the device did lie still");
  assert.equal(inPageTerms("record 10 min at rest and pass it as `reference`"), "record 10 min at rest and choose it as reference log under Columns…");
});

test("a whole log is whole, although sums of its times are rounded", () => {
  const real = globalThis.requestAnimationFrame;
  globalThis.requestAnimationFrame = () => 0;
  try {
    const time = new TimeWindow();
    // the span of these is rounded so that begin and span end before the last sample
    for (let n = 1; n < 1000; n += 1) {
      time.reset([n / 7, n / 7 + n / 3], 0.01);
      assert.ok(time.isWhole, String(n));
    }
  } finally {
    globalThis.requestAnimationFrame = real;
  }
});
