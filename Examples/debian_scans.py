# SPDX-License-Identifier: BSD-3-Clause
"""The scans that the examples and tests use, from Debian's packages, as vtkImageData.

head_mri():    T1 head MRI, uint8, 181 x 217 x 181 (package mricron-data: ch2.nii.gz)
macaque_mri(): T1 brain MRI, the mean of 19 macaques, float32, 168 x 206 x 128 (package
               mricron-data: inia19-t1-brain.nii.gz)
cranium_ct():  head CT, int16 Hounsfield units, 256 x 256 x 108 (package invesalius-examples:
               Cranium.inv3, a gzipped tar with a raw matrix and a property list)
"""
import os
import plistlib
import tarfile

from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOImage import vtkNIFTIImageReader
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
import numpy

HEAD_MRI = "/usr/share/mricron/templates/ch2.nii.gz"
MACAQUE_MRI = "/usr/share/mricron/templates/inia19-t1-brain.nii.gz"
CRANIUM_CT = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3"


def read_nifti(path):
    reader = vtkNIFTIImageReader()
    reader.SetFileName(path)
    reader.Update()
    image = vtkImageData()
    image.DeepCopy(reader.GetOutput())
    image.GetPointData().GetScalars().SetName("T1")
    return image


def head_mri():
    return read_nifti(HEAD_MRI)


def macaque_mri():
    return read_nifti(MACAQUE_MRI)


def cranium_ct():
    with tarfile.open(CRANIUM_CT) as archive:
        members = {name.rsplit("/", 1)[-1]: name for name in archive.getnames()}
        description = plistlib.load(archive.extractfile(members["main.plist"]))
        matrix = description["matrix"]
        samples = numpy.frombuffer(
            archive.extractfile(members[matrix["filename"]]).read(), dtype=matrix["dtype"]
        )
    slices, rows, columns = matrix["shape"]
    image = vtkImageData()
    image.SetDimensions(columns, rows, slices)
    image.SetSpacing(description["spacing"])
    scalars = numpy_to_vtk(samples, deep=True)
    scalars.SetName("HU")
    image.GetPointData().SetScalars(scalars)
    return image


def write(image, path):
    """Writes an image as .vti, with inline data, which every ParaView reads."""
    writer = vtkXMLImageDataWriter()
    writer.SetInputData(image)
    writer.SetFileName(path)
    writer.SetDataModeToBinary()
    writer.SetCompressorTypeToZLib()
    if not writer.Write():
        raise RuntimeError(f"{path}: cannot be written")


def write_blocked_volume(image, path, **settings):
    """Writes an image as a blocked volume by ParaView: each rank reads and writes its part."""
    from paraview import simple

    vti = os.path.splitext(path)[0] + ".vti"
    write(image, vti)
    source = simple.XMLImageDataReader(FileName=[vti])
    simple.SaveData(path, proxy=source, **settings)
    simple.Delete(source)
    os.remove(vti)
