// @ts-check
// A study after a restart of the server: the open page shows it again without a reload.

import assert from "node:assert/strict";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { IS_REAL, SLOW, add, atRest, closePage, openExample, openPage, startBrowser, startIn } from "./workbench.js";

test("a study with an added effect survives a restart of the server", { timeout: 3 * SLOW, skip: IS_REAL ? false : "needs the program" }, async () => {
  const folder = await mkdtemp(join(tmpdir(), "fos-workbench-"));
  const browser = await startBrowser();
  let server = await startIn(folder);
  try {
    const page = await openPage(browser, server);
    await openExample(page);
    await add(page, "thermal_lag");
    await page.waitForSelector(".replay .digest", { timeout: SLOW });
    const shown = async () => [await page.locator(".study h1").innerText(), await page.locator("[data-step]").allInnerTexts(), await page.locator(".replay .digest").innerText()];
    const before = await shown();

    await server.stop();
    await page.waitForSelector('.job[data-state="lost"]');
    server = await startIn(folder, new URL(server.url).port);
    await page.waitForSelector('.job:not([data-state="lost"])', { timeout: SLOW });
    await page.waitForSelector('[data-step="thermal_lag"]', { timeout: SLOW });
    await atRest(page);
    await page.waitForSelector(".replay .digest", { timeout: SLOW });
    assert.deepEqual(await shown(), before);
    await page.reload();
    await page.waitForSelector('[data-step="thermal_lag"]', { timeout: SLOW });

    // closed, it does not come back
    await page.locator('[data-key="close:1"]').click();
    await page.waitForSelector(".opening");
    await server.stop();
    server = await startIn(folder, new URL(server.url).port);
    await page.reload();
    await page.waitForSelector(".opening");
    assert.equal(await page.locator(".tab").count(), 0);
    await closePage(page);
  } finally {
    await browser.close();
    await server.stop();
    await rm(folder, { recursive: true, force: true });
  }
});
