# SPDX-License-Identifier: BSD-3-Clause
"""How far area and volume of a contour spectrum are from those of the isosurfaces.

    PYTHONPATH=.../dist-packages python3 spectrum_accuracy.py FILE.vti[:ARRAY] ...

For each file: at some isovalues of the spectrum, spread over the rows that enclose from 1 % to 99 % of the
grid, the surface is extracted and closed at the border of the grid; its area (open) and volume (closed) are
vtkMassProperties'. Then the same half-way to the next row, by the nearest row. Integers of few values have
each value as a row, and no isovalue between changes their triangles' number. Prints the median and the
maximum of the relative differences.
"""
import argparse
import statistics

from scalable_isosurface import vtkContourSpectrum, vtkStabbingContour
from vtkmodules.vtkFiltersCore import vtkMassProperties
from vtkmodules.vtkIOXML import vtkXMLImageDataReader


def read_image(path):
    reader = vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def read_rows(image, array):
    spectrum = vtkContourSpectrum()
    spectrum.SetInputData(image)
    spectrum.SetInputArrayToProcess(0, 0, 0, 0, array)
    spectrum.Update()
    table = spectrum.GetOutput()
    columns = [table.GetColumnByName(name) for name in ("Isovalue", "Area", "Volume")]
    return [
        tuple(column.GetValue(row) for column in columns) for row in range(table.GetNumberOfRows())
    ]


def measure(image, array, isovalue):
    contour = vtkStabbingContour()
    contour.SetInputData(image)
    contour.SetInputArrayToProcess(0, 0, 0, 0, array)
    contour.SetValue(0, isovalue)
    contour.ComputeNormalsOff()
    properties = vtkMassProperties()
    properties.SetInputConnection(contour.GetOutputPort())
    area = properties.GetSurfaceArea()
    contour.CloseBoundaryOn()
    return area, properties.GetVolume()


def choose_rows(rows, whole, count):
    inner = [
        n
        for n in range(len(rows) - 1)
        if 0.01 * whole < rows[n][2] < 0.99 * whole and rows[n][1] > 0
    ]
    step = max(1, len(inner) // count)
    return inner[step // 2 :: step]


def compare(image, array, count):
    rows = read_rows(image, array)
    dimensions, spacing = image.GetDimensions(), image.GetSpacing()
    whole = 1.0
    for size, width in zip(dimensions, spacing):
        whole *= (size - 1) * width
    differences = {"area": [], "volume": [], "area between": [], "volume between": []}
    for number in choose_rows(rows, whole, count):
        isovalue, area, volume = rows[number]
        true_area, true_volume = measure(image, array, isovalue)
        differences["area"].append(abs(area / true_area - 1))
        differences["volume"].append(abs(volume / true_volume - 1))
        # A little nearer to this row than to the next one.
        between = isovalue + 0.499 * (rows[number + 1][0] - isovalue)
        true_area, true_volume = measure(image, array, between)
        differences["area between"].append(abs(area / true_area - 1))
        differences["volume between"].append(abs(volume / true_volume - 1))
    return differences


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("files", nargs="+", metavar="FILE[:ARRAY]")
    parser.add_argument("--isovalues", type=int, default=12, help="of each file")
    arguments = parser.parse_args()
    print(f"{'':32}{'row: area':>18}{'volume':>18}{'between: area':>18}{'volume':>18}")
    for file in arguments.files:
        path, _, array = file.partition(":")
        image = read_image(path)
        array = array or image.GetPointData().GetArrayName(0)
        differences = compare(image, array, arguments.isovalues)
        cells = "".join(
            f"{100 * statistics.median(values):8.2f} {100 * max(values):6.2f} %"
            for values in differences.values()
        )
        print(f"{path.rsplit('/', 1)[-1][:24]:24}{array[:8]:8}{cells}", flush=True)


main()
