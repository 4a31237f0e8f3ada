// SPDX-License-Identifier: BSD-3-Clause
// Uses the installed Core: a volume is written, opened and contoured, without VTK.
#include "Ground/Base/Communicator.h"
#include "Ranks/Query/LevelExtraction.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <cstdio>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

/// Writes the error, if there is one.
bool Succeeds(const Status& status)
{
  if (!status.IsOk())
  {
    std::fprintf(stderr, "%s\n", status.GetMessage().c_str());
  }
  return status.IsOk();
}

/// A volume of 3 x 3 x 3 samples: 1 in the middle, 0 around it.
Status WriteVolume(const std::string& path)
{
  std::vector<float> samples(27, 0.0F);
  samples[13] = 1;
  GridGeometry grid;
  grid.Extent = { 0, 2, 0, 2, 0, 2 };
  VolumePiece piece;
  piece.Box = { { 0, 0, 0 }, { 3, 3, 3 } };
  SampleView view;
  view.Type = ValueType::Float32;
  view.First = samples.data();
  view.Box = piece.Box;
  view.Available = piece.Box;
  view.Stride = { 1, 3, 9 };
  piece.Arrays = { view };
  SerialCommunicator ranks;
  return BlockedVolumeWriter(ranks)
    .Write(path, grid, { { "values", ValueType::Float32, 1 } }, piece, {})
    .GetStatus();
}

} // namespace

int main()
{
  const std::string path = "installed.bvol";
  if (!Succeeds(WriteVolume(path)))
  {
    return 1;
  }
  const auto volume = BlockedVolume::Open(path);
  if (!Succeeds(volume.GetStatus()))
  {
    return 1;
  }
  SurfaceQuery query;
  query.Isovalues = { 0.5 };
  ContourRequest request;
  request.Isovalues = query.Isovalues;
  ExtractionOutcome outcome;
  if (!Succeeds(ExtractLevel({ *volume, query, request, 1, {} }, 0, outcome)))
  {
    return 1;
  }
  const std::size_t triangles = outcome.Extracted.Connectivity.GetSize() / 3;
  std::printf("%zu triangles\n", triangles);
  return triangles == 8 ? 0 : 1;
}
