// SPDX-License-Identifier: BSD-3-Clause
// Input: the text of a file of spectra, which is read as it is and with the right checksum, for as
// many arrays and stores as it seems to have.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Store/JsonDocument.h"
#include "Store/VolumeSpectra.h"

#include <algorithm>
#include <string>

using namespace isosurface;

namespace
{

const std::string Path = "/data/spectra.json";

void Use(const WorkloadSpectrum& spectrum)
{
  Require(spectrum.Bins.Count <= SpectrumBins::MaximumCount &&
      spectrum.Triangles.size() == spectrum.Bins.Count &&
      spectrum.ActiveCells.size() == spectrum.Bins.Count,
    "a spectrum has as many counts as bins");
  for (const double isovalue : { -1e300, -1.0, 0.0, 17.25, 1e300 })
  {
    Require(spectrum.FindBin(isovalue) < std::max(spectrum.Bins.Count, 1u), "a bin is there");
  }
  WorkloadSpectrum wide = spectrum;
  Require(wide.Widen(spectrum.Bins.Coarsen()), "a spectrum can be coarsened");
}

void ReadAndUse(const std::string& text, std::size_t arrays, std::size_t stores)
{
  MemoryDisk disk;
  PutFile(disk, Path, SealedBytes(text.begin(), text.end()));
  const MemoryLimit limit(64 * text.size() + std::size_t{ 256 } * 1024);
  const auto spectra = VolumeSpectra::Read(disk, Path, arrays, stores);
  if (!spectra.IsOk())
  {
    Require(spectra.GetStatus().GetMessage().find(Path) == 0, "an error names the file");
    return;
  }
  Require((*spectra)->Totals.size() == arrays && (*spectra)->Stores.size() == arrays,
    "there is a spectrum of each array");
  for (std::size_t array = 0; array < arrays; ++array)
  {
    Require((*spectra)->Stores[array].size() == stores, "there is a spectrum of each store");
    Use(*(*spectra)->Totals[array]);
  }
}

/// The numbers of arrays and stores that the text tells; 1 where it tells none.
void FindNumbers(const std::string& text, std::size_t& arrays, std::size_t& stores)
{
  arrays = 1;
  stores = 1;
  const auto limitDepth = [](int depth, Json::parse_event_t, Json&) { return depth < 20; };
  const Json document = Json::parse(text, limitDepth, false);
  if (!document.is_object() || !document.contains("arrays") || !document["arrays"].is_array())
  {
    return;
  }
  const Json& list = document["arrays"];
  arrays = std::max<std::size_t>(1, list.size());
  if (!list.empty() && list[0].is_object() && list[0].contains("stores"))
  {
    stores = std::max<std::size_t>(1, list[0]["stores"].size());
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  const std::string text(bytes, bytes + size);
  std::size_t arrays;
  std::size_t stores;
  FindNumbers(text, arrays, stores);
  ReadAndUse(text, arrays, stores);
  ReadAndUse(SealJson(text), arrays, stores);
  return 0;
}
