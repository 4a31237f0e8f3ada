// SPDX-License-Identifier: BSD-3-Clause
#include "Store/VolumeSpectra.h"

#include "Base/ByteOrder.h"
#include "Store/JsonDocument.h"

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

} // namespace

std::string VolumeSpectra::GetPath(const std::string& volumePath, const std::string& generation)
{
  return GetStoresFolder(volumePath) + "/" + generation + "/spectra.json";
}

Status VolumeSpectra::Write(FileSystem& files, const std::string& path,
  const std::vector<std::vector<WorkloadSpectrum>>& stores)
{
  Json document = { { "format", FormatName }, { "formatVersion", FormatVersion },
    { "arrays", Json::array() } };
  for (const std::vector<WorkloadSpectrum>& spectra : stores)
  {
    const SpectrumBins& bins = spectra.front().Bins;
    Json array = { { "first", bins.First }, { "exponent", bins.Exponent }, { "count", bins.Count },
      { "stores", Json::array() } };
    for (const WorkloadSpectrum& spectrum : spectra)
    {
      array["stores"].push_back(
        { { "triangles", spectrum.Triangles }, { "activeCells", spectrum.ActiveCells } });
    }
    document["arrays"].push_back(std::move(array));
  }
  const std::string text = FormatDocument(std::move(document));
  auto file = files.CreateForWriting(path);
  if (!file.IsOk())
  {
    return file.GetStatus();
  }
  ISOSURFACE_RETURN_IF_ERROR((*file)->Append(text.data(), text.size()));
  return (*file)->SyncAndClose();
}

void VolumeSpectra::AppendCounts(const WorkloadSpectrum& spectrum, Message& message)
{
  for (const std::vector<std::uint64_t>* counts : { &spectrum.Triangles, &spectrum.ActiveCells })
  {
    for (const std::uint64_t count : *counts)
    {
      message.resize(message.size() + sizeof(count));
      StoreLittleEndian(message.data() + message.size() - sizeof(count), count);
    }
  }
}

void VolumeSpectra::TakeCounts(
  const Message& message, std::size_t& position, WorkloadSpectrum& spectrum)
{
  for (std::vector<std::uint64_t>* counts : { &spectrum.Triangles, &spectrum.ActiveCells })
  {
    for (std::uint64_t& count : *counts)
    {
      count = LoadLittleEndian<std::uint64_t>(message.data() + position);
      position += sizeof(count);
    }
  }
}

Result<std::shared_ptr<const VolumeSpectra>> VolumeSpectra::Read(
  FileSystem& files, const std::string& path, std::size_t variables, std::size_t stores)
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
  auto result = std::make_shared<VolumeSpectra>();
  Status status;
  JsonMembers members(*document, path, "", status);
  const Json& list = members.GetArray("arrays", variables);
  for (std::size_t index = 0; index < list.size() && status.IsOk(); ++index)
  {
    JsonMembers array = members.GetElement("arrays", list, index);
    SpectrumBins bins;
    constexpr std::int64_t limit = std::numeric_limits<std::int64_t>::max();
    bins.First = array.GetInteger("first", -limit - 1, limit - SpectrumBins::MaximumCount);
    bins.Exponent = static_cast<std::int32_t>(array.GetInteger("exponent", -1100, 1100));
    bins.Count =
      static_cast<std::uint32_t>(array.GetInteger("count", 0, SpectrumBins::MaximumCount));
    WorkloadSpectrum total(bins);
    const Json& spectra = array.GetArray("stores", stores);
    result->Stores.emplace_back();
    for (std::size_t store = 0; store < spectra.size() && status.IsOk(); ++store)
    {
      JsonMembers counts = array.GetElement("stores", spectra, store);
      WorkloadSpectrum spectrum(bins);
      spectrum.Triangles = ReadCounts(counts, "triangles", bins.Count);
      spectrum.ActiveCells = ReadCounts(counts, "activeCells", bins.Count);
      total.Add(spectrum);
      result->Stores.back().push_back(std::make_shared<WorkloadSpectrum>(std::move(spectrum)));
    }
    result->Totals.push_back(std::make_shared<WorkloadSpectrum>(std::move(total)));
  }
  ISOSURFACE_RETURN_IF_ERROR(status);
  return std::shared_ptr<const VolumeSpectra>(std::move(result));
}

} // namespace isosurface
