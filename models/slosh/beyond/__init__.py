# SPDX-License-Identifier: Apache-2.0
"""Effects that the paper leaves out, as one structure: craft = beyond.

Tanks that drain and may stand anywhere in the hull, an engine that lags and has limits, the gradient of gravity, and a
regulator that estimates the fuel's motion. With the parameters' defaults and gimbals at their command it is the paper's
spacecraft with bobs on ball joints.
"""
