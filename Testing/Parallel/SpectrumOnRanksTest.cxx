// SPDX-License-Identifier: BSD-3-Clause
// A spectrum is the same on any number of ranks; the first one has it.
#include "ParallelVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkContourSpectrum.h"

#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkTable.h"

#include "Ranks/Query/Refinement.h"

using namespace isosurface;

namespace
{

void UpdatePiece(vtkContourSpectrum* spectrum)
{
  const ExpectNoErrors errors(spectrum);
  spectrum->SetController(GetRanks());
  spectrum->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
}

// The ranks' table is that of one process that has all, on rank 0; others have none.
void ExpectEqualsThatOfWhole(vtkTable* mine, vtkImageData* image)
{
  if (GetRank() != 0)
  {
    EXPECT_EQ(mine->GetNumberOfColumns(), 0);
    return;
  }
  vtkNew<vtkContourSpectrum> alone;
  alone->SetController(nullptr);
  alone->SetInputData(image);
  alone->Update();
  ASSERT_EQ(mine->GetNumberOfRows(), alone->GetOutput()->GetNumberOfRows());
  ASSERT_GT(mine->GetNumberOfRows(), 100);
  ASSERT_EQ(mine->GetNumberOfColumns(), 7);
  for (vtkIdType column = 0; column < 7; ++column)
  {
    for (vtkIdType row = 0; row < mine->GetNumberOfRows(); ++row)
    {
      ASSERT_EQ(mine->GetValue(row, column), alone->GetOutput()->GetValue(row, column))
        << mine->GetColumnName(column) << " in row " << row;
    }
  }
}

TEST(SpectrumOnRanks, OfImagePiecesIsThatOfTheWhole)
{
  for (const int type : { VTK_SHORT, VTK_FLOAT })
  {
    const auto image = MakeClosedVolume({ -41, 28, -7, 53, -90, -8 }, type);
    for (const int layout : { PieceSource::SUB_EXTENTS, PieceSource::FIRST_RANK })
    {
      vtkNew<vtkContourSpectrum> spectrum;
      spectrum->SetInputConnection(MakeSource(image, layout)->GetOutputPort());
      UpdatePiece(spectrum);
      ExpectEqualsThatOfWhole(spectrum->GetOutput(), image);
    }
  }
}

TEST(SpectrumOnRanks, CountedBesideIsThatOfTheWhole)
{
  const auto image = MakeClosedVolume({ -41, 28, -7, 53, -90, -8 }, VTK_FLOAT);
  vtkNew<vtkContourSpectrum> spectrum;
  const auto source = MakeSource(image, PieceSource::FIRST_RANK);
  spectrum->SetInputConnection(source->GetOutputPort());
  spectrum->CountBeside(0);
  UpdatePiece(spectrum);
  EXPECT_EQ(spectrum->GetOutput()->GetNumberOfColumns(), 0);
  const auto isCounting = [&]
  { return Refinement::FromValues(spectrum->GetRefinement()).Stage == RefinementStage::Working; };
  EXPECT_TRUE(isCounting());
  for (int tries = 0; isCounting() && tries < 1000; ++tries)
  {
    spectrum->AdvanceCounting(100);
  }
  spectrum->TakeCounting();
  UpdatePiece(spectrum);
  ExpectEqualsThatOfWhole(spectrum->GetOutput(), image);
}

TEST(SpectrumOnRanks, OfAVolumeIsOnTheFirstRank)
{
  const auto image = MakeClosedVolume({ -41, 28, -7, 53, -90, -8 }, VTK_SHORT);
  const SharedVolume volume("SpectrumOnRanks", image,
    { 32, 4, vtkBlockedVolumeWriter::GREEDY, vtkBlockedVolumeWriter::LZ4 });
  const auto reader = MakeReader(volume.Path);
  vtkNew<vtkContourSpectrum> spectrum;
  spectrum->SetInputConnection(reader->GetOutputPort());
  UpdatePiece(spectrum);
  EXPECT_EQ(spectrum->GetOutput()->GetNumberOfColumns(), GetRank() == 0 ? 7 : 0);
}

} // namespace
