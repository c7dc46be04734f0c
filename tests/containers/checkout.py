"""A copy of the image's sources, as on a host of its own, and the commands that are run in it."""

import json
import os
import re
import shutil
import subprocess
import time
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.places import ROOT
from tests.ports import free_port

_PLUGIN = 'docker-compose() { docker compose "$@"; }\n'


def run(*command: str, seconds: float = 60.0) -> str:
    """Run a command and return what it printed."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=seconds, check=False)
    assert done.returncode == 0, f"{' '.join(command)}: {done.stdout[-3000:]} {done.stderr[-3000:]}"
    return done.stdout


def wait_for(what: Callable[[], object], goal: str, seconds: float, each_s: float = 0.5) -> None:
    """Ask again and again; an answer that cannot be had yet counts as no."""
    deadline_s, why = time.monotonic() + seconds, ""
    while time.monotonic() < deadline_s:
        try:
            if what():
                return
        except AssertionError as error:  # its container is just being restarted
            why = f" ({error})"
        time.sleep(each_s)
    raise AssertionError(f"{goal}: not within {seconds:g} s{why}")


class Checkout:
    """A composition with a name of its own, which its containers, networks and volumes carry."""

    def __init__(self, folder: Path, override: Path | None = None, **environment: str) -> None:
        """Copy what git has and the image needs.

        Args:
            folder: where to.
            override: changes to the composition.
            environment: variables of the shell that commands are run in.
        """
        self.folder = folder
        folder.mkdir()
        ignored = (ROOT / ".dockerignore").read_text("utf-8")
        for name in (
            "Dockerfile",
            "docker-compose.yml",
            ".dockerignore",
            ".env",
            *re.findall(r"^!(.*)$", ignored, re.M),
        ):
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
            else:
                shutil.copy(ROOT / name, folder / name)
        if override is not None:
            shutil.copy(override, folder / "docker-compose.override.yml")
        plugin = subprocess.run(("docker", "compose", "version"), capture_output=True, timeout=30, check=False)
        self._prelude = "set -e\n" + (_PLUGIN if plugin.returncode == 0 else "")
        mine = {"COMPOSE_PROJECT_NAME": f"teletaction-{uuid.uuid4().hex[:8]}", "CONSOLE_PORT": str(free_port())}
        inherited = {name: value for name, value in os.environ.items() if not name.startswith("COMPOSE_")}
        self.environment = inherited | mine | environment
        self.ran: list[str] = []

    def start(self, script: str) -> "subprocess.Popen[str]":
        """Run a block of commands of a how-to page beside others."""
        self.ran += script.splitlines()
        return subprocess.Popen(
            ("bash", "-c", self._prelude + script),
            cwd=self.folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def __call__(self, script: str, seconds: float = 120.0, **environment: str) -> str:
        """Run a block of commands of a how-to page to its end; returns what it printed."""
        self.environment |= environment
        with self.start(script) as shell:
            try:
                said, errors = shell.communicate(timeout=seconds)
            except subprocess.TimeoutExpired:
                shell.kill()
                raise
        assert shell.returncode == 0, f"{script}: {said[-3000:]} {errors[-3000:]}"
        return said

    def container(self, service: str) -> str:
        """Its container; raises AssertionError where there is none."""
        project = self.environment["COMPOSE_PROJECT_NAME"]
        labels = (f"com.docker.compose.project={project}", f"com.docker.compose.service={service}")
        found = run("docker", "ps", "-aq", *(word for label in labels for word in ("--filter", f"label={label}")))
        assert found.split(), f"no container of {service}"
        return found.split()[0]

    def inspect(self, service: str, what: str) -> str:
        """A field of its container, such as `.State.Health.Status`."""
        return run("docker", "inspect", "-f", f"{{{{{what}}}}}", self.container(service)).strip()

    def healthy(self, service: str) -> bool:
        """Whether the engine holds it for healthy."""
        return self.inspect(service, ".State.Health.Status") == "healthy"

    def status(self, service: str, process: str) -> dict[str, Any]:
        """The last status of a process."""
        text = run("docker", "exec", self.container(service), "cat", f"/session/{process}.json")
        status: dict[str, Any] = json.loads(text)
        return status

    def stop(self, service: str) -> float:
        """Stop a service and return how long that took, s; its exit code must be that of an orderly end."""
        container = self.container(service)
        begin_s = time.monotonic()
        run("docker", "stop", "--time", "10", container)
        took_s = time.monotonic() - begin_s
        assert self.inspect(service, ".State.ExitCode") == "0", service
        return took_s

    def remove(self) -> None:
        """Take everything down, volumes too."""
        self("docker-compose down --volumes --remove-orphans --timeout 3")
