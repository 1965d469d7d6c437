// @ts-check
// The four answers of a diagnosis, in words: they never differ by colour alone.

/** @type {Record<import("./types.js").Verdict, {word: string, title: string}>} */
export const VERDICTS = {
  missing: { word: "an effect is missing", title: "Missing" },
  nothing_missing: { word: "nothing is missing", title: "Nothing is missing" },
  not_enough_data: { word: "not enough data", title: "Not enough data" },
  unexplained: { word: "unexplained", title: "Unexplained" },
};
