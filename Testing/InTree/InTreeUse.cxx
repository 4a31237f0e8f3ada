// SPDX-License-Identifier: BSD-3-Clause
// Uses a class of each module that another project built in its own tree.
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
  writer->SetFileName("in-tree.bvol");
  if (!writer->Write())
  {
    return 1;
  }
  vtkNew<vtkBlockedVolumeReader> reader;
  reader->SetFileName("in-tree.bvol");
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputConnection(reader->GetOutputPort());
  contour->SetValue(0, 0.5);
  contour->Update();
  std::printf("%d triangles\n", static_cast<int>(contour->GetOutput()->GetNumberOfPolys()));
  return contour->GetOutput()->GetNumberOfPolys() == 8 ? 0 : 1;
}
