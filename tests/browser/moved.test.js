// @ts-check
// A unit that was knocked: where it is left out is shaded and told, and it can be taken back and left out again.

import assert from "node:assert/strict";
import { test } from "node:test";
import { SLOW, assertAccessible, atRest, bench, closePage, csvFile, plotOf, shownBy, stateOf, unusualCsv } from "./workbench.js";

const workbench = bench();

/** When it is knocked, s; each knock rings for 0.3 s. */
const KNOCKS = [30, 62];

/** The log of the other tests, with knocks. */
function knockedCsv() {
  const [head, ...rows] = unusualCsv().split("\n");
  const knocked = rows.map((row) => {
    const [time = 0, ...values] = row.split(",").map(Number);
    const since = KNOCKS.map((knock) => time / 1000 - knock).find((elapsed) => elapsed >= 0 && elapsed < 0.3);
    if (since === undefined) return row;
    const ring = Math.sin(300 * since);
    return [time, ...values.map((value, at) => value + (at < 3 ? 5000 : 0.2) * ring)].join(",");
  });
  return [head, ...knocked].join("\n");
}

/** The colours of the chart over time of a part, at a time, from its upper edge eight pixels down. @param {import("playwright-core").Page} page @param {number} part @param {number} at seconds */
async function coloursAt(page, part, at) {
  const [from, to] = await shownBy(page);
  return page.locator(`[data-part="${part}"] .time-chart`).first().evaluate((chart, share) => {
    const canvas = /** @type {HTMLCanvasElement} */ (chart.querySelector("canvas"));
    const [outer, over] = [canvas.getBoundingClientRect(), /** @type {Element} */ (chart.querySelector(".u-over")).getBoundingClientRect()];
    const scale = canvas.width / outer.width;
    const x = (over.left - outer.left + share * over.width) * scale;
    const y = (over.top - outer.top) * scale;
    return [.../** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d")).getImageData(Math.round(x), Math.round(y), 1, Math.round(8 * scale)).data].join(" ");
  }, (at - from) / (to - from));
}

test("where the unit was moved is shaded, told on hover, taken back and left out again", { timeout: 3 * SLOW }, async () => {
  const page = await workbench.open();
  const server = await workbench.server;
  await page.setInputFiles('input[type="file"]', [csvFile("knocked.csv", knockedCsv())]);
  await page.getByRole("button", { name: "Read the log" }).click();
  await page.waitForSelector(".time-chart canvas", { timeout: SLOW });
  await atRest(page);

  const left = await stateOf(page, server);
  const ranges = left.logs?.log.moved.ranges ?? [];
  assert.equal(ranges.length, KNOCKS.length, JSON.stringify(ranges));
  assert.equal(left.keeps_moved, false);
  const middle = (/** @type {number} */ at) => 0.5 * (Number(ranges[at]?.from) + Number(ranges[at]?.to));
  const entry = (/** @type {number} */ part) => page.locator(`[data-part="${part}"] .time-chart`).first().locator("xpath=..").locator(".legend .ink-left-out");
  for (const part of [1, 2]) {
    assert.match(await entry(part).innerText(), /^excluded: detected motion/);
    const usual = await coloursAt(page, part, 45);
    for (const at of [0, 1]) assert.notEqual(await coloursAt(page, part, middle(at)), usual, `part ${part}, knock ${at}`);
  }
  const { x, y, width } = await plotOf(page);
  const [from, to] = await shownBy(page);
  await page.mouse.move(x + (width * (middle(1) - from)) / (to - from), y);
  await page.waitForFunction(() => /knock at 6\d\.\d s for/.test(document.querySelector('[data-part="1"] .legend .ink-left-out')?.textContent ?? ""));
  await page.mouse.move(x + (width * (45 - from)) / (to - from), y);
  await page.waitForFunction(() => !/knock at/.test(document.querySelector('[data-part="1"] .legend .ink-left-out')?.textContent ?? ""));
  await assertAccessible(page, "a study of a unit that was moved");

  const turn = page.locator('[data-key="moved"]');
  assert.match(await turn.innerText(), /Include these rows/);
  await turn.click();
  await page.locator('[data-key="moved"]', { hasText: "Exclude them" }).waitFor({ timeout: SLOW });
  await atRest(page);
  const kept = await stateOf(page, server);
  assert.equal(kept.keeps_moved, true);
  assert.deepEqual(kept.logs?.log.moved.ranges, []);
  assert.equal(await page.locator(".legend .ink-left-out").count(), 0);
  assert.equal(await coloursAt(page, 1, middle(0)), await coloursAt(page, 1, 45));
  assert.ok(kept.commands.filter((command) => /^fos (fit|compare|diagnose|replay) /.test(command)).every((command) => command.includes("--keep-moved")), kept.commands.join("\n"));
  assert.equal(kept.axis, left.axis, "the same axis is looked at");

  await turn.click();
  await page.locator('[data-key="moved"]', { hasText: "Include these rows" }).waitFor({ timeout: SLOW });
  await atRest(page);
  const again = await stateOf(page, server);
  assert.deepEqual(again.axes, left.axes, "all is as it was, to the last digit");
  assert.equal(await entry(1).count(), 1);
  await closePage(page);
});
