# SPDX-License-Identifier: Apache-2.0
"""Options of a run, in one table of names, kinds, units, defaults, checks and texts.

The fields of `RunOptions` are its rows. Python, the command line, campaign files, batches, boards and the reference
all read defaults and bounds from them.
"""

from __future__ import annotations

import operator
import sys
from collections.abc import Collection, Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any, Literal, get_args

from mehvar.base.errors import InputError, bad_value, either

from ..model.functions import BackendName, Real
from ..model.parameters import number

Kind = Literal["number", "count", "word"]
Place = Literal["run", "batch", "board"]
Integrator = Literal["rk4", "dopri5", "dop853", "rock4", "rodas5p", "euler", "platen"]
Method = Literal[Integrator, "auto"]
Profile = Literal["portable", "fast"]
Need = Literal["fixed", "adaptive", "sampled", "noise"]

INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)  # numbered as in the native integrator
METHODS: tuple[Method, ...] = get_args(Method)
AUTO: Method = "auto"
"""Method that starts with `EXPLICIT` and repeats a stiff run from the start with `STIFF`."""
EXPLICIT: Integrator = "dop853"
STIFF: Integrator = "rodas5p"
IMPLICIT: tuple[Integrator, ...] = ("rodas5p",)
"""Methods that use the Jacobian of the loop."""
STOCHASTIC: tuple[Integrator, ...] = ("euler", "platen")
"""Methods for process noise, with strong order 1/2, or 1 for commuting noise."""
FIXED: tuple[Integrator, ...] = ("rk4", *STOCHASTIC)
"""Methods with a fixed step."""
SMALLEST_RTOL = 100 * sys.float_info.epsilon  # SciPy's own limit: below it an error estimate is mostly rounding error
_SMALLEST_ATOL = sys.float_info.min  # below it a double has fewer digits
_COUNT_BELOW = 2**31  # the narrowest count in C, the delay, is an int32
_NEEDS: Mapping[Need, str] = {
    "fixed": "the method has a fixed step, as rk4 has",
    "adaptive": "the method is adaptive in its step",
    "sampled": "the law is sampled, by its own period or by `hold`",
    "noise": "the law is sampled and the model has measurement noise or random steps, or the model has process noise",
}
"""Conditions on a loop under which an option has an effect."""


@dataclass(frozen=True)
class Option:
    """A row of the table.

    Attributes
    ----------
    kind : {"number", "count", "word"}
        A finite number, a whole one, or one of `words`.
    text, unit : str
        A one-line description, and the unit of a number.
    default, otherwise : object, str
        Default value, or a description in words if it is None.
    least, above, below : float, optional
        Bounds of a number: at least, larger than, smaller than.
    words : tuple of str
        Allowed words.
    refused : mapping of str to str
        Operations that refuse the option, each with advice.
    needs : {"fixed", "adaptive", "sampled", "noise"}, optional
        Condition on the loop for the option to have an effect; it is refused for other loops.
    name : str
        Name for users; default: the field's name.
    """

    kind: Kind
    text: str
    unit: str = ""
    default: object = None
    otherwise: str = ""
    least: float | None = None
    above: float | None = None
    below: float | None = None
    words: tuple[str, ...] = ()
    refused: Mapping[Place, str] = field(default_factory=dict)
    needs: Need | None = None
    name: str = ""

    @property
    def allowed(self) -> str:
        """Allowed values in words."""
        if self.words:
            return either(self.words)
        kind, digits = ("a whole number", ".0f") if self.kind == "count" else ("a number", ".3g")
        bounds = ((">", self.above), (">=", self.least), ("<", self.below))
        return f"{kind} {' and '.join(f'{sign} {value:{digits}}' for sign, value in bounds if value is not None)}"

    @property
    def meaning(self) -> str:
        """Meaning, and the condition under which the option applies."""
        return f"{self.text}; only where {_NEEDS[self.needs]}" if self.needs else self.text

    @property
    def help(self) -> str:
        """Meaning with allowed words or unit, and default."""
        kind = f": {either(self.words)}" if self.words else f", {self.unit}" if self.unit else ""
        otherwise = self.otherwise or ("" if self.default in (None, MISSING) else f"{self.default}")
        return f"{self.meaning}{kind}{f'; default: {otherwise}' if otherwise else ''}."

    def check(self, value: object, origin: str, place: Place | None = None) -> Any:
        """Return a value, converted and checked.

        Raises
        ------
        InputError
            If the value is not allowed, or the operation refuses the option.
        """
        if place is not None and place in self.refused:
            raise bad_value(self.name, value, self.refused[place], origin)
        if value is None and self.default is None:
            return None
        if self.words:
            if not isinstance(value, str) or value not in self.words:
                raise bad_value(self.name, value, self.allowed, origin)
            return value
        result = number(self.name, value, origin)
        whole = self.kind == "count" and result.is_integer()
        if not self._holds(result) or (self.kind == "count" and not whole):
            raise bad_value(self.name, value, self.allowed, origin)
        return _count(value, result) if whole else result

    def _holds(self, value: float) -> bool:
        return (
            (self.above is None or value > self.above)
            and (self.least is None or value >= self.least)
            and (self.below is None or value < self.below)
        )


def number_option(default: object, text: str, unit: str = "", **more: Any) -> Any:
    """Return the field of a number; `default` may be MISSING."""
    return _option_field(default, Option("number", text, unit, **more))


def count_option(default: object, text: str, least: int = 0, **more: Any) -> Any:
    """Return the field of a whole number; `default` may be MISSING."""
    return _option_field(default, Option("count", text, least=least, below=_COUNT_BELOW, **more))


def word_option(default: object, text: str, words: tuple[str, ...], **more: Any) -> Any:
    """Return the field of a choice of words; `default` may be MISSING."""
    return _option_field(default, Option("word", text, words=words, **more))


def _option_field(default: object, option: Option) -> Any:
    return field(default=default, metadata={"option": option})


def rows(table: type) -> dict[str, Option]:
    """Return the options among a dataclass's fields; required ones have the default `MISSING`."""
    return {
        f.name: replace(row := f.metadata["option"], name=row.name or f.name, default=f.default)
        for f in fields(table)
        if "option" in f.metadata
    }


def _count(value: object, number: float) -> int:
    """Return an integer exactly, without conversion to a float, which loses digits above 2^53."""
    try:
        return operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return int(number)


_BY_BOARD: dict[Place, str] = {"board": "left out: the board decides it"}
_IN_BATCH: dict[Place, str] = {"run": "left out: only a batch has it", "board": "left out: only a batch has it"}


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Checked options of a run.

    Raises
    ------
    InputError
        For a value that its row does not allow.
    """

    t_end: float | None = number_option(
        None,
        "End time",
        "s",
        otherwise="the scenario's duration",
        above=0.0,
        refused={"board": "left out: the number of samples decides it"},
    )
    dt_out: float | None = number_option(
        None,
        "Sampling step of the result, which also contains the end of the run",
        "s",
        otherwise="the scenario's step",
        above=0.0,
        refused=_BY_BOARD,
    )
    hold: float | None = number_option(
        None,
        "Sample period of the law, with held input in between; a multiple or a whole fraction of `dt_out`",
        "s",
        otherwise="the law's period, or else none",
        above=0.0,
    )
    delay: int = count_option(
        0, "Samples between computing and applying an input, which is zero before", needs="sampled"
    )
    seed: int = count_option(
        0, "Seed of the noise", refused={"batch": "given with --seed, or as seed of the batch"}, needs="noise"
    )
    run: int = count_option(
        0,
        "Run of a batch with this seed whose noise is used",
        refused={"batch": "left out: a batch counts its runs"},
        needs="noise",
    )
    real: Real = word_option(
        "double",
        "Number type of the law; float needs the C backend",
        get_args(Real),
        needs="sampled",
        refused={"batch": "left out: a batch computes in double", **_BY_BOARD},
    )
    method: Method = word_option(
        "dop853",
        "Integration method; rk4, and for noise euler and platen, have fixed steps; auto is "
        "dop853, or rodas5p for a stiff run",
        METHODS,
    )
    rtol: float = number_option(1e-11, "Relative tolerance", least=SMALLEST_RTOL, below=1.0, needs="adaptive")
    atol: float = number_option(1e-11, "Absolute tolerance", least=_SMALLEST_ATOL, below=1.0, needs="adaptive")
    step: float | None = number_option(
        None, "Largest step", "s", otherwise="the sampling step", above=0.0, needs="fixed"
    )
    max_steps: int = count_option(100_000, "Largest number of trial steps between two samples", least=1)
    backend: BackendName | None = word_option(
        None,
        "Evaluation of the functions, by the generated C, the generated Python module, or CasADi's own C",
        get_args(BackendName),
        otherwise="c where there is a compiler",
        refused={"batch": "left out: a batch runs our own C in lanes", **_BY_BOARD},
    )
    profile: Profile = word_option(
        "portable",
        "portable: bit-identical on every machine; fast: the compiler may fuse products and sums",
        get_args(Profile),
        refused=_IN_BATCH,
    )

    def __post_init__(self) -> None:
        for name, row in OPTIONS.items():
            value = getattr(self, name)
            if value is not row.default:
                object.__setattr__(self, name, row.check(value, "the call"))

    def changes(self) -> dict[str, Any]:
        """Return the values that differ from the defaults, by name."""
        return {name: value for name, row in OPTIONS.items() if (value := getattr(self, name)) != row.default}


OPTIONS = rows(RunOptions)


def read_options(settings: Mapping[str, object], place: Place, origin: str) -> tuple[RunOptions, dict[str, object]]:
    """Return the checked options among settings, and all other settings.

    Parameters
    ----------
    settings : mapping of str to object
        Values by name.
    place : {"run", "batch", "board"}
        Where the options apply.
    origin : str
        Origin of the settings in error messages.

    Raises
    ------
    InputError
        For an option that its row or the operation does not allow.
    """
    options = {name: OPTIONS[name].check(value, origin, place) for name, value in settings.items() if name in OPTIONS}
    return RunOptions(**options), {name: value for name, value in settings.items() if name not in OPTIONS}


def check_effects(given: Mapping[str, object], method: Method, sampled: bool, noisy: bool, origin: str) -> None:
    """Refuse options without effect.

    Parameters
    ----------
    given : mapping of str to object
        Options given by the user, even if equal to the default; None stands for an option that is not given.
    method : str
        Method of the run.
    sampled, noisy : bool
        True for a sampled law, and for runs that depend on a seed.
    origin : str
        Origin of the options in error messages.

    Raises
    ------
    InputError
        For the first option without an effect; the message says what it needs.
    """
    holds: Mapping[Need, bool] = {
        "fixed": method in FIXED,
        "adaptive": method not in FIXED,
        "sampled": sampled,
        "noise": noisy,
    }
    for name, value in given.items():
        need = OPTIONS[name].needs
        if value is not None and need is not None and not holds[need]:
            raise bad_value(name, value, f"left out unless {_NEEDS[need]}", origin)


def split_settings(
    settings: Mapping[str, object], choices: Collection[str], place: Place, origin: str
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return parameters and options among settings separately.

    Parameters
    ----------
    settings : mapping of str to object
        Values by name.
    choices : collection of str
        Names of the model's choices.
    place, origin : str
        As for `read_options`.

    Raises
    ------
    InputError
        For an option that its row or the operation does not allow. Parameters are checked by the caller.
    """
    options, others = read_options(settings, place, origin)
    selection = {name: others.pop(name) for name in choices if name in others}
    given = {name: getattr(options, name) for name in settings if name in OPTIONS}
    return others, {**given, **selection}


def merged(parameters: Mapping[str, Any], others: Mapping[str, Any], origin: str) -> dict[str, Any]:
    """Return parameters from a mapping and keywords, merged.

    Raises
    ------
    InputError
        If one is given twice, or the mapping contains an option.
    """
    for name, value in parameters.items():
        if name in OPTIONS:
            raise bad_value(name, value, f"given as a keyword, {name}=..., and not in `parameters`", origin)
    twice = [name for name in others if name in parameters]
    if twice:
        raise InputError(f"{twice[0]} is given twice (from {origin}): in `parameters` and as an option")
    return {**parameters, **others}


def first_integrator(method: Method) -> Integrator:
    """Return the integrator that a run starts with."""
    return EXPLICIT if method == "auto" else method
