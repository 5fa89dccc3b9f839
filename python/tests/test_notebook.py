"""The notebook of the documentation holds what its cells give.

`python test_notebook.py` executes it and writes the outputs.
"""

import os
import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).resolve().parents[2] / "docs" / "notebook.ipynb"


def executed():
    """The notebook with its outputs, and without what differs from run to run."""
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    path = os.environ["PATH"]
    os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{path}"
    try:
        with tempfile.TemporaryDirectory() as folder:
            NotebookClient(notebook, timeout=600, resources={"metadata": {"path": folder}}).execute()
    finally:
        os.environ["PATH"] = path
    for cell in notebook.cells:
        cell.metadata.clear()
        if cell.cell_type == "code":
            cell.outputs = joined(cell.outputs)
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    return notebook


def joined(outputs):
    """Outputs whose printed text is one: how it was cut into pieces is chance."""
    whole = []
    for output in outputs:
        last = whole[-1] if whole else None
        if last and last.output_type == output.output_type == "stream" and last.name == output.name:
            last.text += output.text
        else:
            whole.append(output)
    for output in whole:
        if output.output_type == "stream":
            output.text = output.text.replace("\r\n", "\n")
    return whole


def test_the_notebook_holds_what_its_cells_give():
    committed, now = nbformat.read(NOTEBOOK, as_version=4), executed()
    assert nbformat.writes(now).strip() == nbformat.writes(committed).strip()


def test_the_notebook_names_no_machine():
    text = NOTEBOOK.read_text(encoding="utf-8")
    for folder in (str(Path.home()), tempfile.gettempdir() + "/", str(NOTEBOOK.parents[1])):
        assert folder not in text


if __name__ == "__main__":
    nbformat.write(executed(), NOTEBOOK)
