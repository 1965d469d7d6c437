// @ts-check
// The three answers of a diagnosis, in words: they never differ by colour alone.

/** @type {Record<import("./types.js").Verdict, {word: string, title: string}>} */
export const VERDICTS = {
  missing: { word: "an effect is missing", title: "Missing" },
  nothing_missing: { word: "nothing is missing", title: "Nothing is missing" },
  unexplained: { word: "unexplained", title: "Unexplained" },
};
