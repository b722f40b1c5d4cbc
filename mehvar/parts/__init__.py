# SPDX-License-Identifier: Apache-2.0
"""Parts of a spacecraft: `from mehvar.parts import Spacecraft, Hub, Wheel`."""

from mehvar.models.parts import *  # noqa: F403
from mehvar.models.parts import __all__ as __all__

from .craft import Spacecraft as Spacecraft
