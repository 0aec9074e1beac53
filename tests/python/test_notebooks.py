"""The notebooks are executed from top to bottom, by Jupyter's own kernel; their assertions hold, and they produce pictures.

usage: test_notebooks.py NOTEBOOK...     PYTHONPATH and LAGLESS_LIBRARY select the package; ends with 77, skipped, without nbclient,
ipykernel or matplotlib."""
import importlib.util
import os
import sys
import tempfile
import unittest

if any(importlib.util.find_spec(name) is None for name in ("nbclient", "ipykernel", "matplotlib", "numpy")):
    print("skipped: this Python has no nbclient, ipykernel or matplotlib (tools/setup all installs them into build/venv)")
    sys.exit(77)

import nbclient
import nbformat
from jupyter_client.kernelspec import NATIVE_KERNEL_NAME

NOTEBOOKS = sys.argv[1:]


class Notebooks(unittest.TestCase):
    def test_each_runs_to_its_end(self):
        self.assertTrue(NOTEBOOKS, "which notebooks?")
        for path in NOTEBOOKS:
            with self.subTest(notebook=path), tempfile.TemporaryDirectory() as folder:
                os.environ.update(JUPYTER_RUNTIME_DIR=folder, IPYTHONDIR=folder, MPLCONFIGDIR=folder)
                notebook = nbformat.read(path, as_version=4)
                self.assertTrue(all(not cell.get("outputs") for cell in notebook.cells), "stored with outputs, which would become outdated")
                client = nbclient.NotebookClient(notebook, timeout=120, kernel_name=NATIVE_KERNEL_NAME,
                                                 resources={"metadata": {"path": folder}})
                client.execute()
                outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
                self.assertTrue(any("image/png" in output.get("data", {}) for output in outputs), "no picture")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
