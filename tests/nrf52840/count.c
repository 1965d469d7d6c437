// Called by unicorn before every instruction: counts it, and ends a run at the right place.

#include <stdint.h>

// Return address of an exception handler (core.py).
#define RETURN 0x08000000u

enum { AT_LIMIT, AT_WFE, AT_RETURN };

struct counter {
  uint64_t executed;
  // ends the run before the instruction after so many
  uint64_t limit;
  // an interrupt waits until interrupts are enabled
  uint32_t waiting;
  // event register of the processor
  uint32_t event;
  // instructions left of an IT block, whose state unicorn does not save at the end of a run
  uint32_t in_block;
  // reason for the end of the run
  uint32_t ended;
  uint32_t flash_bytes;
  const uint8_t *flash;
  // uc_emu_stop
  int (*stop)(void *uc);
};

void count(void *uc, uint64_t address, uint32_t bytes, struct counter *counter) {
  uint16_t code = 0;
  (void)bytes;
  if (address < counter->flash_bytes) {
    code = (uint16_t)(counter->flash[address] | counter->flash[address + 1] << 8);
  }
  int at_limit = counter->executed >= counter->limit && counter->in_block == 0;
  if (address == RETURN || at_limit || code == 0xbf20) {
    // WFE is left to the caller, and so is an interrupt that has become pending before it
    counter->ended = address == RETURN ? AT_RETURN : at_limit ? AT_LIMIT : AT_WFE;
    counter->stop(uc);
    return;
  }
  counter->executed++;
  if ((code & 0xff00) == 0xbf00 && (code & 0xf) != 0) { // IT
    counter->in_block = 4 - (uint32_t)__builtin_ctz(code & 0xf);
  } else if (counter->in_block > 0) {
    counter->in_block--;
  }
  if (code == 0xb662 && counter->waiting) { // CPSIE i
    counter->limit = counter->executed;
  } else if (code == 0xbf40) { // SEV
    counter->event = 1;
  }
}
