"""Recipes of container images: the same steps in both, which also work in a bare Debian 12.

The second test is long: it needs root, debootstrap and up to half an hour.

    .venv/bin/pytest -m validate tests/containers
"""

import json
import os
import shutil
import subprocess
from contextlib import contextmanager
from pathlib import Path

import pytest

TOP = Path(__file__).parents[2]
CONTAINERFILE, DEFINITION = TOP / "containers" / "Containerfile", TOP / "containers/millscale.def"
# What a machine may need to reach its package index. The certificates have another name inside,
# since a package of Debian replaces the file.
FILES = {
    "etc/resolv.conf": "etc/resolv.conf",
    "etc/pip.conf": "etc/pip.conf",
    "etc/ssl/certs/ca-certificates.crt": "etc/index.crt",
}
VARIABLES = ("PIP_INDEX_URL", "PIP_DEFAULT_TIMEOUT", "http_proxy", "https_proxy", "no_proxy")


def containerfile():
    """Return base, copied files, steps and PATH of the OCI recipe."""
    lines = CONTAINERFILE.read_text().replace("\\\n", " ").splitlines()
    entries = dict(line.split(maxsplit=1) for line in lines if line and not line.startswith("#"))
    assert list(entries) == ["FROM", "COPY", "RUN", "ENV"]
    return [" ".join(text.split()) for text in entries.values()]


def definition():
    """Return the same of the Apptainer recipe."""
    header, *sections = DEFINITION.read_text().replace("\\\n", " ").split("\n%")
    found = {}
    for section in sections:
        name, *lines = section.splitlines()
        kept = [" ".join(line.split()) for line in lines]
        found[name] = [line for line in kept if line and not line.startswith("#")]
    base = next(x for x in header.splitlines() if x.startswith("From: ")).removeprefix("From: ")
    (files,), (steps,), (path,) = (found[x] for x in ("files", "post", "environment"))
    return [base, files, steps, path.removeprefix("export ")]


def commit():
    done = subprocess.run(["git", "rev-parse", "HEAD"], cwd=TOP, capture_output=True, text=True)
    return done.stdout.strip() or pytest.skip("no git repository")


def test_both_recipes_have_the_same_steps():
    assert containerfile() == definition()
    base, files, steps, path = containerfile()
    assert base == "debian:12" and files == "millscale.tar /opt/"
    assert "/opt/millscale/scripts/setup && " in steps and path.endswith(":$PATH")


def test_an_archive_of_the_repository_states_its_commit():
    head = commit()
    line = ["git", "archive", "HEAD", "cmake/BuildRecord.cmake"]
    assert f'set(archived "{head}")'.encode() in subprocess.check_output(line, cwd=TOP)


@contextmanager
def bare_debian(folder):
    """Make a minimal Debian 12 in a folder; yield a function that runs a line in it."""
    subprocess.run(["debootstrap", "--variant=minbase", "bookworm", folder], check=True)
    for name, inside in FILES.items():
        if (Path("/") / name).exists():
            shutil.copy(Path("/") / name, folder / inside)
    path = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
    kept = {name: os.environ[name] for name in VARIABLES if name in os.environ}
    kept |= dict.fromkeys(("PIP_CERT", "SSL_CERT_FILE"), "/etc/index.crt")
    mounted = {"proc": folder / "proc", "tmpfs": folder / "dev/shm"}

    def run(line):
        done = subprocess.run(
            ["chroot", folder, "/bin/sh", "-ec", line],
            env={"PATH": path, "HOME": "/root", **kept},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        assert done.returncode == 0, done.stdout[-5000:]
        return done.stdout

    try:
        for kind, place in mounted.items():
            place.mkdir(parents=True, exist_ok=True)
            subprocess.run(["mount", "-t", kind, kind, place], check=True)
        yield run
    finally:
        for place in mounted.values():
            subprocess.run(["umount", place], check=True)
        shutil.rmtree(folder)


@pytest.mark.validate
@pytest.mark.skipif(
    os.geteuid() != 0 or not shutil.which("debootstrap"), reason="needs root and debootstrap"
)
def test_the_steps_make_a_millscale_that_runs_in_a_bare_debian(tmp_path):
    head = commit()
    _, _, steps, path = containerfile()
    with bare_debian(tmp_path / "debian") as run:
        archive = tmp_path / "debian/opt/millscale.tar"
        subprocess.run(["git", "archive", "--output", archive, "HEAD"], cwd=TOP, check=True)
        assert "16 cases" in run(steps)
        campaign = "/opt/millscale/campaigns/quick.toml"
        case = "sb-cg-paper-S1.300"
        line = f"export {path}; millscale run {campaign} --runs /root/runs --only {case}"
        assert f"{case}: done" in run(line)
        folder = tmp_path / "debian/root/runs/cases" / case
        assert json.loads((folder / "result.json").read_text())
        record = json.loads((folder / "provenance.json").read_text())
        assert record["stages"]["rotate"]["commit"] == head
