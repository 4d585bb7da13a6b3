"""Runs that are killed, crowded or starved, and the same command afterwards: it gives the very same files."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from . import outcome

pytest.importorskip("bpy", reason="commands need bpy")

RELUME = str(Path(sys.executable).parent / "relume")
COMMANDS = {
    "render": "render room.blend --samples 3 --channels 6 --frame 1-2 --illuminant D65 FL2 --out out",
    "relight": "relight in/shot_##.exr --light tungsten=LED-B1 --out out/shot_##.png",
    "report": "report room.blend --channels 3 --models rgb fitted --out out",
}


def _start(command: str, folder: Path) -> subprocess.Popen:
    return subprocess.Popen(
        [RELUME, *command.split()],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def _ended(process: subprocess.Popen) -> outcome.Ended:
    out, err = process.communicate(timeout=600)
    return outcome.Ended(process.returncode, out, err)


def _kill(process: subprocess.Popen):
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()


def _results(folder: Path) -> dict:
    """What a command left in `out`, but for the times that it took."""
    found = outcome.files_of(folder / "out")
    for name, data in found.items():
        if name == "summary.json":
            found[name] = json.loads(data)
            for noted in (found[name], *found[name]["frames"]):
                noted.pop("seconds", None)
                noted["scene"] = Path(noted["scene"]).name
    if "report.json" in found:  # times, and what is drawn of them
        return {name: data for name, data in found.items() if name.startswith("renders/") and name.endswith(".exr")}
    return found


@pytest.fixture(scope="module")
def prepared(little, tmp_path_factory):
    """A folder with room.blend and, in `in`, three frames that were rendered from it."""
    folder = tmp_path_factory.mktemp("prepared")
    shutil.copy(little, folder / "room.blend")
    ended = _ended(_start("render room.blend --samples 3 --channels 6 --frame 1-3 --out in", folder))
    assert ended.status == 0, ended
    for n in (1, 2, 3):
        (folder / f"in/room_{n:04d}.exr").rename(folder / f"in/shot_{n:02d}.exr")
    return folder


@pytest.fixture(scope="module")
def undisturbed(prepared, tmp_path_factory):
    """(seconds, results) of a command that nobody disturbs."""
    known = {}

    def of(kind: str):
        if kind not in known:
            folder = tmp_path_factory.mktemp(kind) / "work"
            shutil.copytree(prepared, folder)
            began = time.perf_counter()
            ended = _ended(_start(COMMANDS[kind], folder))
            assert ended.status == 0, ended
            known[kind] = time.perf_counter() - began, _results(folder)
        return known[kind]

    return of


def _cases(fast: dict, torture: dict):
    chosen = torture if os.environ.get("RELUME_TORTURE") else fast
    scale = float(os.environ.get("RELUME_TORTURE") or 1)
    first = int(os.environ.get("RELUME_SEED", "0"))
    return [(kind, first + n) for kind, count in chosen.items() for n in range(max(1, round(count * scale)))]


@pytest.mark.parametrize(
    ("kind", "seed"), _cases({"render": 2, "relight": 2}, {"render": 40, "relight": 40, "report": 6})
)
def test_killed_and_run_again(kind, seed, prepared, undisturbed, tmp_path, settle):
    seconds, wanted = undisturbed(kind)
    chance, folder = random.Random(seed), tmp_path / "work"
    shutil.copytree(prepared, folder)
    for _ in range(chance.randint(1, 2)):
        process = _start(COMMANDS[kind], folder)
        time.sleep(chance.uniform(0.3, 1.0) * seconds)
        _kill(process)
    ended = _ended(_start(COMMANDS[kind] + (" --resume" if kind != "report" and chance.random() < 0.5 else ""), folder))
    assert ended.status == 0, ended
    assert _results(folder) == wanted
    outcome.files_of(folder)
    settle(outcome.RIGHT)


@pytest.mark.parametrize(("processes", "seed"), _cases({2: 1}, {2: 12, 4: 8}))
def test_several_processes_in_one_folder(processes, seed, prepared, undisturbed, tmp_path, settle):
    _, wanted = undisturbed("render")
    chance, folder = random.Random(seed), tmp_path / "work"
    shutil.copytree(prepared, folder)
    running = []
    for _ in range(processes):
        running.append(_start(COMMANDS["render"] + chance.choice(["", " --resume"]), folder))
        time.sleep(chance.uniform(0.0, 0.5))
    hows = [outcome.of_command(_ended(process)) for process in running]
    assert outcome.RIGHT in hows
    assert _results(folder) == wanted
    settle(outcome.RIGHT, processes)


@pytest.mark.parametrize(("kind", "seed"), _cases({"relight": 1}, {"render": 12, "relight": 12}))
def test_a_folder_that_vanishes(kind, seed, prepared, undisturbed, tmp_path, settle):
    seconds, wanted = undisturbed(kind)
    chance, folder = random.Random(seed), tmp_path / "work"
    shutil.copytree(prepared, folder)
    process = _start(COMMANDS[kind], folder)
    until = time.perf_counter() + chance.uniform(0.3, 0.9) * seconds
    while process.poll() is None and (time.perf_counter() < until or not (folder / "out").is_dir()):
        time.sleep(0.02)
    shutil.rmtree(folder / "out", ignore_errors=True)
    how = outcome.of_command(_ended(process))
    ended = _ended(_start(COMMANDS[kind], folder))
    assert ended.status == 0, ended
    assert _results(folder) == wanted
    settle(how)


@pytest.fixture
def disk(tmp_path):
    """disk(size): a file system of so many bytes, mounted as the folder that is returned."""
    mounted = []

    def mount(size: str) -> Path:
        folder = tmp_path / f"disk {len(mounted)}"
        folder.mkdir()
        options = ["-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
        if subprocess.run(["mount", *options], capture_output=True).returncode:
            pytest.skip("no file system can be mounted here")
        mounted.append(folder)
        return folder

    yield mount
    for folder in mounted:
        subprocess.run(["umount", "--lazy", str(folder)], check=False)


@pytest.mark.parametrize("seed", outcome.seeds(3, 40))
def test_a_full_disk_keeps_what_was_there(seed, prepared, undisturbed, disk, settle):
    chance = random.Random(seed)
    kind = chance.choice(["render", "relight", "relight"])
    folder = disk("8m")
    shutil.copytree(prepared, folder, dirs_exist_ok=True)
    (folder / "out").mkdir()
    names = list(undisturbed(kind)[1])
    older = {name: f"older {name}".encode() for name in chance.sample(names, 2)}
    for name, data in older.items():
        (folder / "out" / name).write_bytes(data)
    left = chance.choice([0, 1000, 4096, 8192, 20_000])
    with open(folder / "filler", "wb") as filler:
        free = os.statvfs(folder)
        filler.write(bytes(max(0, free.f_bavail * free.f_frsize - left)))
    ended = _ended(_start(COMMANDS[kind], folder))
    how = outcome.of_command(ended)
    found = outcome.files_of(folder / "out")
    _, wanted = undisturbed(kind)
    for name, data in found.items():
        new = name != "summary.json" and data == wanted.get(name)
        assert new or data == older.get(name) or how == outcome.RIGHT or name == "summary.json", name
    assert set(found) >= set(older), "an older result is gone"
    settle(how)


@pytest.mark.parametrize("kind", ["render", "relight"])
def test_a_folder_that_cannot_be_written(kind, prepared, disk, settle):
    folder = disk("8m")
    shutil.copytree(prepared, folder, dirs_exist_ok=True)
    subprocess.run(["mount", "-o", "remount,ro", str(folder)], check=True)
    before = outcome.files_of(folder)
    ended = _ended(_start(COMMANDS[kind], folder))
    assert outcome.of_command(ended) == outcome.SAID, ended
    assert "out" in ended.err
    assert outcome.files_of(folder) == before
    settle(outcome.SAID)
