# SPDX-License-Identifier: BSD-3-Clause
"""Loads a state and draws it: pvbatch show_state.py PLUGIN STATE; prints the cells of what is in it."""
import sys

from paraview import simple

simple.LoadPlugin(sys.argv[1], remote=True, ns=vars(simple))
simple.LoadState(sys.argv[2])
simple.Render(simple.GetActiveViewOrCreate("RenderView"))
cells = {name[0]: source.GetDataInformation().GetNumberOfCells() for name, source in simple.GetSources().items()}
print(sorted(cells.items()))
