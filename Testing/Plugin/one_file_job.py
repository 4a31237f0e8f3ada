# SPDX-License-Identifier: BSD-3-Clause
"""What a plugin makes of volumes, in pvbatch on any number of ranks: one line of JSON for each job, with the digests of the
arrays of each rank.

    one_file_job.py PLUGIN VOLUMES OUTPUT

one_file.py compares the lines of the plugin in C++ with those of the one in a file of Python.
"""
import glob
import json
import os
import shutil
import sys

from paraview import servermanager, simple
from vtkmodules.vtkCommonCore import vtkVersion

PLUGIN, VOLUMES, OUTPUT = sys.argv[1:4]
HERE = os.path.dirname(os.path.abspath(__file__))
#: Run on each rank.
DIGEST = """
import sys
sys.path.append({here!r})
import digests
digests.write(inputs[0].VTKObject, {stem!r}, self)
"""


#: A rectilinear grid of an image.
RECTILINEAR = """
from vtkmodules.vtkCommonCore import vtkDoubleArray
image, grid = self.GetInputDataObject(0, 0), self.GetOutputDataObject(0)
grid.SetExtent(image.GetExtent())
for axis, put in enumerate((grid.SetXCoordinates, grid.SetYCoordinates, grid.SetZCoordinates)):
    line = vtkDoubleArray()
    for number in range(image.GetExtent()[2 * axis], image.GetExtent()[2 * axis + 1] + 1):
        line.InsertNextValue(number + 0.01 * number * abs(number))
    put(line)
grid.GetPointData().ShallowCopy(image.GetPointData())
grid.GetCellData().ShallowCopy(image.GetCellData())
"""

#: A tree with an image of which cells and points are hidden.
HOLES = """
from vtkmodules.vtkCommonDataModel import vtkUniformGrid
image, tree = self.GetInputDataObject(0, 0), self.GetOutputDataObject(0)
grid = vtkUniformGrid()
grid.ShallowCopy(image)
for cell in range(100, grid.GetNumberOfCells(), 7):
    grid.BlankCell(cell)
for point in range(200, grid.GetNumberOfPoints(), 97):
    grid.BlankPoint(point)
tree.SetBlock(1, grid)
"""


def find_volume(name):
    return os.path.join(VOLUMES, name)


def write_volume(name):
    """A blocked volume of a file of VTK."""
    path = os.path.join(OUTPUT, f"{name}.bvol")
    simple.SaveData(path, proxy=simple.XMLImageDataReader(FileName=[find_volume(f"{name}.vti")]))
    return simple.OpenDataFile(path)


def digest(source, port=0, time=None):
    """The digests of an output of a source, a dictionary for each rank."""
    stem = os.path.join(OUTPUT, "digest")
    for old in glob.glob(stem + "*"):
        os.remove(old)
    passed = simple.ProgrammableFilter(Input=simple.OutputPort(source, port), OutputDataSetType="vtkTable")
    passed.Script = DIGEST.format(here=HERE, stem=stem)
    passed.UpdatePipeline(*([] if time is None else [time]))
    simple.Delete(passed)
    made = []
    for path in sorted(glob.glob(stem + "*")):
        with open(path) as file:
            made.append(json.load(file))
    return made


def program(source, kind, script):
    return simple.ProgrammableFilter(Input=source, OutputDataSetType=kind, Script=script)


def report(job, **found):
    print(json.dumps({"job": job, **found}, sort_keys=True), flush=True)


def list_proxies():
    """All that can be made: pairs of a group and a name."""
    manager = servermanager.ActiveConnection.Session.GetProxyDefinitionManager()
    found = set()
    for group in ("sources", "filters", "writers"):
        iterator = manager.NewSingleGroupIterator(group)
        iterator.InitTraversal()
        while not iterator.IsDoneWithTraversal():
            found.add((group, iterator.GetProxyName()))
            iterator.GoToNextItem()
    return found


def describe_properties(group, name):
    """Type, label, place in panels, defaults and documentation of each property."""
    iterator = servermanager.ProxyManager().GetPrototypeProxy(group, name).NewPropertyIterator()
    iterator.Begin()
    found = {}
    while not iterator.IsAtEnd():
        one = iterator.GetProperty()
        text = one.GetDocumentation().GetDescription() if one.GetDocumentation() else ""
        count = one.GetNumberOfElements() if hasattr(one, "GetElement") else 0
        defaults = [str(one.GetElement(number)) for number in range(count)]
        found[iterator.GetKey()] = [one.GetClassName(), one.GetXMLLabel(), one.GetInformationOnly(), one.GetPanelVisibility(),
                                    defaults, " ".join((text or "").split())]
        iterator.Next()
    if name in ("Isosurface", "StabbingContour"):
        found.pop("Proposal", None)  # the plugin in Python has it for the domain of isovalues
    return found


def make_surfaces(wave, series, vectors):
    """Isosurface with each of its properties."""
    surface = simple.Isosurface(Input=wave)
    report("the isovalue that is proposed", isovalues=list(surface.Isosurfaces), unit=str(surface.Unit))
    report("default", ranks=digest(surface))
    options = {
        "several isovalues": {"Isosurfaces": [150.0, 100.0, 180.5]},
        "double points": {"OutputPointsPrecision": "Double"},
        "no normals, no scalars": {"ComputeNormals": 0, "ComputeScalars": 0, "InterpolatedArrays": ["RTData"]},
        "polygons": {"GenerateTriangles": 0},
        "without degenerate triangles": {"DropDegenerateTriangles": 1, "Isosurfaces": [150.0]},
        "closed": {"CloseBoundary": 1},
        "closed, below": {"CloseBoundary": 1, "Inside": "Below"},
        "region": {"UseRegion": 1, "RegionPosition": [-25, -20, -20], "RegionLength": [20, 29, 30]},
        "islands": {"MinimumIslandSize": 50, "MaximumIslands": 3, "ComputeIslandIds": 1},
        "island at a point": {"UseIslandPoint": 1, "IslandPoint": [9, 9, 9], "IslandSize": "Area"},
        "frustum": {"FrustumPlanes": [1, 0, 0, 0, -1, 0, 0, 30, 0, 1, 0, 20, 0, -1, 0, 20, 0, 0, 1, 20, 0, 0, -1, 20]},
        "coarser": {"Level": 1},
        "few triangles": {"MaximumTriangles": 1000},
        "holes": {"SkipNotANumber": 1},
        "nothing there": {"Isosurfaces": [1e6]},
    }
    for name, given in options.items():
        surface = simple.Isosurface(Input=wave, Isosurfaces=[157.25])
        surface.Set(**given) if hasattr(surface, "Set") else [setattr(surface, *one) for one in given.items()]
        found = digest(surface)
        surface.UpdatePropertyInformation()
        report(name, ranks=found, islands=str(surface.IslandSummary), levels=list(surface.LevelRange))
    surface = simple.Isosurface(Input=series, Isosurfaces=[170.0])
    report("second step", ranks=digest(surface, time=1.0))
    report("times", times=list(series.TimestepValues))
    surface = simple.Isosurface(Input=vectors, ContourBy=["POINTS", "Gradient"], Component=3, Isosurfaces=[1.5])
    surface.InterpolatedArrays = ["RTData"]
    report("magnitude", ranks=digest(surface))


def make_samples(wave):
    """Volume Slice, Region, Probe, Contour Spectrum."""
    for name, given in {
        "slice along axes": {"Origin": [0, 0, 1.4], "Normal": [0, 0, 1]},
        "oblique slice": {"Origin": [0, 0, 0], "Normal": [1, 2, 3]},
        "nearest samples": {"Origin": [0, 0, 0], "Normal": [1, 2, 3], "Interpolation": "Nearest"},
        "small slice": {"Origin": [0, 0, 0], "Normal": [0, 1, 0], "MaximumPoints": 0.01},
    }.items():
        cut = simple.VolumeSlice(Input=wave)
        cut.Isolines = [150.0]
        for one in given.items():
            setattr(cut, *one)
        report(name, ranks=digest(cut), isolines=digest(cut, 1))
    region = simple.VolumeRegion(Input=wave, Position=[-3.5, -4, 0], Length=[6, 7, 5.5])
    report("region of samples", ranks=digest(region))
    for name, points in {"sphere": simple.Sphere(Radius=14, PhiResolution=30), "image": simple.Wavelet()}.items():
        report(f"values at the points of a {name}", ranks=digest(simple.VolumeProbe(Input=wave, Source=points)))
    spectrum = simple.ContourSpectrum(Input=wave)
    report("spectrum", ranks=digest(spectrum))


def contour_images(wave):
    """Data in memory: what the ranks have of images, trees of them, and of rectilinear grids."""
    wavelet = simple.Wavelet(WholeExtent=[-12, 14, -9, 9, -7, 8])
    vectors = simple.XMLImageDataReader(FileName=[find_volume("vectors.vti")])
    cells = simple.PointDatatoCellData(Input=wavelet)
    refined = []
    if servermanager.ActiveConnection.GetNumberOfDataPartitions() == 1:  # else ParaView's source ends the process
        fractal = simple.HierarchicalFractal(MaximumLevel=2, TwoDimensional=0)
        refined = [("refined images", simple.CellDatatoPointData(Input=fractal),
                    {"ContourBy": ["POINTS", "Fractal Volume Fraction"], "Isosurfaces": [0.5]})]
    for name, source, given in (
        ("an image", wavelet, {}),
        ("an image, islands", wavelet, {"MaximumIslands": 1, "ComputeIslandIds": 1}),
        ("an image, a region", wavelet, {"UseRegion": 1, "RegionPosition": [-5, -5, -5], "RegionLength": [9, 6, 7]}),
        ("an image, closed", wavelet, {"CloseBoundary": 1, "ComputeNormals": 0}),
        ("an image, polygons", wavelet, {"GenerateTriangles": 0}),
        ("an image, itself interpolated", wavelet, {"ComputeScalars": 0, "InterpolatedArrays": ["RTData"]}),
        ("a magnitude", vectors, {"ContourBy": ["POINTS", "Gradient"], "Component": 3, "Isosurfaces": [1.5],
                                  "InterpolatedArrays": ["RTData", "Gradient"]}),
        ("cells", cells, {"ContourBy": ["CELLS", "RTData"]}),
        ("cells, interpolated", simple.Elevation(Input=cells, LowPoint=[-12, -9, -7], HighPoint=[14, 9, 8]),
         {"ContourBy": ["POINTS", "Elevation"], "Isosurfaces": [0.5], "InterpolatedArrays": ["RTData"]}),
        ("a tree", simple.XMLMultiBlockDataReader(FileName=[find_volume("pair.vtm")]), {}),
        ("two images", simple.GroupDatasets(Input=[wavelet, simple.Wavelet(WholeExtent=[20, 40, -9, 9, -7, 8])]), {}),
        ("an ensemble", simple.GroupDatasets(Input=[wavelet, simple.Calculator(Input=wavelet, Function="RTData + 20",
                                                                              ResultArrayName="RTData")]), {}),
        ("rectilinear", program(wavelet, "vtkRectilinearGrid", RECTILINEAR), {}),
        ("images with holes", program(wavelet, "vtkMultiblockDataSet", HOLES), {}),
        *refined,
        ("behind a calculator", simple.Calculator(Input=wave, Function="RTData * 2", ResultArrayName="double"),
         {"ContourBy": ["POINTS", "double"], "Isosurfaces": [310.0]}),
    ):
        surface = simple.Isosurface(Input=source, Isosurfaces=[157.25])
        for one in {"ContourBy": ["POINTS", "RTData"], **given}.items():
            setattr(surface, *one)
        report(f"{name} in memory", ranks=digest(surface))


def write_files(wave):
    """Both writers, and what comes back."""
    surface = simple.Isosurface(Input=wave, Isosurfaces=[150.0, 157.0])
    surface.UpdatePipeline()
    path = os.path.join(OUTPUT, "surface.eix")
    for name, given in {
        "eix": {},
        "eix, bounded": {"Mode": "Bounded", "Profile": "Working", "WriteNormals": 1},
        "eix, quantized": {"Mode": "Quantized", "QuantizationBits": 9},
    }.items():
        simple.SaveData(path, proxy=surface, **given)
        reader = simple.OpenDataFile(path)
        reader.UpdatePipeline()
        report(name, ranks=digest(reader), size=os.path.getsize(path))
        reader.UseRegion, reader.RegionPosition, reader.RegionLength = 1, [0, 0, 0], [4, 4, 4]
        report(name + ", a region", ranks=digest(reader))
        reader.UseRegion, reader.Preview = 0, 1
        report(name + ", preview", ranks=digest(reader))
    wavelet = simple.Wavelet(WholeExtent=[-12, 12, -9, 9, -7, 7])
    for name, source in {"an image": wavelet, "a volume": wave}.items():
        path = os.path.join(OUTPUT, "written.bvol")
        simple.SaveData(path, proxy=source, BlockSize="16", NumberOfStores=2)
        written = simple.OpenDataFile(path)
        report(f"{name} written", ranks=digest(simple.Isosurface(Input=written, Isosurfaces=[150.0])))


def write_anew():
    """A volume that is replaced while its reader is there."""
    reader = write_volume("ct")
    reader.UpdatePipeline()
    image = simple.XMLImageDataReader(FileName=[find_volume("vectors.vti")])
    simple.SaveData(os.path.join(OUTPUT, "ct.bvol"), proxy=image)
    reader.MemoryLimit = 100
    report("written anew", ranks=digest(simple.Isosurface(Input=reader, ContourBy=["POINTS", "RTData"], Isosurfaces=[150.0])))


def make_scans():
    """Where Examples/main_job.py has written them: a head MRI and a CT."""
    for path in sorted(glob.glob(find_volume("scans/*.bvol"))):
        report(os.path.basename(path), ranks=digest(simple.Isosurface(Input=simple.OpenDataFile(path))))


def index_files():
    """A file of another format, which is indexed first."""
    folder = os.path.join(OUTPUT, "foreign")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for name in ("wave.mhd", "wave.raw"):
        shutil.copy(find_volume(name), folder)
    reader = simple.OpenDataFile(os.path.join(folder, "wave.mhd"))
    report("reader", name=reader.GetXMLName())
    report("in place", ranks=digest(simple.Isosurface(Input=reader, Isosurfaces=[150.0])))
    report("index", files=sorted(os.listdir(folder)))
    reader = simple.OpenDataFile(os.path.join(folder, "wave.mhd"))
    reader.Spacing, reader.Origin, reader.LengthUnit = [0.5, 0.5, 2.0], [1.0, 2.0, 3.0], "um"
    report("placed", ranks=digest(simple.Isosurface(Input=reader, Isosurfaces=[150.0])))


def read_address():
    """A file on the server that one_file.py has started."""
    address = os.environ["ISOSURFACE_TEST_ADDRESS"] + "/wave.mhd"
    for job, region in (("address", [0, -1, 0, -1, 0, -1]), ("region of an address", [-5, 5, 0, 9, -4, 3])):
        reader = simple.VolumefromanAddress(Address=address, IndexFolder=OUTPUT, Region=region)
        report(job, ranks=digest(simple.Isosurface(Input=reader, Isosurfaces=[150.0])))
        plane = simple.VolumeSlice(Input=reader)
        report(f"slice of {job}", ranks=digest(plane), budget=reader.FetchBudget)


def main():
    before = list_proxies()
    simple.LoadPlugin(PLUGIN, remote=True, ns=vars(simple))
    if servermanager.ActiveConnection.GetNumberOfDataPartitions() == 1:  # several may have loaded the plugin before
        for group, name in sorted(list_proxies() - before):
            if name != "DistributeIsosurface":  # of the plugin in C++ alone
                report(f"properties of {name} ({group})", found=describe_properties(group, name))
    report("VTK", version=100 * vtkVersion.GetVTKMajorVersion() + vtkVersion.GetVTKMinorVersion())
    wave = simple.OpenDataFile(find_volume("wave.bvol"))
    report("arrays", arrays=list(wave.PointArrayStatus))
    vectors, ct = (write_volume(name) for name in ("vectors", "ct"))
    report("the isovalue that is proposed for a CT", isovalues=list(simple.Isosurface(Input=ct).Isosurfaces))
    make_surfaces(wave, simple.OpenDataFile(find_volume("series.bvol")), vectors)
    make_samples(wave)
    contour_images(wave)
    write_files(wave)
    write_anew()
    make_scans()
    index_files()
    read_address()


main()
