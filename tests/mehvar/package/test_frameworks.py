# SPDX-License-Identifier: Apache-2.0
"""Components for frameworks, each compiled and run once with what it calls of its framework, written for the tests.

The app was also built with cFE 7, the component with F Prime 3.5 and its fpp: neither is installed where the tests run.
"""

from __future__ import annotations

import re
import subprocess
from importlib.metadata import version
from pathlib import Path

import pytest

from mehvar.package.files import package
from mehvar.runtime.board.image.build import program
from mehvar.runtime.compiling.compiler import write_sources
from tests.runtime.board.conftest import load
from tests.tools import needs

HERE = Path(__file__).parent


@pytest.fixture
def emitted(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    write_sources(tmp_path, package(program(load("satellite"), "mrac"), request.param))
    return tmp_path


@pytest.mark.parametrize("emitted", ["cfs"], indirect=True)
def test_the_app_of_cfs(emitted):
    units = ["fsw/satellite_mrac_app.c", "src/satellite_mrac.c", HERE / "cfs" / "services.c"]
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{HERE / 'cfs'}", "-Ifsw", "-Isrc"]
    subprocess.run(["gcc", *flags, *units, "-o", "app"], cwd=emitted, check=True)
    subprocess.run(["gcc", *flags, "-c", "fsw/satellite_mrac_tbl.c", "-o", "table.o"], cwd=emitted, check=True)
    done = subprocess.run([emitted / "app"], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        "event 1 2 SATELLITE_MRAC: started",
        "output 1 flags 0 same bits",
        "output 2 flags 0 same bits",
        "event 4 3 SATELLITE_MRAC: table refused, forgetting (9)",
        "load -1",
        f"event 2 2 SATELLITE_MRAC: mehvar {version('mehvar')}",
        "load 0",
        "output 3 flags 0 same bits",
        "event 5 3 SATELLITE_MRAC: flags 6",
        "output 4 flags 6 same bits",
        "event 6 3 SATELLITE_MRAC: no command 9",
        "event 6 3 SATELLITE_MRAC: message 0x1891 of 3 bytes",
        "event 3 2 SATELLITE_MRAC: memory forgotten",
        "exit 1",
    ]


def component_base(fpp: str) -> str:
    """Return the part of F Prime's generated code that the component here calls."""
    arrays = re.findall(r"array (\w+) = \[(\d+)\] F32", fpp)
    parameters = re.findall(r"param (\w+): F32 default (\S+)", fpp)
    channels = re.findall(r"telemetry (\w+): (F32|U32)", fpp)
    (name,) = re.findall(r"passive component (\w+)", fpp)
    (port,) = re.findall(rf"port {name}Step\((.*?)\)", fpp, re.DOTALL)
    arguments = ", ".join(
        f"{'' if reference else 'const '}{kind} &{argument}"
        for reference, argument, kind in re.findall(r"^\s+(ref )?(\w+): (\w+)$", port, re.MULTILINE)
    )
    words = ", ".join(word for _, word, _ in re.findall(r"^\s+(ref )?(\w+): (\w+)$", port, re.MULTILINE))
    lines = [
        "#include <array>\n#include <cstdint>\n#include <cstdio>",
        "using F32 = float; using U32 = uint32_t; using I32 = int32_t;",
        "using FwIndexType = int16_t; using FwOpcodeType = U32; using FwPrmIdType = U32;",
        "namespace Fw { struct ParamValid {}; struct CmdResponse { enum T { OK }; }; }",
        "namespace Mehvar {",
        *(f"using {array} = std::array<F32, {size}>;" for array, size in arrays),
        f"class {name}ComponentBase {{",
        "  public:",
        f"    explicit {name}ComponentBase(const char *) {{}}",
        f"    virtual ~{name}ComponentBase() = default;",
        f"    void step({arguments}) {{ lock(); this->step_handler(0, {words}); unLock(); }}",
        "    void reset() { lock(); this->RESET_cmdHandler(0, 0); unLock(); }",
        "    void set(F32 &place, F32 value) { place = value; this->parameterUpdated(0); }",
        *(f"    F32 value_{parameter} = {float(value)!r}f;" for parameter, value in parameters),
        "  protected:",
        f"    virtual void step_handler(FwIndexType, {arguments}) = 0;",
        "    virtual void RESET_cmdHandler(FwOpcodeType, U32) = 0;",
        "    virtual void parametersLoaded() {}",
        "    bool locked = false;",
        '    void lock() { if (locked) std::printf("deadlock\\n"); locked = true; }',
        "    void unLock() { locked = false; }",
        "    virtual void parameterUpdated(FwPrmIdType) {}",
        '    void cmdResponse_out(FwOpcodeType, U32, Fw::CmdResponse::T) { std::printf("reset\\n"); }',
        '    void log_WARNING_HI_FLAGS(U32 flags) { std::printf("flags %u\\n", (unsigned)flags); }',
        '    void log_WARNING_HI_PARAMETER_REFUSED(I32 verdict) { std::printf("refused %d\\n", (int)verdict); }',
        *(
            f"    F32 paramGet_{parameter}(Fw::ParamValid &) {{ return value_{parameter}; }}"
            for parameter, _ in parameters
        ),
        *(f"    void tlmWrite_{channel}({kind}) {{}}" for channel, kind in channels),
        "};",
        "}",
    ]
    return "\n".join(lines) + "\n"


@needs("g++")
@pytest.mark.parametrize("emitted", ["fprime"], indirect=True)
def test_the_component_of_f_prime(emitted):
    base = component_base((emitted / "SatelliteMrac.fpp").read_text())
    (emitted / "SatelliteMracComponentAc.hpp").write_text(base)
    subprocess.run(["gcc", "-std=c99", "-Isrc", "-c", "src/satellite_mrac.c", "-o", "law.o"], cwd=emitted, check=True)
    command = ["g++", "-std=c++14", "-Wall", "-Wextra", "-Werror", "-I.", "-Isrc", "SatelliteMrac.cpp", "law.o"]
    subprocess.run([*command, HERE / "fprime" / "main.cpp", "-o", "component"], cwd=emitted, check=True)
    done = subprocess.run([emitted / "component"], capture_output=True, text=True, check=True)
    refused = "refused 9"  # forgetting is the ninth parameter of the table
    assert done.stdout.splitlines() == ["same bits", refused, "same bits", "same bits", "reset", "same bits"]
