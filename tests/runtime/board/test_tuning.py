# SPDX-License-Identifier: Apache-2.0
"""Parameters that are set while a law runs on a board: this machine computes the same bits, and so does the journal."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import numpy as np
import pytest

from mehvar.base.errors import InputError
from mehvar.runtime.board.image.header import layout
from mehvar.runtime.board.journal import Journal, read_journal
from mehvar.runtime.board.run import BoardRequest, run_on_board
from mehvar.runtime.board.tuning import HostLaw, Requests, path_of, replay, tune
from tests.runtime.board.conftest import Bench, load
from tests.runtime.board.test_faults import Rebooting, Stopped
from tests.tools import needs


@pytest.mark.parametrize("target", ["sil", "unicorn", pytest.param("qemu", marks=needs("qemu-system-arm"))])
@pytest.mark.share(3)
def test_a_tuned_run_and_its_journal_have_the_bits_of_this_machine(tmp_path, target):
    """Tuned at a checkpoint, between two, and at one sample twice."""
    model, journal = load("satellite"), tmp_path / "journal"
    plain = run_on_board(model, BoardRequest("mrac", target, samples=80, selftest=0, profiled=False))
    for at, values in ((25, {"tau_m": 20.0}), (31, {"forgetting": 0.97, "I_x": 2.5}), (31, {"tau_m": 12.0})):
        tune(model, "mrac", journal, values, at)
    o = run_on_board(model, BoardRequest("mrac", target, samples=80, selftest=0, profiled=False, journal=journal))
    assert (o.max_ulp, o.x.ulp) == (0, 0)
    assert [(t.sample, t.refusal) for t in o.tunings] == [(25, ""), (31, ""), (31, "")]
    assert o.board.u_cmd[:25].tobytes() == plain.board.u_cmd[:25].tobytes()
    for k in (25, 31):
        assert o.board.u_cmd[k].tobytes() != plain.board.u_cmd[k].tobytes()
    assert not path_of(journal).exists()
    result = replay(model, "mrac", journal)
    assert (result.samples, result.memories, result.first) == (80, 5 * 92, None)
    with pytest.raises(InputError, match="its run is complete"):
        run_on_board(model, BoardRequest("mrac", target, samples=80, selftest=0, profiled=False, journal=journal))


def test_a_request_after_the_last_sample_is_refused_by_name_and_in_no_journal(tmp_path):
    """Refused at once where the journal tells, else told by the run when it ends."""
    model, journal = load("satellite"), tmp_path / "journal"
    for at in (10, 30, 500):
        tune(model, "mrac", journal, {"tau_m": 20.0}, at)
    o = run_on_board(model, BoardRequest("mrac", "sil", samples=30, selftest=0, journal=journal))
    assert [t.sample for t in o.tunings] == [10]
    assert [request.at for request in o.refused] == [30, 500]
    assert [t.sample for t in replay(model, "mrac", journal).tunings] == [10]
    content = journal.read_bytes()
    with pytest.raises(InputError, match="its run is over"):
        tune(model, "mrac", journal, {"tau_m": 30.0})
    assert not path_of(journal).exists()
    assert journal.read_bytes() == content
    journal.write_bytes(content[: -len(b"e") - 4])  # as while it ran
    with pytest.raises(InputError, match="at = 30: must be a sample of the run, which has 30: at most 29"):
        tune(model, "mrac", journal, {"tau_m": 30.0}, 30)
    assert tune(model, "mrac", journal, {"tau_m": 30.0}, 29) == {"tau_m": 30.0}


@pytest.mark.parametrize("part", ["answer", "memory", "tuning"])
def test_a_journal_with_another_bit_is_noticed(tmp_path, part):
    """Written as such: what answered was another board."""
    model, journal, other = load("satellite"), tmp_path / "journal", tmp_path / "other"
    tune(model, "mrac", journal, {"tau_m": 20.0}, 10)
    o = run_on_board(model, BoardRequest("mrac", "sil", samples=30, selftest=0, journal=journal))
    sizes = layout(model.manifest, model.manifest.controller("mrac"))
    entries = read_journal(journal, sizes)
    identity = {name: value for name, value in entries.identity.items() if name != "layout"}
    entries.rows[29, -1] += np.float32(part == "answer")
    entries.memories[30][5] += np.float32(part == "memory")
    again = Journal(other, identity, sizes)
    for k in range(31):
        for tuning in entries.tunings:
            if tuning.sample == k:
                again.append_tuning(replace(tuning, values={"tau_m": 30.0}) if part == "tuning" else tuning)
        if k in entries.memories:
            again.append_memory(entries.memories[k])
        if k < 30:
            again.append(entries.rows[k, : sizes.sizes[0]], entries.rows[k, sizes.sizes[0] :])
    again.close(complete=True)
    assert replay(model, "mrac", journal).first is None
    assert replay(model, "mrac", other).first == {"answer": 29, "memory": 30, "tuning": 10}[part]
    assert o.max_ulp == 0


def test_a_damaged_journal_is_refused_or_breaks_off(tmp_path):
    """Whichever byte is damaged, and wherever it is cut off."""
    model, journal = load("satellite"), tmp_path / "journal"
    tune(model, "mrac", journal, {"tau_m": 20.0}, 4)
    run_on_board(model, BoardRequest("mrac", "sil", samples=8, selftest=0, journal=journal))
    sizes, content = layout(model.manifest, model.manifest.controller("mrac")), journal.read_bytes()
    assert read_journal(journal, sizes).complete
    for at in range(0, len(content), 3):
        damaged = content[:at] + bytes([content[at] ^ 1 << at % 8]) + content[at + 1 :]
        for text in (damaged, content[:at]):
            journal.write_bytes(text)
            with contextlib.suppress(InputError):
                assert not read_journal(journal, sizes).complete
    journal.write_bytes(content + bytes(40))
    with pytest.raises(InputError, match="the file is damaged at or before byte"):
        read_journal(journal, sizes)


def session(bench, path, port=None, after=None):
    """Return a law on a board with a journal, and that journal."""
    identity = {"scenario": "paper", "parameters": dict(bench.expected.parameters.values)}
    journal = Journal(path, identity, bench.program.layout)
    requests = Requests(path, journal.tunings)
    return bench.on_board(bench.link(port), every=5, journal=journal, after=after, requests=requests), journal


def expected(bench, tunings):
    return bench.simulate(law=HostLaw(bench.program, bench.expected.parameters, tunings))


@pytest.mark.parametrize("every", [67, 89])
def test_a_board_that_reboots_gets_the_parameters_of_each_sample_back(tmp_path, every):
    bench, path = Bench(samples=150), tmp_path / "journal"
    for at in (20, 60, 75, 110):
        tune(bench.model, "mrac", path, {"tau_m": 10.0 + at / 10}, at)
    law, journal = session(bench, path, Rebooting(bench.port, every))
    run = bench.simulate(law=law)
    journal.close(complete=True)
    assert law.restored >= 2
    assert run.u_cmd.tobytes() == expected(bench, journal.tunings).u_cmd.tobytes()


@pytest.mark.parametrize("board_forgets", [False, True])
def test_a_host_that_was_stopped_goes_on_with_what_was_tuned(tmp_path, board_forgets):
    """Asked for while it runs; the host ends right after a tuned sample."""
    bench, path = Bench(), tmp_path / "journal"
    calls = 0

    def ask_and_stop() -> None:
        nonlocal calls
        calls += 1
        if calls == 17:
            tune(bench.model, "mrac", path, {"tau_m": 20.0})
        if calls == 18:
            raise Stopped

    law, journal = session(bench, path, after=ask_and_stop)
    with pytest.raises(Stopped):
        bench.simulate(law=law)
    journal.close(complete=False)
    with path.open("ab") as file:
        file.write(b"t\xff\0\0\0half a record")
    if board_forgets:
        bench.port.machine.power_on()
    bench.port.machine.advance(1100)
    tune(bench.model, "mrac", path, {"forgetting": 0.97}, 40)
    law, journal = session(bench, path)
    run = bench.simulate(law=law)
    law.finish()
    journal.close(complete=True)
    assert [t.sample for t in journal.tunings] == [17, 40]
    assert run.u_cmd.tobytes() == expected(bench, journal.tunings).u_cmd.tobytes()
    assert replay(bench.model, "mrac", path).first is None


def test_what_cannot_be_tuned_is_refused(tmp_path):
    model, journal = load("satellite"), tmp_path / "journal"
    for values, message in (
        ({"taum": 1.0}, "did you mean tau_m"),
        ({"tau_m": float("nan")}, "must be a finite number"),
        ({"tau_m": -1.0}, "must be in"),
        ({"dead_zone": 1e300}, "must be a finite float"),
        ({"Ts": 0.25}, "must be constant during a run"),
        ({}, "nothing to tune"),
    ):
        with pytest.raises(InputError, match=message):
            tune(model, "mrac", journal, values)
    with pytest.raises(InputError, match="at = -1"):
        tune(model, "mrac", journal, {"tau_m": 20.0}, -1)
    assert not path_of(journal).exists()


def test_a_constant_of_the_text_is_refused_and_the_run_goes_on(tmp_path):
    model, journal = load("satellite"), tmp_path / "journal"
    tune(model, "mrac", journal, {"tau_m": 20.0}, 10)
    tune(model, "mrac", journal, {"forgetting": 0.97}, 12)
    request = BoardRequest("mrac", "sil", samples=30, selftest=0, journal=journal, tunable=("forgetting",))
    o = run_on_board(model, request)
    assert (o.max_ulp, o.x.ulp) == (0, 0)
    refused, done = o.tunings
    assert "tunable" in refused.refusal
    assert (done.sample, done.refusal) == (12, "")
    assert replay(model, "mrac", journal).first is None


def test_a_journal_without_tuning_goes_when_its_run_is_over(tmp_path):
    journal = tmp_path / "journal"
    o = run_on_board(load("triangle"), BoardRequest("path", "sil", samples=10, selftest=0, journal=journal))
    assert o.max_ulp == 0
    assert not journal.exists()
    with pytest.raises(InputError, match="no such file"):
        replay(load("triangle"), "path", journal)


@pytest.mark.share(3)
@pytest.mark.parametrize(("model", "law"), [("triangle", "path"), ("slosh", "lyapunov-v1"), ("satellite", "pd")])
def test_laws_without_memory_are_tuned_too(tmp_path, model, law):
    loaded, journal = load(model), tmp_path / "journal"
    controller = loaded.manifest.controller(law)
    gain = next(q for q in controller.parameters if q.default and q.allows(1.03125 * q.default))
    tune(loaded, law, journal, {gain.name: 1.03125 * gain.default}, 7)
    o = run_on_board(loaded, BoardRequest(law, "sil", samples=20, selftest=0, journal=journal))
    assert [t.refusal for t in o.tunings] == [""]
    assert (o.max_ulp, o.x.ulp) == (0, 0)
    assert np.isfinite(o.board.u_cmd).all()
    assert replay(loaded, law, journal).first is None


@pytest.mark.parametrize(
    "text", ["notes on a tune", '{"at": 3}\nnotes\n', "[1]\n", '{"at": 3, "values": {}}\n' + "[" * 99_999 + "\n"]
)
def test_a_file_of_somebody_beside_the_journal_is_refused_and_stays(tmp_path, text):
    journal = tmp_path / "journal"
    path_of(journal).write_text(text)
    with pytest.raises(InputError, match=r"journal.tune contains no tuning request: remove it"):
        run_on_board(load("triangle"), BoardRequest("path", "sil", samples=3, selftest=0, journal=journal))
    assert path_of(journal).read_text() == text
