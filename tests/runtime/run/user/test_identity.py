# SPDX-License-Identifier: Apache-2.0
"""The identity of a law in Python: whatever it reads from the user's modules changes it, or it has none."""

from __future__ import annotations

import datetime
import decimal
import importlib
import os
import random
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from time import perf_counter
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from mehvar import runtime
from mehvar.base.errors import InputError
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.run.user.identity import identify
from mehvar.runtime.run.user.law import python_law

GAINS = """
from collections import defaultdict
from types import SimpleNamespace
from typing import NamedTuple
import numpy as np
K = 2.0
TABLE = {"soft": [1.0, 2.0], "hard": (np.arange(3.0), {4.0})}
PLACES = SimpleNamespace(low=1.0)
class Gains:
    factor = 2.0
    def __init__(self, k):
        self.k = k
    @property
    def doubled(self):
        return self.factor * self.k
    @staticmethod
    def offset():
        return 0.25
own = Gains(1.0)
def helper(x, scale=2.0, *, shift=0.5):
    return scale * deeper(x) + shift
def deeper(x):
    return K * x
def scaled(k):
    return lambda x: k * x
one, two = scaled(1.0), scaled(2.0)
class Row(list): pass
class Table(dict): pass
class Pair(tuple): pass
class Real(float): pass
class Matrix(np.ndarray): pass
holders = Row(), Table(), Pair(), Real(), np.zeros(1).view(Matrix)
for holder, level in zip(holders, (1.0, 2.0, 3.0, 4.0, 5.0)):
    holder.level = level
row, named, pair, real, matrix = holders
class Meta(type):
    level = 1.0
class Metered(metaclass=Meta):
    "2.0"
class Step(NamedTuple):
    size: float
step, choices, missing = Step(0.5), {"b": 1.0, "a": 2.0}, defaultdict(lambda: 3.0)
helper.level = 1.5
helper.__doc__ = "2.5"
np.level = 6.0
level_of, first = {"soft": 7.0}.get, np.array([8.0]).item
np.level_of = {"hard": 9.0}.get
"""
LAWS = """
import math
import os
import sys
from collections import deque
import numpy as np
import gains
from gains import K as COPY, helper, own, one, two
import package.inner
MINE = 3.0
class Base:
    slope = 1.0
class Law(Base):
    level = 4.0
    def u(self, t, x):
        return [self.slope * self.level * x[0]]
law_object = Law()
def module(t, x): return [gains.K * x[0]]
def inner(t, x): return [package.inner.DEEP * x[0]]
def table(t, x): return [gains.TABLE["hard"][0][1] * x[0]]
def place(t, x): return [gains.PLACES.low * x[0]]
def copied(t, x): return [COPY * x[0]]
def mine(t, x): return [sum(MINE * angle for angle in [x[0]]) + math.sin(np.pi)]
def called(t, x): return [helper(x[0])]
def instance(t, x): return [own.doubled * x[0] + own.offset()]
def default(t, x, k=5.0, *, j=6.0): return [k * j * x[0]]
def closures(t, x): return [one(x[0]) + two(x[0])]
def lazy(t, x):
    import math
    return [math.sin(x[0]) * gains.K]
method = law_object.u
def around(k):
    def law(t, x):
        def within():
            return k * x[0]
        return [within()]
    return law
closed = around(7.0)
def whole(t, x): return [vars(gains)["K"] * x[0]]
def dynamic(t, x): return [getattr(gains, "K") * x[0]]
def imports(t, x):
    import gains
    return [gains.K * x[0]]
def writes(t, x):
    global MINE
    MINE = MINE + 1
    return [MINE * x[0]]
generator = np.random.default_rng(1)
def random(t, x): return [generator.normal() * x[0]]
def attribute(t, x): return [attribute.k * helper.level * x[0]]
attribute.k = 2.0
def text(t, x): return [float(helper.__doc__) * float(gains.Metered.__doc__) * x[0]]
def row(t, x): return [gains.row.level * x[0]]
def named(t, x): return [gains.named.level * x[0]]
def pair(t, x): return [gains.pair.level * x[0]]
def real(t, x): return [gains.real.level * x[0]]
def matrix(t, x): return [gains.matrix.level * x[0]]
def metered(t, x): return [gains.Metered.level * x[0]]
def step(t, x): return [gains.step.size * x[0]]
def order(t, x): return [next(iter(gains.choices.values())) * x[0]]
def absent(t, x): return [gains.missing["k"] * x[0]]
def patched(t, x): return [np.level * x[0]]
def bound(t, x): return [gains.level_of("soft") * gains.first() * x[0]]
def patched_bound(t, x): return [np.level_of("hard") * x[0]]
def evaluates(t, x): return [eval("gains.K") * x[0]]
def global_table(t, x): return [globals()["MINE"] * x[0]]
def through(t, x): return [getattr(helper, "__globals__")["K"] * x[0]]
def loaded(t, x): return [sys.modules["gains"].K * x[0]]
def environment(t, x): return [float(os.environ.get("K", "1")) * x[0]]
def lazily(t, x):
    import os
    return [float(os.environ.get("K", "1")) * x[0]]
each = np.frompyfunc(lambda angle: gains.K * angle, 1, 1)
def vectorized(t, x): return [each(x[0])]
class Queue(deque): pass
queue = Queue([1.0])
queue.level = 1.0
def queued(t, x): return [queue[0] * x[0]]
"""
CHANGES: dict[str, list[tuple[str, str, str]]] = {
    "module": [("gains", "K = 2.0", "K = 3.0")],
    "inner": [("package/inner", "DEEP = 1.0", "DEEP = 2.0")],
    "table": [
        ("gains", "[1.0, 2.0]", "[1.0, 2.5]"), ("gains", "{4.0}", "{4.5}"), ("gains", "arange(3.0)", "arange(4.0)"),
    ],
    "place": [("gains", "low=1.0", "low=2.0")],
    "copied": [("gains", "K = 2.0", "K = 3.0")],
    "mine": [("laws", "MINE = 3.0", "MINE = 4.0")],
    "called": [
        ("gains", "K = 2.0", "K = 3.0"), ("gains", "scale=2.0", "scale=3.0"), ("gains", "shift=0.5", "shift=0.6"),
        ("gains", "K * x", "K + x"),
    ],
    "instance": [
        ("gains", "factor = 2.0", "factor = 3.0"), ("gains", "Gains(1.0)", "Gains(2.0)"),
        ("gains", "self.factor *", "self.factor +"), ("gains", "return 0.25", "return 0.5"),
    ],
    "default": [("laws", "k=5.0", "k=5.5"), ("laws", "j=6.0", "j=6.5")],
    "closures": [("gains", "scaled(1.0)", "scaled(1.5)"), ("gains", "scaled(2.0)", "scaled(2.5)")],
    "lazy": [("gains", "K = 2.0", "K = 3.0")],
    "method": [("laws", "slope = 1.0", "slope = 2.0"), ("laws", "level = 4.0", "level = 5.0")],
    "closed": [("laws", "around(7.0)", "around(8.0)")],
    "attribute": [("laws", "attribute.k = 2.0", "attribute.k = 2.5"), ("gains", "level = 1.5", "level = 1.75")],
    "text": [("gains", '"2.5"', '"3.5"'), ("gains", '"2.0"', '"3.0"')],
    "row": [("gains", "(1.0, 2.0, 3.0, 4.0, 5.0)", "(1.5, 2.0, 3.0, 4.0, 5.0)")],
    "named": [("gains", "(1.0, 2.0, 3.0, 4.0, 5.0)", "(1.0, 2.5, 3.0, 4.0, 5.0)")],
    "pair": [("gains", "(1.0, 2.0, 3.0, 4.0, 5.0)", "(1.0, 2.0, 3.5, 4.0, 5.0)")],
    "real": [("gains", "(1.0, 2.0, 3.0, 4.0, 5.0)", "(1.0, 2.0, 3.0, 4.5, 5.0)")],
    "matrix": [("gains", "(1.0, 2.0, 3.0, 4.0, 5.0)", "(1.0, 2.0, 3.0, 4.0, 5.5)")],
    "metered": [("gains", "level = 1.0", "level = 1.25")],
    "step": [("gains", "Step(0.5)", "Step(0.75)")],
    "order": [("gains", '{"b": 1.0, "a": 2.0}', '{"a": 2.0, "b": 1.0}')],
    "absent": [("gains", "lambda: 3.0", "lambda: 3.5")],
    "patched": [("gains", "np.level = 6.0", "np.level = 6.5")],
    "bound": [("gains", '"soft": 7.0', '"soft": 7.5'), ("gains", "array([8.0])", "array([8.5])")],
    "patched_bound": [("gains", '"hard": 9.0', '"hard": 9.5')],
}  # fmt: skip
"""Text that each law reads in its module, and the text it is changed to."""
UNTOLD = {
    "whole": "vars is read",
    "dynamic": "the module laws.gains is used as a whole",
    "imports": "imports imports gains during a run",
    "writes": "writes sets the global MINE",
    "random": "laws.generator is of numpy.random",
    "evaluates": "eval is read",
    "global_table": "globals is read",
    "through": "through reads __globals__",
    "loaded": "sys.modules is read",
    "environment": "os.environ is read",
    "lazily": "lazily imports os",
    "vectorized": "laws.each was made by numpy.frompyfunc",
    "queued": "laws.queue is of laws.Queue, whose state cannot be read",
}
TEXTS = {"gains": GAINS, "laws": LAWS, "package/__init__": "", "package/inner": "DEEP = 1.0\n"}


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    (tmp_path / "package").mkdir()
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield tmp_path
    forget()


def forget() -> None:
    for name in ("gains", "laws", "package", "package.inner"):
        sys.modules.pop(name, None)


def laws(project: Path, changed: str = "", old: str = "", new: str = "") -> ModuleType:
    """Import the modules as a new process would."""
    forget()
    for name, text in TEXTS.items():
        assert name != changed or old in text
        (project / f"{name}.py").write_text(text.replace(old, new) if name == changed else text)
    importlib.invalidate_caches()
    return importlib.import_module("laws")


@pytest.mark.parametrize("name", CHANGES)
def test_whatever_a_law_reads_from_modules_of_the_user_changes_it(name: str, project: Path) -> None:
    before, why = identify(getattr(laws(project), name))
    assert before, why
    assert identify(getattr(laws(project), name))[0] == before, "the same modules in another process"
    for place, old, new in CHANGES[name]:
        assert identify(getattr(laws(project, place, old, new), name))[0] not in ("", before), (place, new)
    unread = getattr(laws(project, "gains", "import numpy as np", "import numpy as np\nUNREAD = 1"), name)
    assert identify(unread)[0] == before


@pytest.mark.parametrize("name", UNTOLD)
def test_what_cannot_be_told_is_named(name: str, project: Path) -> None:
    text, why = identify(getattr(laws(project), name))
    assert text == ""
    assert UNTOLD[name] in why


def test_a_number_that_is_set_while_python_runs_counts_too(project: Path) -> None:
    module = laws(project)
    before = identify(module.module)
    module.gains.K = 9.0
    assert identify(module.module) != before


def test_a_store_goes_on_under_the_same_numbers_only(pendulum: runtime.Model, project: Path) -> None:
    def batch(module: ModuleType, name: str, **more: Any) -> None:
        vary = {"angle": "uniform(-0.1, 0.1)"}
        campaign = Campaign(f"python:{name}", n=8, vary=vary, options={"t_end": 0.2})
        own = python_law(getattr(module, name), pendulum.manifest, 0.05, None, "the call")
        run_batch(pendulum, campaign, project / "runs.zarr", own=own, **more)

    batch(laws(project), "module", chunk=4)
    (project / "runs.zarr" / "records" / "1.json").unlink()
    with pytest.raises(InputError, match=r"law = 'gains.K = float 2.0', not 'gains.K = float 3.0'"):
        batch(laws(project, "gains", "K = 2.0", "K = 3.0"), "module", resume=True)
    with pytest.raises(InputError, match=r"cannot be identified: the module laws.gains is used as a whole"):
        batch(laws(project), "dynamic", resume=True)


def _clock(t, x):
    return -x[:1] * time.time()


def _clock_by_name(t, x):
    return -x[:1] * perf_counter()


def _clock_within(t, x):
    from time import monotonic

    return -x[:1] * monotonic()


def _module_kept(t, x):
    clock = time
    return -x[:1] * clock.time()


def _date(t, x):
    return -x[:1] * datetime.datetime.now(datetime.UTC).second


def _unseeded(t, x):
    return -x[:1] * random.random()


def _numpys(t, x):
    return -x[:1] + np.random.normal()  # noqa: NPY002


def _numpys_own(t, x):
    return -x[:1] + np.random.default_rng().normal()


def _system(t, x):
    return -x[:1] * os.urandom(1)[0]


def _file(t, x):
    with open("gain.txt") as file:  # noqa: PTH123
        return -x[:1] * float(file.read())


def _table(t, x):
    return -x[:1] * np.loadtxt("gain.txt")


def _place(t, x):
    return -x[:1] * id(x)


def _setting(t, x):
    return -x[:1] * sys.getrecursionlimit()


def _precision(t, x):
    return -x[:1] * float(decimal.Decimal(1) / 3)


MOVING = (
    *(_clock, _clock_by_name, _clock_within, _module_kept, _date, _unseeded, _numpys, _numpys_own, _system, _file),
    *(_table, _place, _setting, _precision),
)


@pytest.mark.parametrize("law", MOVING, ids=lambda law: law.__name__)
def test_a_law_that_reads_a_clock_a_generator_or_a_file_is_never_the_same(law: Callable[..., Any]) -> None:
    text, why = identify(law)
    assert text == ""
    assert "depends on more than t and x" in why or "during a run" in why


def typed(text: str) -> Callable[..., Any]:
    """Return the law of a text without a file, as typed at Python's prompt."""
    scope: dict[str, Any] = {"__name__": "__main__"}
    exec(text, scope)
    law: Callable[..., Any] = scope["law"]
    return law


def test_a_law_typed_at_the_prompt_is_identified_by_its_code() -> None:
    text = "k = 2.0\ndef law(t, x):\n    return [k * x[0]]\n"
    known, reason = identify(typed(text))
    assert known.startswith("def law: source not found")
    assert not reason
    assert known == identify(typed("\n" + text))[0]
    assert known != identify(typed(text.replace("2.0", "2.5")))[0]
    assert known != identify(typed(text.replace("k * x[0]", "k + x[0]")))[0]
