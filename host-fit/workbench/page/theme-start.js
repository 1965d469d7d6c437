// @ts-check
// Runs before the page is drawn, so that a chosen theme does not flash in late.
document.documentElement.dataset.theme = localStorage.getItem("fos-theme") ?? "auto";
