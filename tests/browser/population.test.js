// @ts-check
// A population: its tables and figures, one unit beside the others, and from there to its log.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { HOST_FIT, IS_REAL, SLOW, assertAccessible, assertNoOverflow, bench, closePage } from "./workbench.js";

const workbench = bench();
const LOTS = ["W9", "W10"];
const UNITS = 8;

/** Logs of eight units in two lots, one of them empty, and their population, where the workbench runs. */
async function makeFleet() {
  const { folder } = await workbench.server;
  const run = (/** @type {string[]} */ ...line) => execFileSync(HOST_FIT, line, { cwd: folder, stdio: "pipe" });
  for (let unit = 0; unit < UNITS; unit += 1) {
    const lot = join("line", String(LOTS[unit % LOTS.length]));
    mkdirSync(join(folder, lot), { recursive: true });
    run("simulate", join(lot, `unit${unit}.csv`), "--minutes", "1", "--rate", "100", "--seed", String(unit + 1), "--at-rest");
  }
  writeFileSync(join(folder, "line", "W9", "empty.csv"), "");
  run("fleet", "line", "-o", "population.json");
  return folder;
}

test("a population is opened, a unit of it is looked at, and its log is opened", { timeout: 2 * SLOW, skip: !IS_REAL }, async () => {
  const folder = await makeFleet();
  const page = await workbench.open();
  const stored = JSON.parse(readFileSync(join(folder, "population.json"), "utf8"));
  assert.equal(await page.locator('[data-key="population"]').inputValue(), "population.json");
  await page.locator('[data-key="open-population"]').click();
  await page.waitForSelector(".population table");
  // every coefficient of every axis has its row, with the units that it is of
  const rows = page.locator('[aria-label="Scatter of devices and lots"] tbody tr');
  const coefficients = stored.parts[0].axes.flatMap((/** @type {any} */ axis) => axis.population.names.map(() => axis.population.units));
  assert.equal(await rows.count(), coefficients.length);
  assert.deepEqual(await rows.evaluateAll((all) => all.map((row) => Number(row.children[3]?.textContent))), coefficients);
  await page.waitForSelector(".population .figure canvas");
  await page.locator(".choice label", { hasText: "gyro z" }).click();
  await page.locator(".figure-title", { hasText: "gyro z: bias" }).waitFor();

  // one that was not read says why, and has no log to open
  await page.getByRole("link", { name: "W9/empty" }).click();
  await page.getByRole("heading", { name: "Device W9/empty" }).waitFor();
  assert.match(await page.locator(".unit").innerText(), /the file is empty/);

  await page.locator('[data-key="unit"]').selectOption({ label: "W10/unit3, lot W10" });
  await page.locator('[data-key="show-unit"]').click();
  await page.getByRole("heading", { name: "Device W10/unit3" }).waitFor();
  assert.equal(await page.locator(".unit tbody tr").count(), coefficients.length);
  await page.reload();
  await page.getByRole("heading", { name: "Device W10/unit3" }).waitFor();
  for (const width of [1440, 768]) {
    await page.setViewportSize({ width, height: 900 });
    await assertNoOverflow(page, `a population, ${width} px`);
  }
  await assertAccessible(page, "a population");
  await page.locator('[data-key="open-log"]').click();
  await page.waitForURL(/#\/study\//);
  await page.waitForSelector(".time-chart canvas", { timeout: SLOW });
  assert.match(await page.locator(".study-head").innerText(), /unit3\.csv/);
  await closePage(page);

  // what is wrong with it is said in the words of the command line
  rmSync(join(folder, "population.json.rows"));
  const without = await workbench.open();
  assert.equal(await without.locator('[data-key="population"]').count(), 0, "it is not offered");
  await without.evaluate(() => (location.hash = "#/population?path=population.json"));
  await without.locator(".alert", { hasText: "population.json.rows" }).waitFor();
  await closePage(without);
});

test("a population elsewhere, or that is none, is refused", { timeout: SLOW, skip: !IS_REAL }, async () => {
  const { folder, url } = await workbench.server;
  writeFileSync(join(folder, "none.json"), "{}");
  for (const [path, status] of /** @type {[string, number][]} */ ([["/etc/passwd", 403], ["../population.json", 403], ["none.json", 422]])) {
    const answer = await fetch(`${url}api/population?${new URLSearchParams({ path })}`);
    assert.equal(answer.status, status, path);
    assert.match((await answer.json()).error, /help: /);
  }
});
