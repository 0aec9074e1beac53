"""Calls a script of this folder in the process of its tests, so that matplotlib is loaded once and not for each
case."""
import contextlib
import importlib
import io
import pathlib
import sys
import types
import unittest.mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))


def called(script, *arguments, **environment):
    """Its exit code and what it printed."""
    words = [script, *map(str, arguments)]
    told, said = io.StringIO(), io.StringIO()
    with unittest.mock.patch.object(sys, "argv", words), unittest.mock.patch.dict("os.environ", environment), \
            contextlib.redirect_stdout(told), contextlib.redirect_stderr(said):
        try:
            code = importlib.import_module(script).main()
        except SystemExit as left:
            code = left.code
    return types.SimpleNamespace(returncode=code, stdout=told.getvalue(), stderr=said.getvalue())
