// @ts-check
// Writes docs/workbench/*.png: every part of the page that docs show, of the built-in example; one card in light and dark.

import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { ROOT, SLOW, add, closePage, csvFile, openExample, openPage, startBrowser, startServer, unusualCsv } from "./workbench.js";

const FOLDER = join(ROOT, "docs/workbench");
const PARTS = ["measured", "fails", "missing", "falls", "take"];
/** Tall enough that the bars at the top cover nothing. */
const TALL = 3200;

await mkdir(FOLDER, { recursive: true });
const server = await startServer();
const browser = await startBrowser();
try {
  for (const theme of /** @type {const} */ (["light", "dark"])) {
    const file = (/** @type {string} */ name) => ({ path: join(FOLDER, `${name}_${theme}.png`) });
    const page = await openPage(browser, server, { theme });
    if (theme === "dark") {
      await openExample(page);
      await page.setViewportSize({ width: 1440, height: TALL });
      await page.locator(".finding").first().screenshot(file("3_card"));
      await closePage(page);
      continue;
    }
    await page.screenshot(file("0_open"));
    const [header, ...rows] = unusualCsv().split("\n");
    const withMore = [`${header},something`, ...rows.slice(0, 2000).map((row) => `${row},7`)];
    await page.setInputFiles('input[type="file"]', [csvFile("unit.csv", withMore.join("\n"))]);
    await page.locator(".mapping table").waitFor();
    await page.locator(".mapping").screenshot(file("0_mapping"));
    await page.reload();
    await openExample(page);
    await page.waitForSelector(".panels .figure");
    await page.waitForTimeout(500);
    const shoot = async (/** @type {number} */ part) => {
      await page.setViewportSize({ width: 1440, height: TALL });
      await page.waitForTimeout(300);
      await page.locator(`[data-part="${part}"]`).screenshot(file(`${part}_${PARTS[part - 1]}`));
    };
    for (const part of [1, 2, 3]) await shoot(part);
    await page.locator(".finding").first().screenshot(file("3_card"));
    await add(page, "thermal_lag");
    while ((await page.locator(".finding .primary").count()) > 0) {
      const effect = await page.locator(".finding").first().getAttribute("data-effect");
      await add(page, effect ?? "");
    }
    await page.waitForSelector(".replay .digest", { timeout: SLOW });
    for (const part of [4, 5]) await shoot(part);
    await closePage(page);
  }
} finally {
  await browser.close();
  await server.stop();
}
