# SPDX-License-Identifier: Apache-2.0
"""Bare packets over a line that is told what to answer; the law behind them in float on this machine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from mehvar.runtime import simulate
from mehvar.runtime.board.image.build import program
from mehvar.runtime.board.line.link import LinkError
from mehvar.runtime.board.line.packets import BareLaw
from mehvar.runtime.board.tuning import HostLaw
from tests.runtime.board.conftest import load

ANSWER = np.array([1.0, -2.0, 0.5], "<f4").tobytes()
PIECES = [ANSWER[:5], ANSWER[5:6], ANSWER[6:]]


class Line:
    """Answers what it was told, nothing when that is used up."""

    name = "line"

    def __init__(self, answers: Sequence[bytes]) -> None:
        self.answers, self.packets, self.timeouts = list(answers), list[bytes](), list[float]()

    def write(self, data: bytes) -> None:
        self.packets.append(data)

    def read(self, timeout: float) -> bytes:
        self.timeouts.append(timeout)
        return self.answers.pop(0) if self.answers else b""

    def close(self) -> None:
        pass


def sample(model, law: BareLaw):
    sizes = (len(model.state_names), len(model.manifest.references), len(model.input_names))
    x, r, v = (np.arange(size) + first for size, first in zip(sizes, (1.0, 101.0, 201.0), strict=True))
    return (x, r, v), law(x, r, v, np.zeros(2))[0]


@pytest.mark.parametrize("name", ["mrac", "pd"])
def test_a_packet_is_the_inputs_of_the_law_and_zeros(name):
    model, line = load("satellite"), Line([ANSWER])
    firmware = program(model, name)
    vectors, u = sample(model, BareLaw(line, firmware))
    numbers = np.concatenate(vectors if firmware.law.memory else vectors[:2])
    (packet,) = np.frombuffer(line.packets[0], "<f4")[None]
    assert packet[: len(numbers)].tolist() == numbers.tolist()
    assert not packet[len(numbers) :].any()
    assert u.tolist() == [1.0, -2.0, 0.5]


@pytest.mark.parametrize("late", [0, 1, 9])
def test_only_the_first_packet_is_repeated(late):
    line = Line([b""] * late + [*PIECES, *PIECES])
    law = BareLaw(line, program(load("satellite"), "mrac"), timeout=3.0)
    sample(load("satellite"), law)
    assert line.packets == [line.packets[0]] * (late + 1)
    assert line.timeouts == [0.5] * (late + len(PIECES))
    sample(load("satellite"), law)
    assert len(line.packets) == late + 2
    assert line.timeouts[late + len(PIECES) :] == [3.0] * len(PIECES)
    with pytest.raises(LinkError, match="answers 0 bytes instead of 12 to packet 2"):
        sample(load("satellite"), law)
    assert len(line.packets) == late + 3


@pytest.mark.parametrize(("answers", "size"), [([b""] * 10 + [ANSWER], 0), ([ANSWER[:-1]], 11), ([ANSWER + b"x"], 13)])
def test_an_answer_of_another_size_is_refused(answers, size):
    line = Line(answers)
    with pytest.raises(LinkError, match=f"answers {size} bytes instead of 12 to packet 0"):
        sample(load("satellite"), BareLaw(line, program(load("satellite"), "mrac")))


@pytest.mark.parametrize("name", ["mrac", "pd"])
def test_the_law_on_this_machine_is_the_law_in_float(name):
    model, firmware = load("satellite"), program(load("satellite"), name)
    period = firmware.period
    sampling = {"t_end": 20 * period, "dt_out": period, "hold": period, "delay": 1}
    expected = simulate(model, name, real="float", **sampling)
    law = HostLaw(firmware, expected.parameters)
    run = simulate(model, name, law=law, **sampling)
    assert run.u_cmd.tobytes() == expected.u_cmd.tobytes()
