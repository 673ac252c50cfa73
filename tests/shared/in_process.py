"""Run commands of `millscale` in the process of the test, which saves starting a Python."""

import io
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from unittest.mock import patch

import pytest

from millscale.cli.main import main


def millscale(*words, **environment):
    """Run a command and return its exit code, output and errors as a CompletedProcess."""
    line = ["millscale", *map(str, words)]
    output, errors = io.StringIO(), io.StringIO()
    with (
        patch.dict(os.environ, environment),
        patch.object(sys, "argv", line),
        redirect_stdout(output),
        redirect_stderr(errors),
        pytest.raises(SystemExit) as ended,
    ):
        main()
    code = ended.value.code or 0
    return subprocess.CompletedProcess(line, code, output.getvalue(), errors.getvalue())
