// @ts-check
// Light or dark theme, and the colours of the style sheet for canvases.

import { radioGroup } from "./dom.js";

const STORED = "fos-theme";
const dark = matchMedia("(prefers-color-scheme: dark)");

/** @type {Set<() => void>} */
const listeners = new Set();
/** @type {Map<string, string>} */
const known = new Map();

/** Redraws a canvas when the theme changes. @param {() => void} redraw @returns {() => void} stops that */
export function onTheme(redraw) {
  listeners.add(redraw);
  return () => listeners.delete(redraw);
}

function changed() {
  known.clear();
  for (const redraw of listeners) redraw();
}

dark.addEventListener("change", changed);

/**
 * Present colour of a custom property.
 * @param {string} property
 */
export function colour(property) {
  const found = known.get(property);
  if (found) return found;
  const probe = document.createElement("span");
  probe.style.color = `var(${property})`;
  document.body.append(probe);
  const value = getComputedStyle(probe).color;
  probe.remove();
  known.set(property, value);
  return value;
}

/** The same colour with transparency. @param {string} property @param {number} alpha */
export function faint(property, alpha) {
  return colour(property).replace(/^rgb\(([^)]+)\)$/, (_, channels) => `rgba(${channels}, ${alpha})`);
}

/** The switch in the top bar. */
export function themeSwitch() {
  return radioGroup({
    legend: "Theme",
    name: "theme",
    class: "theme",
    options: [
      { value: "auto", text: "Auto", hint: "As the system" },
      { value: "light", text: "Light" },
      { value: "dark", text: "Dark" },
    ],
    chosen: document.documentElement.dataset.theme ?? "auto",
    choose(value) {
      document.documentElement.dataset.theme = value;
      if (value === "auto") localStorage.removeItem(STORED);
      else localStorage.setItem(STORED, value);
      changed();
    },
  });
}
