// Firmware on an emulated chip: .ci/chip builds what this needs and calls it.

import { core } from './core.js';
import { faults } from './faults.js';
import { hour } from './hour.js';
import { loop } from './loop.js';
import { power } from './power.js';
import { uf2 } from './uf2.js';

function gate() {
  core('0.5');
  loop('6');
  faults('1');
  power('4');
}

const [what, ...options] = process.argv.slice(2);
({ core, faults, gate, hour, loop, power, uf2 })[what](...options);
