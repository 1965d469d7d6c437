// @ts-check
// Names of the outcomes of an axis or a study, which never differ by colour alone.

/** @type {Record<import("./types.js").Outcome, {word: string, title: string}>} */
export const OUTCOMES = {
  missing: { word: "an effect is missing", title: "Missing" },
  data_fault: { word: "fault of the data", title: "Fault of the data" },
  unexplained: { word: "unexplained", title: "Unexplained" },
  did_not_pay: { word: "an added effect did not pay", title: "The added effect did not pay" },
  not_enough_data: { word: "not enough data", title: "Not enough data" },
  nothing_missing: { word: "nothing is missing", title: "Nothing is missing" },
};

/** Explanation of the slow errors in tables. */
export const SLOW_ERROR =
  "Slow error: RMS of 1-s means on data that were not fitted. The first is that of a constant bias, the second that of the model in a free run of at most 60 s.";
