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
  vtkNew<vtkBlockedVolumeWriter> writer;
  writer->SetInputConnection(MakeSource(image, layout)->GetOutputPort());
  WriteVolume(writer, path, settings);
}

SharedVolume::SharedVolume(
  const std::string& name, vtkImageData* image, const VolumeSettings& settings, int layout)
  : Folder(name)
  , Path(this->Folder.GetPath("volume.bvol"))
{
  WriteFromPieces(image, layout, this->Path, settings);
}

vtkSmartPointer<PieceSource> MakeSource(vtkImageData* image, int layout)
{
  auto source = vtkSmartPointer<PieceSource>::New();
  source->SetImage(image);
  source->SetLayout(layout);
  return source;
}

void ExpectSurfaceOf(vtkPolyData* mine, vtkImageData* image, double isovalue)
{
  const EdgeSurface all = GatherSurface(mine);
  if (GetRank() == 0)
  {
    EXPECT_TRUE(AreEqual(all, ContourByFlyingEdges(image, isovalue))) << "at " << isovalue;
  }
}

void ShowByHand(vtkStabbingContour* contour)
{
  contour->AllowCoarse(1);
  contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  contour->AllowCoarse(0);
  for (int passes = 0; !contour->GetFinal() && passes < 10; ++passes)
  {
    contour->Refine();
    contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  }
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
  const ExpectNoErrors readerErrors(this->Reader);
  const ExpectNoErrors contourErrors(this->Contour);
  SetIsovalues(this->Contour, isovalues);
  EXPECT_TRUE(this->Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0));
  return this->Contour->GetOutput();
}

} // namespace isosurface
