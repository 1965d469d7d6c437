"""Instructions by function, between the marks of a trace.

profile.py SYMBOLS TRACE SAMPLES: SYMBOLS as nm --numeric-sort prints them, TRACE as QEMU does with -singlestep -d exec.
"""

import bisect
import collections
import sys

addresses, names = [], []
for line in open(sys.argv[1]):
    address, kind, name = line.rstrip().split(" ", 2)
    if kind in "tTwW" and not name.startswith("$"):
        # the lowest bit of an address says that it is Thumb code
        addresses.append(int(address, 16) & ~1)
        names.append(name)
samples = int(sys.argv[3])

taken, marks, within = collections.Counter(), 0, False
for line in open(sys.argv[2]):
    if not line.startswith("Trace"):
        continue
    # Trace 0: 0x7f… [cs_base/pc/flags/cflags]
    address = int(line.split("[", 1)[1].split("/")[1], 16)
    name = names[bisect.bisect_right(addresses, address) - 1]
    if name.endswith("trace_mark"):
        # entered once, however many instructions it has
        marks += not within
        within = True
        continue
    within = False
    if marks == 1:
        taken[name] += 1
    elif marks > 1:
        break
if marks < 2:
    sys.exit("error: the trace has no two marks")
print("| function | instructions a sample |")
print("|---|---|")
for name, count in taken.most_common():
    if count >= samples / 2:
        print(f"| `{name}` | {count / samples:.1f} |")
print(f"| all | {sum(taken.values()) / samples:.1f} |")
