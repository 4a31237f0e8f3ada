// SPDX-License-Identifier: BSD-3-Clause
// WriteToolInputs <folder>: a volume in files of several formats, and beside each the blocked
// volume that vtkBlockedVolumeWriter makes of what VTK's own reader gives: NAME.bvol of NAME.
#include "vtkBlockedVolumeWriter.h"

#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkImageData.h"
#include "vtkMetaImageReader.h"
#include "vtkMetaImageWriter.h"
#include "vtkNIFTIImageReader.h"
#include "vtkNIFTIImageWriter.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkRectilinearGrid.h"
#include "vtkRectilinearGridReader.h"
#include "vtkRectilinearGridWriter.h"
#include "vtkShortArray.h"
#include "vtkStructuredPointsReader.h"
#include "vtkStructuredPointsWriter.h"
#include "vtkTIFFReader.h"
#include "vtkTIFFWriter.h"
#include "vtkUnsignedShortArray.h"
#include "vtkXMLImageDataReader.h"
#include "vtkXMLImageDataWriter.h"
#include "vtkXMLRectilinearGridReader.h"
#include "vtkXMLRectilinearGridWriter.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

namespace
{

/// Waves; not the same on any axis.
template <typename Array>
void AddArray(vtkImageData* image, const char* name, double height)
{
  int size[3];
  image->GetDimensions(size);
  vtkNew<Array> array;
  array->SetName(name);
  array->SetNumberOfValues(image->GetNumberOfPoints());
  vtkIdType number = 0;
  for (int k = 0; k < size[2]; ++k)
  {
    for (int j = 0; j < size[1]; ++j)
    {
      for (int i = 0; i < size[0]; ++i)
      {
        array->SetValue(number++,
          static_cast<typename Array::ValueType>(
            height * (2 + std::sin(0.31 * i + 0.1 * k) + std::cos(0.17 * j) * std::sin(0.2 * k))));
      }
    }
  }
  image->GetPointData()->AddArray(array);
  if (!image->GetPointData()->GetScalars())
  {
    image->GetPointData()->SetActiveScalars(name);
  }
}

/// "flow": three components, of "pressure".
void AddVectors(vtkImageData* image)
{
  vtkDataArray* pressure = image->GetPointData()->GetArray("pressure");
  vtkNew<vtkFloatArray> flow;
  flow->SetName("flow");
  flow->SetNumberOfComponents(3);
  flow->SetNumberOfTuples(image->GetNumberOfPoints());
  for (vtkIdType vertex = 0; vertex < image->GetNumberOfPoints(); ++vertex)
  {
    const double value = pressure->GetTuple1(vertex);
    flow->SetTuple3(vertex, value, 4 - value, value * value / 8);
  }
  image->GetPointData()->AddArray(flow);
}

template <typename Reader>
bool WriteBlocked(const std::string& path)
{
  vtkNew<Reader> reader;
  reader->SetFileName(path.c_str());
  vtkNew<vtkBlockedVolumeWriter> writer;
  writer->SetInputConnection(reader->GetOutputPort());
  writer->SetFileName((path + ".bvol").c_str());
  writer->SetNumberOfStores(3);
  writer->SetController(nullptr);
  return writer->Write() == 1;
}

/// A rectilinear grid with the arrays of an image, in files of two formats.
bool WriteRectilinear(vtkImageData* image, const std::string& folder)
{
  vtkNew<vtkRectilinearGrid> grid;
  grid->SetExtent(image->GetExtent());
  grid->GetPointData()->ShallowCopy(image->GetPointData());
  vtkNew<vtkDoubleArray> lines[3];
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int n = 0; n < image->GetDimensions()[axis]; ++n)
    {
      lines[axis]->InsertNextValue(0.1 * n * n - axis);
    }
  }
  grid->SetXCoordinates(lines[0]);
  grid->SetYCoordinates(lines[1]);
  grid->SetZCoordinates(lines[2]);
  vtkNew<vtkXMLRectilinearGridWriter> xml;
  xml->SetDataModeToBinary();
  xml->SetInputData(grid);
  xml->SetFileName((folder + "/a.vtr").c_str());
  xml->Write();
  vtkNew<vtkRectilinearGridWriter> legacy;
  legacy->SetInputData(grid);
  legacy->SetFileTypeToBinary();
  legacy->SetFileName((folder + "/lines.vtk").c_str());
  legacy->Write();
  return WriteBlocked<vtkXMLRectilinearGridReader>(folder + "/a.vtr") &&
    WriteBlocked<vtkRectilinearGridReader>(folder + "/lines.vtk");
}

bool WriteAll(const std::string& folder)
{
  vtkNew<vtkImageData> image;
  image->SetDimensions(70, 67, 150);
  image->SetSpacing(0.5, 0.75, 2);
  image->SetOrigin(-3, 7, 1.5);
  AddArray<vtkShortArray>(image, "density", 900);
  vtkNew<vtkMetaImageWriter> meta;
  meta->SetInputData(image);
  meta->SetFileName((folder + "/a.mhd").c_str());
  meta->SetRAWFileName((folder + "/a.raw").c_str());
  meta->SetCompression(false);
  meta->Write();
  vtkNew<vtkNIFTIImageWriter> nifti;
  nifti->SetInputData(image);
  nifti->SetFileName((folder + "/a.nii.gz").c_str());
  nifti->Write();

  vtkNew<vtkImageData> counts;
  counts->CopyStructure(image);
  AddArray<vtkUnsignedShortArray>(counts, "counts", 700);
  vtkNew<vtkTIFFWriter> tiff;
  tiff->SetInputData(counts);
  tiff->SetFileName((folder + "/a.tif").c_str());
  tiff->Write();

  AddArray<vtkFloatArray>(image, "height", 0.01);
  vtkNew<vtkStructuredPointsWriter> legacy;
  legacy->SetInputData(image);
  legacy->SetFileTypeToBinary();
  legacy->SetFileName((folder + "/a.vtk").c_str());
  legacy->Write();
  vtkNew<vtkXMLImageDataWriter> xml;
  // VTK 9.2 cannot read its own appended data with expat 2.5.0-1+deb12u5.
  xml->SetDataModeToBinary();
  xml->SetInputData(image);
  xml->SetFileName((folder + "/a.vti").c_str());
  xml->Write();
  // Tuples, and cells, which are not written.
  vtkNew<vtkImageData> flow;
  flow->CopyStructure(image);
  AddArray<vtkFloatArray>(flow, "pressure", 3);
  AddVectors(flow);
  xml->SetInputData(flow);
  xml->SetFileName((folder + "/flow.vti").c_str());
  xml->Write();
  vtkNew<vtkFloatArray> cells;
  cells->SetName("cells");
  cells->SetNumberOfValues(flow->GetNumberOfCells());
  cells->FillValue(1);
  flow->GetCellData()->AddArray(cells);
  xml->SetFileName((folder + "/flow_and_cells.vti").c_str());
  xml->Write();
  flow->GetPointData()->Initialize();
  xml->SetFileName((folder + "/cells.vti").c_str());
  xml->Write();
  xml->SetInputData(image);
  const bool isRectilinearWritten = WriteRectilinear(image, folder);
  // One array, for the choice of arrays.
  image->GetPointData()->RemoveArray("density");
  image->GetPointData()->SetActiveScalars("height");
  xml->SetFileName((folder + "/height.vti").c_str());
  xml->Write();
  return isRectilinearWritten && WriteBlocked<vtkMetaImageReader>(folder + "/a.mhd") &&
    WriteBlocked<vtkNIFTIImageReader>(folder + "/a.nii.gz") &&
    WriteBlocked<vtkTIFFReader>(folder + "/a.tif") &&
    WriteBlocked<vtkStructuredPointsReader>(folder + "/a.vtk") &&
    WriteBlocked<vtkXMLImageDataReader>(folder + "/a.vti") &&
    WriteBlocked<vtkXMLImageDataReader>(folder + "/flow.vti") &&
    WriteBlocked<vtkXMLImageDataReader>(folder + "/height.vti");
}

} // namespace

int main(int argc, char* argv[])
{
  if (argc != 2)
  {
    std::fprintf(stderr, "Usage: %s <folder>\n", argv[0]);
    return 2;
  }
  std::filesystem::remove_all(argv[1]);
  std::filesystem::create_directories(argv[1]);
  return WriteAll(argv[1]) ? 0 : 1;
}
