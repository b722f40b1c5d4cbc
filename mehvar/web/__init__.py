# SPDX-License-Identifier: Apache-2.0
"""A model as a page that runs: its C as WebAssembly, its runs, plots and sliders in one file."""
