// A NOR flash: erasing sets all bits of a sector, programming only clears bits. A cut of power leaves either of them half done.

export const PAGE = 256;
export const ERASE = 4096;

export class Flash {
  /** @param {Uint8Array} bytes contents, which are changed in place */
  constructor(bytes) {
    this.bytes = bytes;
    /// Number of erased sectors and programmed pages.
    this.changes = 0;
  }

  erase(at) {
    this.changes++;
    this.bytes.fill(0xff, at, at + ERASE);
  }

  program(at, page) {
    this.changes++;
    page.forEach((byte, index) => (this.bytes[at + index] &= byte));
  }
}
