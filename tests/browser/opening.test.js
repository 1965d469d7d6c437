// @ts-check
// Logs of one's own: columns of any name, files that are no logs, and the way out of a long fit.

import assert from "node:assert/strict";
import { test } from "node:test";
import { SLOW, assertAccessible, assertNoOverflow, atRest, bench, closePage, csvFile, openExample, stateOf, unusualCsv } from "./workbench.js";

const workbench = bench();

/** Drops files where the panel asks for them. @param {import("playwright-core").Page} page @param {{name: string, buffer: Buffer}[]} files */
async function drop(page, files) {
  const given = await page.evaluateHandle((all) => {
    const transfer = new DataTransfer();
    for (const { name, text } of all) transfer.items.add(new File([text], name, { type: "text/csv" }));
    return transfer;
  }, files.map(({ name, buffer }) => ({ name, text: buffer.toString() })));
  await page.dispatchEvent(".drop", "drop", { dataTransfer: given });
}

test("columns in mdps and g are guessed, shown and read", { timeout: SLOW }, async () => {
  const page = await workbench.open();
  await drop(page, [csvFile("unit.csv", unusualCsv())]);
  await page.waitForSelector(".mapping table");
  const guess = async (/** @type {string} */ column) => {
    const row = page.locator(`[data-column="${column}"]`);
    const selects = row.locator("select");
    return [await selects.nth(0).inputValue(), await selects.nth(1).inputValue()];
  };
  assert.deepEqual(await guess("gyro_x"), ["gx_rads", "mdps"]);
  assert.deepEqual(await guess("acc_z"), ["az_mps2", "g"]);
  assert.equal((await guess("time_ms"))[0], "t_s");
  assert.ok((await page.locator('[data-column="gyro_x"] .why').innerText()).length > 3, "the reason is told");
  await assertAccessible(page, "the mapping");
  await page.getByRole("button", { name: "Read the log" }).click();
  await page.waitForSelector(".time-chart canvas", { timeout: SLOW });
  await page.waitForFunction(() => document.querySelector(".study-head")?.textContent?.includes("unit.csv"));
  await closePage(page);
});

test("a broken log is told of in full, and nothing else is lost", { timeout: 2 * SLOW }, async () => {
  const page = await workbench.open();
  await openExample(page);
  const study = page.url().split("?")[0] ?? "";
  await page.locator('[data-key="tab:new"]').click();
  await page.waitForSelector(".opening");
  await drop(page, [csvFile("broken.csv", "t_s,gx_rads\n0.000,0.1\n0.005\n0.010,abc\n")]);
  const alert = page.locator('.alert[role="alert"]');
  const read = page.getByRole("button", { name: "Read the log" });
  // some files only show when they are read that they are none
  await alert.or(read).first().waitFor();
  if (await read.isVisible()) await read.click();
  await alert.first().waitFor({ timeout: SLOW });
  const text = await alert.first().innerText();
  assert.match(text, /broken\.csv/);
  assert.ok(text.split("\n").filter((line) => line.trim()).length >= 2, `what is wrong, and what to do: ${text}`);
  await page.locator(`.tabs a[href="${study.replace(/^[^#]*/, "")}"]`).click();
  await atRest(page);
  assert.equal(await page.locator(".finding").first().getAttribute("data-effect"), "thermal_lag");
  await closePage(page);
});

test("a log without sensor columns stays at the mapping until one is chosen", { timeout: SLOW }, async () => {
  const page = await workbench.open();
  const rows = unusualCsv().split("\n").slice(1);
  await drop(page, [csvFile("unknown.csv", ["time_ms,c1,c2,c3,c4,c5,c6", ...rows.map((row) => row.split(",").map((value, at) => (at === 0 ? value : String(Number(value) * 1000 + 7))).join(","))].join("\n"))]);
  await page.waitForSelector(".mapping table");
  for (const column of ["c1", "c2", "c3", "c4", "c5", "c6"]) await page.locator(`[data-column="${column}"] select`).first().selectOption("");
  const read = page.getByRole("button", { name: "Read the log" });
  await page.getByText(/No column is a gyro or an accelerometer/).waitFor();
  assert.equal(await read.getAttribute("aria-disabled"), "true");
  await read.click({ force: true });
  assert.match(page.url(), /#\/open$/, "the log is not read");
  await assertAccessible(page, "a mapping without a sensor");
  await page.locator('[data-column="c1"] select').first().selectOption("gx_rads");
  assert.equal(await read.getAttribute("aria-disabled"), "false");
  await closePage(page);
});

test("a log that cannot be read leads back to its columns", { timeout: SLOW }, async () => {
  const page = await workbench.open();
  // no column of time, and no sampling rate is given
  await drop(page, [csvFile("timeless.csv", `gx_rads,gy_rads\n${"0.1,0.2\n0.2,0.1\n".repeat(500)}`)]);
  const read = page.getByRole("button", { name: "Read the log" });
  await read.waitFor();
  await read.click();
  await page.locator(".study-error .alert").waitFor({ timeout: SLOW });
  await page.locator('[data-key="columns"]').click();
  await page.waitForSelector(".picked li");
  assert.match(await page.locator(".picked").innerText(), /timeless\.csv/);
  await closePage(page);
});

/** A log of raw 16-bit counts with names of the log format: 32768 is zero. */
function countsCsv() {
  const [, ...rows] = unusualCsv().split("\n");
  const counts = rows.map((row) => {
    const [time = 0, ...values] = row.split(",").map(Number);
    return [time / 1000, ...values.map((value, at) => 32768 + Math.round(at < 3 ? value / 4.375 : value * 2048))].join(",");
  });
  return ["t_s,gx_rads,gy_rads,gz_rads,ax_mps2,ay_mps2,az_mps2", ...counts].join("\n");
}

test("raw counts get a caution, and columns are corrected after reading", { timeout: 2 * SLOW }, async () => {
  const page = await workbench.open();
  const server = await workbench.server;
  await drop(page, [csvFile("counts.csv", countsCsv())]);
  await page.waitForSelector(".mapping table");
  assert.match(await page.locator('[data-column="az_mps2"] .values-caution').innerText(), /gravity is 9\.81 m\/s².*scale and offset/s);
  assert.match(await page.locator('[data-column="gx_rads"] .values-caution').innerText(), /faster than a gyro measures/);
  await assertAccessible(page, "a mapping with cautions");
  await page.getByRole("button", { name: "Read the log" }).click();
  await page.waitForSelector(".time-chart canvas", { timeout: SLOW });

  const study = page.url();
  await page.getByRole("link", { name: "Columns…" }).click();
  await page.waitForURL(/\/columns$/);
  await page.waitForSelector(".mapping table");
  assert.equal(await page.locator(".drop").count(), 0, "no other log is opened here");
  await page.locator('[data-column="gx_rads"] .arithmetic').fill("-32768 x 2");
  await page.getByText(/is not scale and offset/).waitFor();
  for (const [column, arithmetic, unit] of [["gx_rads", "-32768*4.375", "mdps"], ["gy_rads", "-32768*4.375", "mdps"], ["gz_rads", "-32768*4.375", "mdps"], ["ax_mps2", "-32768/2048", "g"], ["ay_mps2", "-32768/2048", "g"], ["az_mps2", "-32768/2048", "g"]]) {
    const row = page.locator(`[data-column="${column}"]`);
    await row.locator(".arithmetic").fill(arithmetic ?? "");
    await row.locator("select").nth(1).selectOption(unit ?? "");
  }
  await page.waitForFunction(() => [...document.querySelectorAll(".mapping .values-caution")].every((caution) => caution.textContent === ""));
  await page.getByRole("button", { name: "Read the log again" }).click();
  await page.waitForURL((url) => url.href.split("?")[0] === study.split("?")[0]);
  await atRest(page);
  const state = await stateOf(page, server);
  assert.ok(state.files?.read.columns.includes("az_mps2=az_mps2:-32768/2048:g"), JSON.stringify(state.files));
  const gravity = state.axes.find(({ column }) => column === "az_mps2");
  assert.ok(gravity?.diagnosis, "the study is computed again");

  // the columns are those that were chosen, also after a reload
  await page.getByRole("link", { name: "Columns…" }).click();
  await page.waitForSelector(".mapping table");
  await page.reload();
  await page.waitForSelector(".mapping table");
  assert.equal(await page.locator('[data-column="az_mps2"] .arithmetic').inputValue(), "-32768/2048");
  assert.equal(await page.locator('[data-column="az_mps2"] select').nth(1).inputValue(), "g");
  await closePage(page);
});

test("a short log is not an all-clear", { timeout: SLOW }, async () => {
  const page = await workbench.open();
  await drop(page, [csvFile("short.csv", unusualCsv().split("\n").slice(0, 4001).join("\n"))]);
  await page.getByRole("button", { name: "Read the log" }).click();
  await page.waitForSelector("[data-verdict]", { timeout: SLOW });
  await atRest(page);
  for (const outcome of await page.locator("[data-overview]").evaluateAll((rows) => rows.map((row) => row.getAttribute("data-outcome")))) assert.equal(outcome, "not_enough_data");
  assert.equal(await page.locator("[data-verdict]").getAttribute("data-verdict"), "not_enough_data");
  assert.match(await page.locator("[data-verdict]").innerText(), /What the tests need: .*at rest/);
  assert.equal(await page.locator(".icon-nothing_missing").count(), 0);
  assert.match(await page.title(), /^Not enough data: /);
  await closePage(page);
});

test("a log with a long name fits on a phone", { timeout: SLOW }, async () => {
  const page = await workbench.open({ width: 390 });
  const name = `${"flight_of_the_second_prototype_with_heated_imu_".repeat(3)}full_rate.csv`;
  await drop(page, [csvFile(name, unusualCsv())]);
  await page.getByRole("button", { name: "Read the log" }).click();
  await page.waitForSelector(".replay .digest", { timeout: SLOW });
  for (const width of [390, 768, 1440]) {
    await page.setViewportSize({ width, height: 900 });
    await page.waitForTimeout(200);
    await assertNoOverflow(page, `a log with a long name, ${width} px`);
  }
  await closePage(page);
});

test("what is computed can be cancelled, and gone on with", { timeout: 2 * SLOW }, async () => {
  const page = await workbench.open();
  await openExample(page, "logs");
  const cancel = page.getByRole("button", { name: "Cancel" });
  await cancel.waitFor();
  await cancel.click();
  await page.waitForSelector('.job[data-state="rests"]', { timeout: 20_000 });
  await page.waitForSelector(".study-error .alert");
  assert.equal(await page.locator(".time-chart canvas").first().isVisible(), true, "the log is still shown");
  await page.locator('[data-key="go-on"]').click();
  await atRest(page);
  await closePage(page);
});

for (const theme of /** @type {const} */ (["light", "dark"])) {
  test(`the opening panel is accessible, and nothing overflows: ${theme}`, { timeout: SLOW }, async () => {
    const page = await workbench.open({ theme });
    await assertAccessible(page, "the opening panel");
    const columns = "time,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z,temp,something";
    await drop(page, [csvFile("one.csv", `${columns}\n0,1,2,3,0.01,0.02,0.99,21,7\n5,1,2,3,0.01,0.02,0.99,21,7\n10,1,2,3,0.01,0.02,0.99,21,7\n`)]);
    await page.waitForSelector(".mapping table");
    await assertAccessible(page, "the mapping");
    for (const width of [1440, 1024, 768]) {
      await page.setViewportSize({ width, height: 900 });
      await assertNoOverflow(page, `the mapping, ${width} px`);
    }
    await closePage(page);
  });
}
