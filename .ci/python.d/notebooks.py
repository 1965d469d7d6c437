"""Executes notebooks, each of which keeps its outputs.

    notebooks.py check|write NOTEBOOK...

`check` compares the kept outputs with those of now: printed lines are the same, and so are the kinds of results and the number of
pictures. `write` keeps those of now.
"""

import copy
import sys
import time

import nbformat
from nbclient import NotebookClient

LONGEST_TEXT = 2000
"""Characters of a plain text that is kept beside HTML."""


def shown(output):
    """What of an output does not depend on the machine."""
    if output["output_type"] == "stream":
        return output["text"]
    return sorted(output.get("data", {})), output.get("data", {}).get("text/html", "").count("<svg")


def outputs(notebook):
    return [output for cell in notebook.cells for output in cell.get("outputs", [])]


def executed(kept):
    notebook = copy.deepcopy(kept)
    NotebookClient(notebook, timeout=300, kernel_name="python3", record_timing=False).execute()
    for output in outputs(notebook):
        data = output.get("data", {})
        if "text/html" in data and len(data.get("text/plain", "")) > LONGEST_TEXT:
            del data["text/plain"]
    notebook.metadata = kept.metadata
    return notebook


for path in sys.argv[2:]:
    begun = time.monotonic()
    kept = nbformat.read(path, as_version=4)
    notebook = executed(kept)
    pictures = sum(output.get("data", {}).get("text/html", "").count("<svg") for output in outputs(notebook))
    assert pictures >= 2, f"{path}: {pictures} pictures"
    if sys.argv[1] == "write":
        nbformat.write(notebook, path)
    else:
        now, before = map(shown, outputs(notebook)), map(shown, outputs(kept))
        assert list(now) == list(before), f"{path}: the kept outputs are of another version: .ci/python notebooks"
    print(f"{path}: {len(notebook.cells)} cells, {pictures} pictures, {time.monotonic() - begun:.0f} s")
