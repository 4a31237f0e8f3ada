# SPDX-License-Identifier: BSD-3-Clause
"""Run by the GUI: paraview --script=pick_rows.py. Selects rows of a contour spectrum, as a
spreadsheet does, and saves states that spectrum_pick.py looks into. From the environment:
PICK_VOLUMES and PICK_OUTPUT, folders.
"""
import os

from paraview import simple

VOLUMES, OUTPUT = os.environ["PICK_VOLUMES"], os.environ["PICK_OUTPUT"]


def select(source, rows):
    identifiers = [number for row in rows for number in (0, row)]
    selection = simple.IDSelectionSource(IDs=identifiers, FieldType="ROW")
    combined = simple.AppendSelections(Input=selection, SelectionNames=["rows"], Expression="rows")
    source.SetSelectionInput(0, combined, 0)


reader = simple.OpenDataFile(os.path.join(VOLUMES, "wave.bvol"))
contour = simple.Isosurface(Input=reader, Isosurfaces=[150])
other = simple.Isosurface(Input=simple.OpenDataFile(os.path.join(VOLUMES, "wave.vti")))
spectrum = simple.ContourSpectrum(Input=reader)
spectrum.UpdatePipeline()
select(spectrum, [100, 101, 102, 103, 300])
simple.SaveState(os.path.join(OUTPUT, "rows.pvsm"))
