// SPDX-License-Identifier: BSD-3-Clause
// Uses the VTK classes as another project does, which built the modules in its own tree or found them
// installed: a surface of eight triangles around a vertex.
#include "vtkBlockedVolumeReader.h"
#include "vtkBlockedVolumeWriter.h"
#include "vtkImageData.h"
#include "vtkNew.h"
#include "vtkPolyData.h"
#include "vtkStabbingContour.h"

#include <cstdio>

int main()
{
  vtkNew<vtkImageData> image;
  image->SetDimensions(3, 3, 3);
  image->AllocateScalars(VTK_FLOAT, 1);
  for (int index = 0; index < 27; ++index)
  {
    static_cast<float*>(image->GetScalarPointer())[index] = index == 13 ? 1.0F : 0.0F;
  }
  vtkNew<vtkBlockedVolumeWriter> writer;
  writer->SetInputData(image);
  writer->SetFileName("eight.bvol");
  if (!writer->Write())
  {
    return 1;
  }
  vtkNew<vtkBlockedVolumeReader> reader;
  reader->SetFileName("eight.bvol");
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputConnection(reader->GetOutputPort());
  contour->SetValue(0, 0.5);
  contour->Update();
  std::printf("%d triangles\n", static_cast<int>(contour->GetOutput()->GetNumberOfPolys()));
  return contour->GetOutput()->GetNumberOfPolys() == 8 ? 0 : 1;
}
