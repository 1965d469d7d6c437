// @ts-check
// The library of effects, read once: names for identifiers.

import { get } from "./api.js";

/** @typedef {import("./types.js").Effect} Effect */

/** @type {Map<string, Effect>} */
const effects = new Map();

/** Reads the library; without it, identifiers stand for names. */
export async function readLibrary() {
  if (effects.size > 0) return;
  for (const effect of /** @type {Effect[]} */ (await get("/api/effects"))) effects.set(effect.id, effect);
}

/** @param {string} id */
export const effectName = (id) => effects.get(id)?.name ?? id.replaceAll("_", " ");

/** @param {string} id */
export const effectOf = (id) => effects.get(id) ?? null;
