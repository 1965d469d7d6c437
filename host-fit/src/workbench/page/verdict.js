// @ts-check
// Names of the outcomes of an axis or a study, which never differ by colour alone.

/** @type {Record<import("./types.js").Outcome, {word: string, title: string}>} */
export const OUTCOMES = {
  missing: { word: "an effect is missing", title: "Missing" },
  unexplained: { word: "unexplained", title: "Unexplained" },
  did_not_pay: { word: "an added effect did not pay", title: "The added effect did not pay" },
  not_enough_data: { word: "not enough data", title: "Not enough data" },
  nothing_missing: { word: "nothing is missing", title: "Nothing is missing" },
};
