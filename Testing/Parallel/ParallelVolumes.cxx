// SPDX-License-Identifier: BSD-3-Clause
#include "ParallelVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkMultiProcessController.h"
#include "vtkStabbingContour.h"

namespace isosurface
{

SharedFolder::SharedFolder(const std::string& name)
{
  const std::string full = name + "-" + std::to_string(GetNumberOfRanks());
  if (GetRank() == 0)
  {
    this->Folder = std::make_unique<ScratchFolder>(full);
    this->Path = this->Folder->GetPath("");
  }
  this->Path = GatherTexts(this->Path)[0];
}

SharedFolder::~SharedFolder()
{
  GetRanks()->Barrier();
}

std::string SharedFolder::GetPath(const std::string& name) const
{
  return this->Path + name;
}

void WriteFromPieces(
  vtkImageData* image, int layout, const std::string& path, const VolumeSettings& settings)
{
  vtkNew<PieceSource> source;
  source->SetImage(image);
  source->SetLayout(layout);
  vtkNew<vtkBlockedVolumeWriter> writer;
  writer->SetInputConnection(source->GetOutputPort());
  WriteVolume(writer, path, settings);
}

ContourPipeline::ContourPipeline(const std::string& path)
  : Reader(vtkSmartPointer<vtkBlockedVolumeReader>::New())
  , Contour(vtkSmartPointer<vtkStabbingContour>::New())
{
  this->Reader->SetFileName(path.c_str());
  this->Contour->SetInputConnection(this->Reader->GetOutputPort());
}

ContourPipeline::~ContourPipeline() = default;

vtkPolyData* ContourPipeline::Update(const std::vector<double>& isovalues)
{
  const ErrorCounter readerErrors(this->Reader);
  const ErrorCounter contourErrors(this->Contour);
  SetIsovalues(this->Contour, isovalues);
  EXPECT_TRUE(this->Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0));
  EXPECT_EQ(readerErrors.Messages, std::vector<std::string>());
  EXPECT_EQ(contourErrors.Messages, std::vector<std::string>());
  return this->Contour->GetOutput();
}

} // namespace isosurface
