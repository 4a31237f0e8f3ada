// SPDX-License-Identifier: BSD-3-Clause
#include "Store/SpectraDocument.h"

#include "Store/JsonDocument.h"

#include <limits>
#include <utility>

namespace isosurface
{
namespace
{

constexpr const char* FormatName = "ScalableIsosurface spectra";
constexpr std::int64_t FormatVersion = 1;
constexpr std::uint64_t MaximumFileSize = std::uint64_t{ 4 } << 30;

std::vector<std::uint64_t> ReadCounts(JsonMembers& members, const char* name, std::size_t size)
{
  const Json& array = members.GetArray(name, size);
  std::vector<std::uint64_t> counts(size, 0);
  for (std::size_t index = 0; index < array.size(); ++index)
  {
    if (!array[index].is_number_unsigned())
    {
      members.Fail(name, "is not an array of counts");
      break;
    }
    counts[index] = array[index].get<std::uint64_t>();
  }
  return counts;
}

/// A spectrum of all that these documents have.
WorkloadSpectrum MakeOldSpectrum(const SpectrumBins& bins)
{
  WorkloadSpectrum spectrum;
  spectrum.Bins = bins;
  spectrum.Triangles.resize(bins.Count);
  spectrum.ActiveCells.resize(bins.Count);
  return spectrum;
}

} // namespace

Result<SpectraDocument> SpectraDocument::Read(
  FileSystem& files, const std::string& path, std::size_t arrays, std::size_t stores)
{
  const auto text = ReadText(files, path, MaximumFileSize);
  if (!text.IsOk())
  {
    return text.GetStatus();
  }
  const auto document = ParseDocument(*text, path, FormatName, FormatVersion);
  if (!document.IsOk())
  {
    return document.GetStatus();
  }
  SpectraDocument result;
  Status status;
  JsonMembers members(*document, path, "", status);
  const Json& list = members.GetArray("arrays", arrays);
  for (std::size_t index = 0; index < list.size() && status.IsOk(); ++index)
  {
    JsonMembers array = members.GetElement("arrays", list, index);
    SpectrumBins bins;
    constexpr std::int64_t limit = std::numeric_limits<std::int64_t>::max();
    bins.First = array.GetInteger("first", -limit - 1, limit - SpectrumBins::MaximumCount);
    bins.Exponent = static_cast<std::int32_t>(array.GetInteger("exponent", -1100, 1100));
    bins.Count =
      static_cast<std::uint32_t>(array.GetInteger("count", 0, SpectrumBins::MaximumCount));
    WorkloadSpectrum total = MakeOldSpectrum(bins);
    const Json& spectra = array.GetArray("stores", stores);
    result.Stores.emplace_back();
    for (std::size_t store = 0; store < spectra.size() && status.IsOk(); ++store)
    {
      JsonMembers counts = array.GetElement("stores", spectra, store);
      WorkloadSpectrum spectrum = MakeOldSpectrum(bins);
      spectrum.Triangles = ReadCounts(counts, "triangles", bins.Count);
      spectrum.ActiveCells = ReadCounts(counts, "activeCells", bins.Count);
      total.Add(spectrum);
      result.Stores.back().push_back(std::move(spectrum));
    }
    result.Totals.push_back(std::move(total));
  }
  ISOSURFACE_RETURN_IF_ERROR(status);
  return result;
}

} // namespace isosurface
