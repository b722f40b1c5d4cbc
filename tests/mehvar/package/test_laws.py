# SPDX-License-Identifier: Apache-2.0
"""Laws as functions on states of their caller's: several in one image, checked parameters and inputs, no library."""

from __future__ import annotations

import functools
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import mehvar
from mehvar import runtime
from mehvar.package.files import package
from mehvar.package.law import law_facts, law_name
from mehvar.parts import AttitudeFilter, Gyro, Hub, Spacecraft, StarTracker, Wheel
from mehvar.runtime.board.image.build import Program, delay_of, program
from mehvar.runtime.board.tuning import HostLaw
from mehvar.runtime.compiling.compiler import write_sources
from mehvar.runtime.run.problem import start_memory
from tests.mehvar.cli.test_app import refused
from tests.tools import needs

HERE = Path(__file__).parent
SAMPLES = 12
CORTEX = "-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -O2"
PROJECT = """\
cmake_minimum_required(VERSION 3.16)
project(three C)
add_subdirectory(satellite)
add_subdirectory(triangle)
add_subdirectory(third)
add_executable(three laws.c)
target_link_libraries(three satellite_mrac triangle_path THIRD)
"""


@functools.cache
def firmware(model: str, law: str) -> Program:
    return program(runtime.load(model, backend="c"), law)


def with_filter() -> Program:
    """Return the law of a craft with a Kalman filter of attitude and gyro bias."""
    craft = Spacecraft("survey", "a craft with a filter", period=0.1)
    craft.add(Hub("hub", mass=40.0, inertia=(2.0, 3.0, 2.5)))
    axes = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    wheels = [craft.add(Wheel(f"wheel_{name}", axis=axis, inertia=0.01)) for name, axis in axes.items()]
    gyro = craft.add(Gyro("gyro", noise=1e-5, walk=1e-7))
    tracker = craft.add(StarTracker("tracker", sigma=(2e-5, 2e-5, 1e-4)))
    craft.add(AttitudeFilter("filter", gyro=gyro, tracker=tracker, every=10))

    def hold(law):
        kp, kd = law.parameter("kp", 2.0, "N m"), law.parameter("kd", 3.0, "N m s")
        (_, *q), rates = law.attitude, law.rates
        return law.torque([-kp * a - kd * w for a, w in zip(q, rates, strict=True)], wheels)

    craft.law("hold", hold, "to inertial axes")
    return program(mehvar.build(craft), "hold")


def closed_loop(subject: Program) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Yield measurement, reference and applied input of a law at a sample, and its answer on this machine."""
    model, law, period = subject.model, subject.law, subject.period
    resolved = subject.resolved
    host = HostLaw(subject, resolved)
    run = runtime.simulate(
        model, law.name, law=host, t_end=(SAMPLES - 1) * period, dt_out=period, hold=period, delay=delay_of(law)
    )
    host = HostLaw(subject, resolved)
    z = start_memory(model, law, resolved, run.x[0], "float")
    measured, reference = (vector.places for vector in law_facts(subject, {})["vectors"][:2])
    for k in range(SAMPLES):
        r = model.functions["reference"](run.t[k], run.parameters.p, run.parameters.s)
        applied = run.u[k - 1] if k else np.zeros(run.u.shape[1])
        seen = run.x[k][: len(model.manifest.seen)]
        u, z = host(*(v.astype("f4").astype("f8") for v in (seen, r, applied)), z)
        yield run.x[k][list(measured)], r[list(reference)], applied, np.concatenate([u, z])


def table(name: str, rows: list[np.ndarray]) -> str:
    lines = ",\n".join("{" + ", ".join(f"{float(v).hex()}f" for v in row.astype("f4")) + "}" for row in rows)
    return f"static const mv_real {name}[SAMPLES][{max(1, len(rows[0]))}] = {{\n{lines}}};\n".replace("{}", "{0}")


Project = tuple[Path, list[list[str]]]


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Project:
    return composed(tmp_path_factory.mktemp("three"), firmware("slosh", "lyapunov-v2"))


def composed(folder: Path, third: Program) -> Project:
    """Return a CMake project with the packages of three laws, and the lines that each sample must print."""
    header, expected = [f"enum {{ SAMPLES = {SAMPLES} }};\n"], []
    subjects = {"satellite": firmware("satellite", "mrac"), "triangle": firmware("triangle", "path"), "third": third}
    for place, subject in subjects.items():
        write_sources(folder / place, package(subject, "cmake"))
        columns = list(zip(*closed_loop(subject), strict=True))
        name = law_name(subject)
        header.insert(0, f'#include "{name}.h"\n')
        header += [
            table(f"{name}_{word}", list(rows))
            for word, rows in zip(("measured", "reference", "applied"), columns, strict=False)
        ]
        expected.append([" ".join(f"{bits:08x}" for bits in row.astype("<f4").view("<u4")) for row in columns[3]])
    (folder / "samples.h").write_text("".join(header))
    name, text = law_name(third), (HERE / "laws.c").read_text()
    (folder / "laws.c").write_text(text.replace("THIRD", name.upper()).replace("third", name))
    (folder / "CMakeLists.txt").write_text(PROJECT.replace("THIRD", name))
    return folder, expected


def built(folder: Path, place: str, compiler: str, flags: str, link: str = "", system: str = "") -> tuple[Path, str]:
    """Return the program of a project, and what its build says."""
    options = [f"-DCMAKE_C_COMPILER={compiler}", f"-DCMAKE_C_FLAGS={flags}", f"-DCMAKE_EXE_LINKER_FLAGS={link}"]
    options += [f"-DCMAKE_SYSTEM_NAME={system}"] if system else []
    options += ["-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY"] if system else []
    said = ""
    for command in (["cmake", "-S", ".", "-B", place, *options], ["cmake", "--build", place]):
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        said = done.stdout
    return folder / place / "three", said


def check_lines(text: str, expected: list[list[str]]) -> None:
    lines = [line.strip() for line in text.partition(".")[0].splitlines()]
    assert len(lines) == 4 * SAMPLES
    for k in range(SAMPLES):
        mrac, path, third, again = lines[4 * k : 4 * k + 4]
        for line, rows in zip((mrac, path, third), expected, strict=True):
            assert line == rows[k], k
        assert again == mrac


@needs("cmake", "arm-none-eabi-gcc", "qemu-system-arm")
@pytest.mark.soak
def test_three_laws_in_a_bare_image_for_a_cortex_m4f(project):
    check_on_a_cortex_m4f(*project)


@needs("cmake", "arm-none-eabi-gcc", "qemu-system-arm", "riscv64-linux-gnu-gcc", "qemu-riscv64-static")
@pytest.mark.soak
def test_two_laws_and_an_estimator_on_two_processors(tmp_path):
    folder, expected = composed(tmp_path, with_filter())
    check_on_a_cortex_m4f(folder, expected)
    image, _ = built(folder, "riscv64", "riscv64-linux-gnu-gcc", "-O2 -static")
    done = subprocess.run(["qemu-riscv64-static", image], capture_output=True, text=True, check=True)
    check_lines(done.stdout, expected)


def check_on_a_cortex_m4f(folder, expected):
    link = f"-nostdlib -nostartfiles -T {HERE / 'laws.ld'}"
    image, said = built(folder, "arm", "arm-none-eabi-gcc", CORTEX, link, "Generic")
    assert said.count("(TOTALS)") == 3, "the build prints sizes"
    undefined = subprocess.run(["arm-none-eabi-nm", "-u", image], capture_output=True, text=True, check=True).stdout
    assert not undefined
    command = ["qemu-system-arm", "-M", "mps2-an386", "-kernel", image, "-display", "none", "-monitor", "none"]
    with subprocess.Popen(
        [*command, "-serial", "stdio"], stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True
    ) as machine:
        text = ""
        while machine.stdout and (letter := machine.stdout.read(1)) not in (".", ""):
            text += letter
        machine.kill()
    check_lines(text + ".", expected)


@needs("cmake")
@pytest.mark.parametrize(
    ("compiler", "emulator"),
    [
        ("gcc", ()),
        pytest.param("riscv64-linux-gnu-gcc", ("qemu-riscv64-static",),
                     marks=needs("riscv64-linux-gnu-gcc", "qemu-riscv64-static")),
    ],
)  # fmt: skip
@pytest.mark.share(2)
def test_three_laws_in_a_process(project, compiler, emulator):
    folder, expected = project
    image, _ = built(folder, compiler, compiler, "-O2 -static")
    text = subprocess.run([*emulator, image], capture_output=True, text=True, check=True).stdout
    check_lines(text, expected)


@pytest.fixture
def mrac(tmp_path: Path) -> Path:
    """Return the sources of a package whose roll has a range."""
    write_sources(tmp_path, package(firmware("satellite", "mrac"), "arduino", ranges={"roll": (-0.5, 0.5)}))
    return tmp_path / "src"


def test_a_block_is_checked_before_use_and_inputs_at_every_step(mrac):
    program = mrac / "block"
    subprocess.run(["gcc", "-O1", "-I.", HERE / "block.c", "satellite_mrac.c", "-o", program], cwd=mrac, check=True)
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "")


@pytest.mark.parametrize(
    "compiler",
    [
        ("gcc", "-O2"),
        *(
            pytest.param((name, *flags), marks=needs(name))
            for name, flags in (("arm-none-eabi-gcc", CORTEX.split()), ("riscv64-linux-gnu-gcc", ["-O2"]))
        ),
    ],
    ids=lambda compiler: compiler[0],
)
def test_a_law_needs_nothing_of_a_library(mrac, compiler):
    """Linked with -nostdlib it has no undefined symbol, and it defines those of its header alone."""
    command = [*compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-I.", "-nostdlib", "-r", "-fno-pic"]
    subprocess.run([*command, "satellite_mrac.c", "-o", "law.o"], cwd=mrac, check=True)
    nm = compiler[0].replace("gcc", "nm")
    listing = subprocess.run([nm, "law.o"], cwd=mrac, capture_output=True, text=True, check=True).stdout
    kinds: dict[str, set[str]] = {}
    for line in listing.splitlines():
        kinds.setdefault(line.split()[-2], set()).add(line.split()[-1])
    assert "U" not in kinds
    assert not kinds.keys() & {"D", "B", "d", "b", "C"}, "no variables but constants"
    functions = {f"satellite_mrac_{name}" for name in ("seal", "check", "init", "set", "step", "memory")}
    assert kinds["T"] == functions


def test_the_example_of_the_header_is_compiled_and_has_eight_lines(mrac):
    header = (mrac / "satellite_mrac.h").read_text()
    example = [line[6:] for line in header[: header.index("*/", 200)].splitlines() if line.startswith(" *     ")]
    assert 8 <= len(example) <= 10
    text = (
        '#include "satellite_mrac.h"\n'
        "static void read_sensors(mv_real *m, mv_real *r) { m[0] = r[0] = 0; }\n"
        "static void report(void) {}\nstatic void drive(const mv_real *u) { (void)u; }\n"
        "void fly(void);\nvoid fly(void)\n{\n" + "\n".join(example) + "\n}\n"
    )
    (mrac / "example.c").write_text(text)
    subprocess.run(["gcc", "-Wall", "-Wextra", "-Werror", "-I.", "-c", "example.c"], cwd=mrac, check=True)


def test_ranges_and_constants_are_refused_by_name(tmp_path):
    line = ("board", "emit", "triangle", "--controller", "path", "--for", "cmake", "--out", str(tmp_path / "law"))
    assert "did you mean rho" in refused(*line, "--range", "rhoo=1:2")
    assert "LEAST:MOST" in refused(*line, "--range", "rho=2")
    assert "LEAST <= MOST" in refused(*line, "--range", "rho=2:1")
    assert "given with --link" in refused(*line, "--inline-parameters")
    assert "left out with --link" in refused(*line, "--link", "--range", "rho=1:2")
    framework = ("board", "emit", "triangle", "--controller", "path", "--for", "cfs", "--out", str(tmp_path / "law"))
    assert "left out with --for cfs" in refused(*framework, "--link")
    assert not (tmp_path / "law").exists()
