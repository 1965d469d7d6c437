// @ts-check
// The address of a study with its axis, view, stretch and time window, so that a link restores them.

/** @typedef {{axis: string | null, view: string | null, window: [number, number] | null, stretch: [number, number] | null}} Place */

/** The study that an address names. @param {string} hash */
export function addressedStudy(hash) {
  const id = /^#\/study\/(\d+)(?:\/columns)?(?:\?|$)/.exec(hash)?.[1];
  return id === undefined ? null : Number(id);
}

/** The address of the columns of a study. @param {number} id */
export const columnsAddress = (id) => `#/study/${id}/columns`;

/** @param {string} hash */
export const isOfColumns = (hash) => /^#\/study\/\d+\/columns$/.test(hash);

/** @param {string} hash @returns {Place} */
export function placeOf(hash) {
  const query = new URLSearchParams(hash.split("?")[1] ?? "");
  const span = (/** @type {string} */ name) => {
    const [from, to] = (query.get(name) ?? "").split("_").map(Number.parseFloat);
    return from !== undefined && to !== undefined && from < to ? /** @type {[number, number]} */ ([from, to]) : null;
  };
  return { axis: query.get("axis"), view: query.get("view"), window: span("time"), stretch: span("stretch") };
}

/** @param {number} id @param {Place} place */
export function addressOf(id, { axis, view, window, stretch }) {
  const query = new URLSearchParams();
  const set = (/** @type {string} */ name, /** @type {string | null} */ value) => value !== null && query.set(name, value);
  const span = (/** @type {[number, number] | null} */ of) => of && of.map((value) => String(Number(value.toFixed(3)))).join("_");
  set("axis", axis);
  set("view", view);
  set("time", span(window));
  set("stretch", span(stretch));
  return `#/study/${id}${query.size > 0 ? `?${query}` : ""}`;
}
