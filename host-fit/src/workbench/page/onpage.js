// @ts-check
// Follows an element from its first width to its end, so that what was drawn in it is let go.

/**
 * @param {HTMLElement} element is put on the page once, and taken off once
 * @param {(width: number) => void} resized
 * @param {() => void} gone
 */
export function whileOnPage(element, resized, gone) {
  const observer = new ResizeObserver(() => {
    if (!element.isConnected) {
      observer.disconnect();
      gone();
    } else if (element.clientWidth > 0) resized(element.clientWidth);
  });
  observer.observe(element);
}
