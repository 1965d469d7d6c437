// @ts-check
// Follows an element from its first width to its removal, so that its charts are freed.

/**
 * @param {HTMLElement} element is added to the page once and removed once
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
