// @ts-check
// Elements without a framework: created in one expression, replaced without losing focus.

/** @typedef {Node | string | number | null | undefined | false} Child */
/** @typedef {Record<string, string | number | boolean | null | undefined | EventListener>} Attributes */

/**
 * Creates an element. Functions become event listeners (`onclick`); `false` and `null` attributes are omitted.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Attributes} [attributes]
 * @param {...(Child | Child[])} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...nodes(children));
  return element;
}

/** @param {(Child | Child[])[]} children */
function nodes(children) {
  /** @type {(Node | string)[]} */
  const kept = [];
  for (const child of children.flat()) {
    if (child === null || child === undefined || child === false || child === "") continue;
    kept.push(typeof child === "number" ? String(child) : child);
  }
  return kept;
}

/**
 * Replaces all children. Elements with the same `data-key` keep focus and stay unfolded. If the focused element is gone,
 * the heading of its section gets the focus, so that keyboard users are not sent back to the top.
 * @param {Element} parent
 * @param {...(Child | Child[])} children
 */
export function replace(parent, ...children) {
  const active = parent.contains(document.activeElement) ? /** @type {HTMLElement} */ (document.activeElement) : null;
  const key = active?.closest("[data-key]")?.getAttribute("data-key");
  const unfolded = new Set([...parent.querySelectorAll("details[open][data-key]")].map(keyOf));
  parent.replaceChildren(...nodes(children));
  for (const details of parent.querySelectorAll("details[data-key]")) {
    if (unfolded.has(keyOf(details))) details.setAttribute("open", "");
  }
  if (!active) return;
  const heir = key ? [...parent.querySelectorAll("[data-key]")].find((element) => keyOf(element) === key) : null;
  if (heir instanceof HTMLElement) {
    (heir instanceof HTMLDetailsElement ? heir.querySelector("summary") : heir)?.focus({ preventScroll: true });
  } else {
    parent.closest("section")?.querySelector("h2")?.focus({ preventScroll: true });
  }
}

/** @param {Element} element */
const keyOf = (element) => element.getAttribute("data-key");

/** Outlines on a grid of 24 units. */
const ICONS = {
  missing: "M12 3.5 22 20.5H2Z M12 10v5 M12 17.6v.4",
  nothing_missing: "M12 2.5a9.5 9.5 0 1 0 0 19 9.5 9.5 0 0 0 0-19Z M7.5 12.3l3.2 3.2 6-6.7",
  unexplained: "M12 2.5 21.5 12 12 21.5 2.5 12Z M9.6 9.8a2.5 2.5 0 1 1 3.6 2.2c-.8.4-1.2.9-1.2 1.8 M12 16.6v.4",
  not_enough_data: "M12 2.5a9.5 9.5 0 1 0 0 19 9.5 9.5 0 0 0 0-19Z M7.5 12h9",
  did_not_pay: "M12 2.5a9.5 9.5 0 1 0 0 19 9.5 9.5 0 0 0 0-19Z M8 8l8 8 M16 8l-8 8",
  data_fault: "M5 5.5c0-1.7 3.1-3 7-3s7 1.3 7 3-3.1 3-7 3-7-1.3-7-3Z M5 5.5v13c0 1.7 3.1 3 7 3s7-1.3 7-3v-13 M12 11.5v4 M12 18v.4",
  held: "M5 12.5l4.5 4.5L19 7.5",
  not_held: "M6 6l12 12 M18 6 6 18",
  drop: "M12 3v12 M7 10.5l5 5 5-5 M4 17v3.5h16V17",
  caution: "M12 2.5a9.5 9.5 0 1 0 0 19 9.5 9.5 0 0 0 0-19Z M12 7v6 M12 16.4v.4",
  close: "M6 6l12 12 M18 6 6 18",
};

/** @typedef {keyof typeof ICONS} IconName */

/**
 * An icon next to a word, never in its place.
 * @param {IconName} name
 */
export function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("class", `icon icon-${name}`);
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", ICONS[name]);
  svg.append(path);
  return svg;
}

let unique = 0;

/**
 * A unique element id.
 * @param {string} stem
 */
export function uniqueId(stem) {
  unique += 1;
  return `${stem}-${unique}`;
}

/**
 * A group of radio buttons.
 * @param {{legend: string, name: string, options: {value: string, text: string, hint?: string, extra?: Child}[], chosen: string | null, choose: (value: string) => void, class?: string}} options
 */
export function radioGroup({ legend, name, options, chosen, choose, class: kind = "" }) {
  const entry = (/** @type {typeof options[number]} */ option) =>
    el(
      "label",
      { title: option.hint },
      el("input", {
        type: "radio",
        name,
        value: option.value,
        "data-key": `${name}:${option.value}`,
        checked: option.value === chosen,
        onchange: () => choose(option.value),
      }),
      el("span", {}, option.text, option.extra),
    );
  return el("fieldset", { class: `choice ${kind}` }, el("legend", { class: "unseen" }, legend), options.map(entry));
}
