# SPDX-License-Identifier: Apache-2.0
"""Web pages that simulate a model: WebAssembly, plots and sliders in one file."""
