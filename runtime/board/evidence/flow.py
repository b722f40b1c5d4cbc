# SPDX-License-Identifier: Apache-2.0
"""Upper bounds on a function's number of instructions, derived from the image.

A function is a graph of blocks. Without loops, the bound is its longest path. A loop is bounded if a register moves
between two known values in constant steps; its bound is the number of iterations times the longest iteration. A jump
through a register, or a loop whose end depends on data, is unbounded, with the reason.
"""

from __future__ import annotations

import contextlib
import functools
import re
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Set
from typing import TypeVar

from ..image.elf import Elf
from ..image.instructions import Instruction, UnboundedError, instructions

_ARGUMENTS = ("r0", "r1", "r2", "r3")
_CALLER_SAVED = (*_ARGUMENTS, "ip", "r12", "lr")
_LITERAL = re.compile(r"ldr(?:\.w)? (\w+), \[pc, #(-?0x[0-9a-f]+|-?\d+)\]")
_PC_AHEAD = 4
"""Number of bytes by which the program counter is ahead of the instruction that reads it."""

Value = tuple[str, int]
"""Value of a register: a constant (register "") or an offset from another register at the function's start."""
State = dict[str, Value]
Node = TypeVar("Node", bound=Hashable)

_END = Instruction(-1, 0, "", "")


class Flow:
    """Longest paths through the functions of an image."""

    def __init__(self, elf: Elf) -> None:
        self.elf = elf
        self._known: dict[tuple[str, tuple[Value, ...]], int] = {}
        self._called: dict[str, set[str]] = {}

    def worst(self, name: str, arguments: Mapping[str, Value] | None = None, above: tuple[str, ...] = ()) -> int:
        """Return the largest number of instructions per call, with those of called functions.

        Parameters
        ----------
        arguments : mapping, optional
            Known values of its first four registers.
        above : tuple of str
            Its callers.

        Raises
        ------
        UnboundedError
            For recursion, a jump through a register, or a loop without a counting register.
        """
        if name in above:
            raise UnboundedError(f"{name} is recursive")
        given = {r: (arguments or {}).get(r, (r, 0)) for r in _ARGUMENTS}
        key = (name, tuple(given.values()))
        if key not in self._known:
            self._known[key] = _Function(self, name, given, above).worst()
        return self._known[key]

    def called(self, name: str) -> set[str]:
        """Return the functions that a function calls or jumps to, by address or by a register with known value."""
        if name not in self._called:
            jumps = [i for i in instructions(self.elf, name) if i.target is not None]
            called = {owner for i in jumps if (owner := self.owner(i.target)) and (i.call or owner != name)}
            with contextlib.suppress(UnboundedError):
                called |= _Function(self, name, {}, ()).called()
            self._called[name] = called
        return self._called[name]

    def callees(self, name: str) -> set[str]:
        """Return the functions that a function calls, directly or indirectly; with itself only if it is recursive."""
        return set().union(*(_reachable(self.called, called) for called in self.called(name)))

    def loops(self, name: str) -> int:
        """Return the number of a function's outermost loops.

        Raises
        ------
        UnboundedError
            For a jump whose target is unknown.
        """
        return _Function(self, name, {}, ()).loops()

    def owner(self, address: int | None) -> str | None:
        """Return the function that starts at an address."""
        return None if address is None else self.elf.starts.get(address)


class _Function:
    def __init__(self, flow: Flow, name: str, given: State, above: tuple[str, ...]) -> None:
        self._flow, self._name, self._above = flow, name, (*above, name)
        self._instructions = {i.address: i for i in instructions(flow.elf, name)}
        self._blocks = self._cut()
        self._next = {first: list(self._successors(first)) for first in self._blocks}
        self._entry = min(self._blocks)
        self._states = self._propagated(given)

    def worst(self) -> int:
        """Return the length of the longest path from the entry."""
        return self._longest(set(self._blocks), self._entry)

    # blocks

    def _cut(self) -> dict[int, list[Instruction]]:
        """Return the basic blocks by first address; jumps and their targets separate them."""
        first = min(self._instructions)
        leaders = {first}
        for i in self._instructions.values():
            if i.target in self._instructions and not i.call:
                leaders.add(i.target)
            if i.conditional or i.leaves or i.returns_if:
                leaders.add(i.address + i.size)
        blocks: dict[int, list[Instruction]] = {}
        leader = first
        for address in sorted(self._instructions):
            leader = address if address in leaders else leader
            blocks.setdefault(leader, []).append(self._instructions[address])
        return blocks

    def _successors(self, first: int) -> Iterator[int]:
        """Yield the blocks that may follow a block; refuse jumps whose target is unknown."""
        block = self._blocks[first]
        last = block[-1]
        if last.target is not None and not last.call:
            if last.target in self._instructions:
                yield last.target
            elif self._flow.owner(last.target) is None:
                raise UnboundedError(f"{self._name} jumps to {last.target:#010x}, where no function begins")
        elif last.leaves and not last.returns:
            raise UnboundedError(f"{self._name} jumps through a register at {last.address:#010x}")
        within_if = len(block) > 1 and block[-2].name.startswith("it")
        if (not last.leaves or within_if) and last.address + last.size in self._blocks:
            yield last.address + last.size

    # what registers hold

    def _propagated(self, given: State) -> dict[int, State]:
        """Return the known register values at the start of each block."""
        states: dict[int, State] = {self._entry: {**given, "sp": ("sp", 0)}}
        waiting = [self._entry]
        while waiting:
            first = waiting.pop()
            after = self._after(first, states[first])
            for following in self._next[first]:
                merged = after if following not in states else _common(states[following], after)
                if states.get(following) != merged:
                    states[following] = merged
                    waiting.append(following)
        return states

    def _after(self, first: int, state: State) -> State:
        *_, (_, after) = self._through(first, state)
        return after

    def _through(self, first: int, state: State) -> Iterator[tuple[Instruction, State]]:
        """Yield each instruction of a block with the known values before it, then the values after the block."""
        state = dict(state)
        condition = 0
        for i in self._blocks[first]:
            yield i, state
            value = self._value(i, state) if condition == 0 else None
            condition = max(0, condition - 1)
            if i.name.startswith("it"):
                condition = len(i.name) - 1
            for register in (*i.writes, *(_CALLER_SAVED if i.call else ())):
                state.pop(register, None)
            if value is not None:
                state[value[0]] = value[1]
        yield _END, state

    def _value(self, i: Instruction, state: State) -> tuple[str, Value] | None:
        """Return the register that an instruction sets to a known value, possibly a constant of the image."""
        if match := _LITERAL.fullmatch(f"{i.mnemonic} {i.operands}"):
            place = (i.address + _PC_AHEAD & ~3) + int(match[2], 0)
            return match[1], ("", int.from_bytes(self._flow.elf.stored(place, 4), "little"))
        return _value(i, state)

    # calls

    def called(self) -> set[str]:
        """Return the called functions, by address or by a register with known value."""
        steps = (step for n, before in self._states.items() for step in self._through(n, before))
        return {callee for step in steps if (callee := self._callee(*step))}

    def _callee(self, i: Instruction, state: State) -> str | None:
        """Return the function that an instruction calls or jumps to."""
        target = i.target if i.call or i.target not in self._instructions else None
        if i.call and state.get(i.operands, ("unknown", 0))[0] == "":
            target = state[i.operands][1] & ~1
        return self._flow.owner(target)

    # lengths

    def _cost(self, first: int) -> int:
        """Return the instructions of a block, with those of its calls."""
        total = len(self._blocks[first])
        for i, state in self._through(first, self._states.get(first, {})):
            called = self._callee(i, state)
            if i.call and called is None:
                raise UnboundedError(f"{self._name} calls through a register at {i.address:#010x}")
            if called is not None:
                arguments = {r: state[r] for r in _ARGUMENTS if r in state and state[r][0] == ""}
                total += self._flow.worst(called, arguments, self._above)
        return total

    def _longest(self, nodes: Set[int], entry: int) -> int:
        """Return the longest path from an entry within given blocks that does not return to the entry."""
        arrows = {n: [m for m in self._next[n] if m in nodes and m != entry] for n in nodes}
        length: dict[int, int] = {}
        for component in _components(arrows, entry):  # each after its successors
            rest = max((length[m] for n in component for m in arrows[n] if m not in component), default=0)
            loop = self._loops(component, arrows)
            cost = self._turns(component, nodes) if loop else self._cost(next(iter(component)))
            length |= dict.fromkeys(component, cost + rest)
        return length[entry]

    def loops(self) -> int:
        """Return the number of outermost loops."""
        return sum(self._loops(c, self._next) for c in _components(self._next, min(self._blocks)))

    @staticmethod
    def _loops(component: Set[int], arrows: Mapping[int, list[int]]) -> bool:
        return len(component) > 1 or any(n in arrows[n] for n in component)

    def _turns(self, loop: Set[int], nodes: Set[int]) -> int:
        """Return the length of a loop: its longest iteration times their number."""
        entries = {m for n in nodes - loop for m in self._next[n] if m in loop}
        if len(entries) != 1:
            raise self._unbounded(loop, "it has more than one entry")
        (header,) = entries
        return self._count(loop, header) * self._longest(loop, header)

    def _count(self, loop: Set[int], header: int) -> int:
        """Return the largest number of iterations of a loop."""
        before = [self._after(n, self._states[n]) for n in self._blocks if header in self._next[n] and n not in loop]
        start = functools.reduce(_common, before)
        for first in sorted(loop):
            block = self._blocks[first]
            leaves = block[-1].conditional and any(m not in loop for m in self._next[first])
            if leaves or block[-1].returns_if:
                count = self._counted(loop, start, block)
                if count is not None:
                    return count
        raise self._unbounded(loop, "no register counts its iterations between known values")

    def _counted(self, loop: Set[int], start: State, block: list[Instruction]) -> int | None:
        """Return the largest number of turns of a loop with one counter and a constant step; None for others."""
        last = block[-1]
        zero = last.name.startswith("cb")
        test = last if zero else next((i for i in reversed(block[:-1]) if _sets_flags(i)), None)
        if test is None:
            return None
        limits = [(last.operands.split(",")[0], 0)] if zero else _compared(test, start)
        for register, other in limits:
            steps = [(i, step) for n in loop for i in self._blocks[n] if (step := _step(i, register)) is not None]
            changed = [i for n in loop for i in self._blocks[n] if register in i.writes]
            if len(steps) != 1 or len(changed) != 1 or register not in start:
                continue
            if isinstance(other, str):
                if other not in start or any(other in i.writes for n in loop for i in self._blocks[n]):
                    continue
                limit = start[other]
            else:
                limit = ("", other)
            i, step = steps[0]
            if limit[0] != start[register][0]:
                continue
            distance = limit[1] - start[register][1]
            after = i in block and i.address <= test.address
            if step == 0 or distance * step < 0 or (distance == 0 and after) or (last.exact and distance % step):
                continue
            turns = -(-abs(distance) // abs(step))
            return turns + (0 if after and last.exact else 1)
        return None

    def _unbounded(self, loop: Set[int], why: str) -> UnboundedError:
        return UnboundedError(f"{self._name} has a loop at {min(loop):#010x}: {why}")


def _common(one: State, other: State) -> State:
    return {register: value for register, value in one.items() if other.get(register) == value}


def _components(arrows: Mapping[int, list[int]], entry: int) -> list[frozenset[int]]:
    """Return the strongly connected components reachable from an entry, successors first."""
    reach = {node: _reachable(arrows.__getitem__, node) for node in _reachable(arrows.__getitem__, entry)}
    components = {frozenset(other for other in nodes if node in reach[other]) for node, nodes in reach.items()}
    return sorted(components, key=lambda component: len(reach[min(component)]))  # a successor reaches fewer nodes


def _reachable(arrows: Callable[[Node], Iterable[Node]], entry: Node) -> set[Node]:
    """Return the nodes that are reachable from an entry, with the entry."""
    reached, work = {entry}, [entry]
    while work:
        fresh = set(arrows(work.pop())) - reached
        reached |= fresh
        work += fresh
    return reached


_REGISTER_NUMBER = re.compile(r"(\w+), (?:(\w+), )?#(-?0x[0-9a-f]+|-?\d+)$")
_REGISTER_REGISTER = re.compile(r"(\w+), (?:(\w+), )?(\w+)(?:, lsl #(\d+))?$")


def _value(i: Instruction, state: State) -> tuple[str, Value] | None:
    """Return the register that an instruction sets to a known value, with the value."""
    if match := _REGISTER_NUMBER.match(i.operands):
        to, source, number = match[1], match[2] or match[1], int(match[3], 0)
        if i.name in ("mov", "movs", "movw") and match[2] is None:
            return to, ("", number)
        if i.name in ("add", "adds", "addw", "sub", "subs", "subw") and source in state:
            base, offset = state[source]
            return to, (base, offset + (number if i.name.startswith("add") else -number))
    elif match := _REGISTER_REGISTER.match(i.operands):
        shift = int(match[4] or 0)
        if i.name in ("mov", "movs") and match[2] is None and match[3] in state and not shift:
            return match[1], state[match[3]]
        if i.name in ("add", "adds"):
            one, other = state.get(match[2] or match[1]), state.get(match[3])
            if shift and other:
                other = (other[0], other[1] << shift) if other[0] == "" else None
            if one and other and "" in (one[0], other[0]):
                return match[1], (one[0] or other[0], one[1] + other[1])
    return None


def _sets_flags(i: Instruction) -> bool:
    return i.name in ("cmp", "subs", "adds") or "cpsr" in i.writes


def _compared(test: Instruction, start: State) -> list[tuple[str, str | int]]:
    """Return the operands of a comparison that always runs, in both orders if both are registers."""
    if test.condition:
        return []
    if test.name == "cmp":
        if match := _REGISTER_NUMBER.match(test.operands):
            return [(match[1], int(match[3], 0))]
        if (match := _REGISTER_REGISTER.match(test.operands)) and match[2] is match[4] is None:
            return [(match[1], match[3]), (match[3], match[1])]
    if test.name == "subs" and (match := _REGISTER_NUMBER.match(test.operands)) and match[1] in start:
        return [(match[1], 0)]
    return []


_WRITEBACK = re.compile(r"\[(\w+)\], #(-?0x[0-9a-f]+|-?\d+)$|\[(\w+), #(-?0x[0-9a-f]+|-?\d+)\]!$")


def _step(i: Instruction, register: str) -> int | None:
    """Return the change of a register by an instruction that always runs."""
    if i.condition:
        return None
    if match := _WRITEBACK.search(i.operands):
        base, number = (match[1], match[2]) if match[1] else (match[3], match[4])
        loaded = i.operands.split(",")[0] == register
        return int(number, 0) if base == register and not loaded else None
    if (match := _REGISTER_NUMBER.match(i.operands)) and match[1] == register and match[2] in (None, register):
        if i.name in ("add", "adds", "addw"):
            return int(match[3], 0)
        if i.name in ("sub", "subs", "subw"):
            return -int(match[3], 0)
    return None
