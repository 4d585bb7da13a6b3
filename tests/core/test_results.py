"""Results on disk: whole or not at all, many together, and folders that several processes share."""

import json
import os
import subprocess
import sys
import threading
import time

import pytest

from relume.core import results
from relume.core.errors import ResultError


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_file_appears_whole_under_its_own_name(tmp_path):
    with results.replacing(tmp_path / "a.png") as partial:
        partial.write_bytes(b"new")
        assert partial.suffix == ".png" and partial.parent == tmp_path
        assert not (tmp_path / "a.png").exists()
    assert names(tmp_path) == ["a.png"]
    assert (tmp_path / "a.png").read_bytes() == b"new"


@pytest.mark.parametrize("raised", [KeyboardInterrupt, ValueError, OSError])
def test_a_failure_leaves_the_older_file(tmp_path, raised):
    (tmp_path / "a.png").write_bytes(b"old")
    with pytest.raises(ResultError if raised is OSError else raised), results.replacing(tmp_path / "a.png") as partial:
        partial.write_bytes(b"half")
        raise raised
    assert names(tmp_path) == ["a.png"]
    assert (tmp_path / "a.png").read_bytes() == b"old"


def test_what_was_not_written_is_said_by_its_own_name(tmp_path):
    with pytest.raises(ResultError, match=r"^.*/a\.png: cannot be written"), results.replacing(tmp_path / "a.png"):
        pass
    assert names(tmp_path) == []


def test_a_set_appears_together(tmp_path):
    (tmp_path / "b").write_bytes(b"old")
    with results.together():
        for name in "abc":
            results.write_text(tmp_path / name, f"new {name}")
        assert [n for n in names(tmp_path) if not n.startswith(".relume-")] == ["b"]
        assert (tmp_path / "b").read_bytes() == b"old"
    assert names(tmp_path) == ["a", "b", "c"]
    assert [(tmp_path / name).read_text() for name in "abc"] == ["new a", "new b", "new c"]


@pytest.mark.parametrize("raised", [KeyboardInterrupt, OSError("disk full"), ResultError("full")])
def test_of_a_set_that_fails_nothing_appears(tmp_path, raised):
    (tmp_path / "b").write_bytes(b"old")
    with pytest.raises(type(raised) if isinstance(raised, BaseException) else raised), results.together():
        results.write_text(tmp_path / "a", "new")
        results.write_text(tmp_path / "b", "new")
        raise raised
    assert names(tmp_path) == ["b"]
    assert (tmp_path / "b").read_bytes() == b"old"


@pytest.mark.parametrize("failing", [1, 2, 3])
@pytest.mark.parametrize("raised", [PermissionError(13, "Permission denied"), KeyboardInterrupt()])
def test_a_set_that_cannot_be_put_in_place_is_taken_back(tmp_path, monkeypatch, failing, raised):
    for name in "ab":
        (tmp_path / name).write_bytes(b"old")
    count, replace = [0], os.replace

    def fail(source, target):
        count[0] += 1
        if count[0] == failing:
            raise raised
        replace(source, target)

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises((ResultError, KeyboardInterrupt)), results.together():
        for name in "abc":
            results.write_text(tmp_path / name, "new")
    assert names(tmp_path) == ["a", "b"]
    assert {(tmp_path / name).read_bytes() for name in "ab"} == {b"old"}


def test_a_link_stays_and_what_it_names_is_replaced(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/a").write_text("old")
    (tmp_path / "link").symlink_to("sub/a")
    results.write_text(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "sub/a").read_text() == "new"


def test_names_that_no_file_can_have_are_refused_in_words(tmp_path):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    for path, words in {
        tmp_path / "folder": "is a folder",
        tmp_path / "pipe": "is a device or a pipe",
        tmp_path / "no/a": "there is no folder",
        tmp_path / ("x" * 300): "cannot be written",
    }.items():
        with pytest.raises(ResultError, match=words), results.replacing(path):
            raise AssertionError("nothing is begun")
    assert names(tmp_path) == ["folder", "pipe"]


def test_a_folder_that_was_made_for_nothing_goes_again(tmp_path):
    with pytest.raises(ValueError), results.folder(tmp_path / "a/b"):
        assert (tmp_path / "a/b").is_dir()
        raise ValueError
    assert names(tmp_path) == []
    (tmp_path / "a").mkdir()
    with pytest.raises(ValueError), results.folder(tmp_path / "a"):
        raise ValueError
    assert names(tmp_path) == ["a"], "it was there before"
    with results.folder(tmp_path / "a/b") as folder:
        (folder / "x").write_text("x")
    assert (tmp_path / "a/b/x").is_file()


def test_a_file_in_place_of_a_folder_is_named(tmp_path):
    (tmp_path / "file").write_text("mine")
    for path in (tmp_path / "file", tmp_path / "file/below"):
        with pytest.raises(ResultError, match="file.*: cannot write there"), results.folder(path):
            pass
    assert (tmp_path / "file").read_text() == "mine"


def test_only_one_holds_a_claim(tmp_path):
    waited, order = [], []

    def second():
        with results.claim(tmp_path / "a.exr", lambda: waited.append(True)) as held:
            order.append(("second", held))

    with results.claim(tmp_path / "a.exr") as held:
        assert held
        with results.claim(tmp_path / "a.exr") as again:
            assert not again
        with results.claim(tmp_path / "b.exr") as other:
            assert other
        thread = threading.Thread(target=second)
        thread.start()
        while not waited:
            time.sleep(0.01)
        order.append(("first", True))
    thread.join()
    assert order == [("first", True), ("second", True)]
    assert names(tmp_path) == []


HOLD = """
import pathlib, sys, time
from relume.core import results
folder = pathlib.Path(sys.argv[1])
exr = folder / "a.exr"
with results.claim(exr), results.scratch(folder) as scratch, results.replacing(exr) as partial:
    (scratch / "passes.exr").write_bytes(b"half")
    partial.write_bytes(b"half")
    print("holds", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    process = subprocess.Popen([sys.executable, "-c", HOLD, tmp_path], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "holds\n"
    yield process
    process.kill()
    process.wait()


def test_what_a_living_process_has_begun_is_left_alone(tmp_path, holder):
    before = names(tmp_path)
    assert len(before) == 5
    results.sweep(tmp_path)
    assert names(tmp_path) == before
    with results.claim(tmp_path / "a.exr") as held:
        assert not held


def test_what_a_killed_process_has_left_is_swept_and_its_claim_is_free(tmp_path, holder):
    holder.kill()
    holder.wait()
    assert len(names(tmp_path)) == 5
    with results.claim(tmp_path / "a.exr") as held:
        assert held
    with results.folder(tmp_path):
        assert names(tmp_path) == []


def test_a_living_process_of_another_machine_is_given_a_day(tmp_path):
    left = tmp_path / ".relume-00000000-12345678.png"
    left.write_bytes(b"half")
    results.sweep(tmp_path)
    assert left.exists()
    os.utime(left, (time.time() - 90_000,) * 2)
    results.sweep(tmp_path)
    assert names(tmp_path) == []


def test_only_what_relume_left_is_swept(tmp_path):
    kept = [".relume", ".relume-mine", ".relume-notes.txt", "relume-00000000-12345678.png"]
    for name in kept:
        (tmp_path / name).write_text("mine")
        os.utime(tmp_path / name, (0, 0))
    results.sweep(tmp_path)
    assert names(tmp_path) == sorted(kept)


def test_many_processes_add_to_one_file_and_none_is_lost(tmp_path):
    add = (
        "import json, pathlib, sys\n"
        "from relume.core import results\n"
        "path = pathlib.Path(sys.argv[1])\n"
        "for i in range(20):\n"
        "    with results.claim(path, lambda: None):\n"
        "        lines = json.loads(path.read_text()) if path.exists() else []\n"
        "        results.write_text(path, json.dumps([*lines, f'{sys.argv[2]} {i}']))\n"
    )
    path = tmp_path / "summary.json"
    running = [subprocess.Popen([sys.executable, "-c", add, path, str(n)]) for n in range(4)]
    assert [process.wait() for process in running] == [0] * 4
    assert sorted(json.loads(path.read_text())) == sorted(f"{n} {i}" for n in range(4) for i in range(20))
    assert names(tmp_path) == ["summary.json"]


def test_abandoning_takes_away_all_that_is_begun(tmp_path):
    (tmp_path / "a.png").write_bytes(b"old")
    script = HOLD.replace("time.sleep(60)", "results.abandon(); import os; os._exit(7)")
    script = script.replace("with results.claim(exr)", "with results.folder(folder / 'new'), results.claim(exr)")
    done = subprocess.run([sys.executable, "-c", script, tmp_path], capture_output=True)
    assert done.returncode == 7, done.stderr
    assert names(tmp_path) == ["a.png"]
