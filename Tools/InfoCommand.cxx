// SPDX-License-Identifier: BSD-3-Clause
#include "BlockVolumeCommands.h"

#include "Ground/Base/PrintableText.h"
#include "Ground/Volume/VolumeName.h"
#include "ProgressDisplay.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Storage/Store/BlockedVolume.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// One column of a printed contour spectrum: one value for each isovalue.
struct SpectrumColumn
{
  std::string Name;
  nlohmann::json Values; ///< an array of numbers
};

using PlainJson = nlohmann::json;

std::string FormatNumber(const PlainJson& value)
{
  if (!value.is_number_float())
  {
    return value.dump();
  }
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value.get<double>());
  return text.data();
}

/// All columns of a spectrum, isovalues first; area and volume in the units of the grid.
std::vector<SpectrumColumn> MakeSpectrumColumns(const WorkloadSpectrum& spectrum)
{
  const SpectrumColumn quantities[] = { { "triangles", spectrum.Triangles },
    { "activeCells", spectrum.ActiveCells }, { "activeBlocks", spectrum.ActiveBlocks },
    { "bytes", spectrum.Bytes }, { "area", spectrum.Scale(spectrum.Area) },
    { "volume", spectrum.Scale(spectrum.Volume) } };
  std::vector<SpectrumColumn> columns = { { "isovalue", spectrum.Bins.GetEdges() } };
  static_assert(std::size(quantities) == WorkloadSpectrum::NumberOfQuantities);
  std::copy_if(std::begin(quantities), std::end(quantities), std::back_inserter(columns),
    [&](const SpectrumColumn& column) { return column.Values.size() == spectrum.Bins.Count; });
  return columns;
}

/// At most `count` bins, evenly distributed from the first to the last whose isosurface has at least
/// a hundredth of the maximum number of triangles; ascending.
std::vector<std::size_t> PickBins(const WorkloadSpectrum& spectrum, std::size_t count)
{
  const WorkloadSpectrum::Counts& triangles = spectrum.Triangles;
  if (triangles.empty() || count == 0)
  {
    return {};
  }
  const std::uint64_t minimum = *std::max_element(triangles.begin(), triangles.end()) / 100;
  const auto isLarge = [minimum](std::uint64_t number) { return number >= minimum; };
  const auto first = static_cast<std::size_t>(
    std::find_if(triangles.begin(), triangles.end(), isLarge) - triangles.begin());
  const auto last = static_cast<std::size_t>(
    triangles.rend() - std::find_if(triangles.rbegin(), triangles.rend(), isLarge) - 1);
  const std::size_t steps = std::min(count, last - first + 1) - 1;
  std::vector<std::size_t> bins = { first };
  for (std::size_t step = 1; step <= steps; ++step)
  {
    bins.push_back(first + (last - first) * step / steps);
  }
  return bins;
}

/// The columns as text, with their names and one line for each isovalue: of the given bins, or of all.
std::string FormatSpectrum(
  const std::vector<SpectrumColumn>& columns, const std::vector<std::size_t>& bins)
{
  std::vector<std::string> lines(bins.size() + 1);
  for (const SpectrumColumn& column : columns)
  {
    std::vector<std::string> texts = { column.Name };
    for (const std::size_t bin : bins)
    {
      texts.push_back(FormatNumber(column.Values[bin]));
    }
    std::size_t width = 0;
    for (const std::string& text : texts)
    {
      width = std::max(width, text.size());
    }
    for (std::size_t line = 0; line < lines.size(); ++line)
    {
      lines[line] += std::string(width + 2 - texts[line].size(), ' ') + texts[line];
    }
  }
  std::string table;
  for (const std::string& line : lines)
  {
    table += line + "\n";
  }
  return table;
}

std::string FormatSpectrum(const std::vector<SpectrumColumn>& columns)
{
  std::vector<std::size_t> bins(columns.empty() ? 0 : columns.front().Values.size());
  std::iota(bins.begin(), bins.end(), std::size_t{ 0 });
  return FormatSpectrum(columns, bins);
}

using Json = nlohmann::ordered_json;

/// Isovalues with fewer triangles a store do not count for the balance.
constexpr std::uint64_t MinimumTriangles = 1000;
/// How many isovalues of a spectrum are printed, unless all are asked for.
constexpr std::size_t PrintedIsovalues = 16;

/// The maximum share of a store, divided by the mean share; null if there is nothing to share.
template <typename T>
Json ComputeBalance(const std::vector<T>& shares)
{
  T sum = 0;
  T maximum = 0;
  for (const T share : shares)
  {
    sum += share;
    maximum = std::max(maximum, share);
  }
  return sum == 0 ? Json()
                  : Json(static_cast<double>(maximum) * static_cast<double>(shares.size()) /
                      static_cast<double>(sum));
}

/// Values in their own type: 64-bit integers do not fit a double.
Json MakeValue(ValueType type, ValueKey key)
{
  return DispatchValueType(
    type, [key](auto zero) { return Json(MakeValueOfKey<decltype(zero)>(key)); });
}

Json MakeGrid(const BlockedVolume& volume)
{
  const GridGeometry& grid = volume.GetHeader().Grid;
  Json told = { { "dimensions", grid.GetDimensions() }, { "extent", grid.Extent } };
  if (grid.Unit != LengthUnit::Unknown)
  {
    told["unit"] = GetLengthUnitName(grid.Unit);
  }
  if (const GridLines* lines = volume.GetLines(0))
  {
    told["coordinates"] = lines->Coordinates;
    return told;
  }
  told["origin"] = grid.Origin;
  told["spacing"] = grid.Spacing;
  told["direction"] = grid.Direction;
  return told;
}

/// "density", "velocity, component 1", "velocity, magnitude": the names of variables.
std::string FormatVariable(const BlockedVolume& volume, std::size_t variable)
{
  const Variable& described = volume.GetVariables()[variable];
  const ArrayDescription& array = volume.GetHeader().Arrays[described.Array];
  const std::string component =
    described.IsMagnitude() ? ", magnitude" : ", component " + std::to_string(described.Component);
  return array.Name + (array.Components > 1 ? component : "");
}

/// How evenly the triangles are distributed, at the isovalues with many triangles.
Result<Json> MakeTriangleBalance(BlockedVolume& volume, std::size_t step, std::size_t variable)
{
  const std::uint32_t stores = volume.GetHeader().NumberOfStores;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto total, volume.GetSpectrum(step, variable));
  std::vector<std::shared_ptr<const WorkloadSpectrum>> spectra;
  for (std::uint32_t store = 0; store < stores; ++store)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto spectrum, volume.GetStoreSpectrum(step, variable, store));
    spectra.push_back(spectrum);
  }
  std::vector<std::pair<double, double>> balances; // each with its isovalue
  for (std::size_t bin = 0; bin < total->Bins.Count; ++bin)
  {
    if (total->Triangles[bin] < MinimumTriangles * stores)
    {
      continue;
    }
    std::vector<std::uint64_t> triangles;
    triangles.reserve(spectra.size());
    for (const auto& spectrum : spectra)
    {
      triangles.push_back(spectrum->Triangles[bin]);
    }
    balances.emplace_back(ComputeBalance(triangles).get<double>(), total->Bins.GetEdge(bin));
  }
  if (balances.empty())
  {
    return Json();
  }
  std::sort(balances.begin(), balances.end());
  return Json{ { "isovalues", balances.size() }, { "worst", balances.back().first },
    { "worstIsovalue", balances.back().second },
    { "median", balances[balances.size() / 2].first } };
}

Result<Json> MakeSpectra(BlockedVolume& volume, std::size_t step)
{
  Json spectra = Json::array();
  for (std::size_t variable = 0; variable < volume.GetVariables().GetCount(); ++variable)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto spectrum, volume.GetSpectrum(step, variable));
    Json columns = { { "variable", FormatVariable(volume, variable) } };
    for (const SpectrumColumn& column : MakeSpectrumColumns(*spectrum))
    {
      columns[column.Name] = column.Values;
    }
    spectra.push_back(std::move(columns));
  }
  return spectra;
}

Result<Json> MakeTimeStep(BlockedVolume& volume, std::size_t index)
{
  const BlockedVolumeHeader& header = volume.GetHeader();
  const TimeStepDescription& step = header.TimeSteps[index];
  Json result = { { "time", step.Time ? Json(*step.Time) : Json() }, { "folder", step.Folder } };
  result["ranges"] = Json::array();
  for (std::size_t variable = 0; variable < step.Ranges.size(); ++variable)
  {
    const KeyRange& range = step.Ranges[variable];
    const ValueType type = volume.GetVariables()[variable].Type;
    result["ranges"].push_back(range.IsEmpty()
        ? Json()
        : Json::array({ MakeValue(type, range.Minimum), MakeValue(type, range.Maximum) }));
  }
  for (const auto& [name, record] :
    { std::pair<const char*, const std::optional<SourceRecord>&>{ "source", step.Source },
      { "copyOf", step.CopyOf } })
  {
    if (record)
    {
      result[name] = { { "path", record->FindPath(GetLocalFileSystem(), volume.GetPath()) },
        { "within", record->Within }, { "step", record->Step }, { "arrays", record->Arrays },
        { "files", record->State.Files }, { "bytes", record->State.Bytes } };
      if (record->Chunk)
      {
        result[name]["chunk"] = *record->Chunk;
      }
    }
  }
  std::vector<std::uint64_t> blocks;
  std::vector<std::uint64_t> bytes;
  result["blocks"] = 0;
  result["bytes"] = 0;
  result["stores"] = Json::array();
  for (const StoreDescription& store : step.Stores)
  {
    blocks.push_back(store.Blocks);
    bytes.push_back(store.Bytes);
    result["blocks"] = result["blocks"].get<std::uint64_t>() + store.Blocks;
    result["bytes"] = result["bytes"].get<std::uint64_t>() + store.Bytes;
    result["stores"].push_back({ { "blocks", store.Blocks }, { "bytes", store.Bytes } });
  }
  Json triangles = Json::array();
  for (std::size_t variable = 0; variable < step.Ranges.size(); ++variable)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto balance, MakeTriangleBalance(volume, index, variable));
    triangles.push_back(std::move(balance));
  }
  result["balance"] = { { "blocks", ComputeBalance(blocks) }, { "bytes", ComputeBalance(bytes) },
    { "triangles", std::move(triangles) } };
  return result;
}

Result<Json> Describe(BlockedVolume& volume, bool withSpectrum)
{
  const BlockedVolumeHeader& header = volume.GetHeader();
  Json result = { { "file", volume.GetPath() }, { "grid", MakeGrid(volume) },
    { "blockSize", header.BlockSize }, { "levels", volume.GetNumberOfLevels() },
    { "replicas", header.NumberOfReplicas } };
  result["compression"] = { { "codec", GetCodecName(header.Compression.Codec) },
    { "level", header.Compression.GetEffectiveLevel() } };
  result["distribution"] = { { "method", GetDistributionName(header.Distribution) },
    { "seed", header.RandomSeed } };
  result["arrays"] = Json::array();
  std::uint64_t sampleBytes = 0;
  for (const ArrayDescription& array : header.Arrays)
  {
    Json told = { { "name", array.Name }, { "type", GetValueTypeName(array.Type) },
      { "components", array.Components } };
    if (!array.Unit.empty())
    {
      told["unit"] = array.Unit;
    }
    result["arrays"].push_back(std::move(told));
    sampleBytes += static_cast<std::uint64_t>(header.Grid.GetNumberOfVertices()) *
      GetValueSize(array.Type) * static_cast<std::uint64_t>(array.Components);
  }
  result["variables"] = Json::array();
  for (std::size_t variable = 0; variable < volume.GetVariables().GetCount(); ++variable)
  {
    result["variables"].push_back(FormatVariable(volume, variable));
  }
  result["sampleBytes"] = sampleBytes;
  result["timeSteps"] = Json::array();
  for (std::size_t step = 0; step < header.TimeSteps.size(); ++step)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto described, MakeTimeStep(volume, step));
    if (withSpectrum)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(auto spectra, MakeSpectra(volume, step));
      described["spectra"] = std::move(spectra);
    }
    result["timeSteps"].push_back(std::move(described));
  }
  return result;
}

std::string Join(const Json& values, const char* between)
{
  std::string text;
  for (const Json& value : values)
  {
    text += (text.empty() ? "" : between) + value.dump();
  }
  return text;
}

/// A ratio, as "1.07".
std::string FormatRatio(const Json& ratio)
{
  char text[32] = "-";
  if (!ratio.is_null())
  {
    std::snprintf(text, sizeof(text), "%.2f", ratio.get<double>());
  }
  return text;
}

std::string FormatSource(const Json& source)
{
  return VolumeName{ source["path"].get<std::string>(), source["within"].get<std::string>() }
    .GetText();
}

void PrintTimeStep(const Json& volume, const Json& step)
{
  std::printf("time step     %s%s\n", step["folder"].get<std::string>().c_str(),
    step["time"].is_null() ? "" : (", time " + step["time"].dump()).c_str());
  for (std::size_t variable = 0; variable < volume["variables"].size(); ++variable)
  {
    const Json& range = step["ranges"][variable];
    std::printf("  range       %s: %s\n", volume["variables"][variable].dump().c_str(),
      range.is_null() ? "no finite values" : Join(range, " to ").c_str());
  }
  const auto bytes = step["bytes"].get<double>();
  std::printf("  blocks      %s, %s (%s of samples)\n", step["blocks"].dump().c_str(),
    DescribeBytes(bytes).c_str(), DescribeBytes(volume["sampleBytes"].get<double>()).c_str());
  if (step.contains("source"))
  {
    std::printf("  in place    the samples are in %s, chunks of %s\n",
      FormatSource(step["source"]).c_str(), Join(step["source"]["chunk"], " x ").c_str());
  }
  if (step.contains("copyOf"))
  {
    std::printf("  copy        of %s\n", FormatSource(step["copyOf"]).c_str());
  }
  if (volume["replicas"].get<int>() > 1)
  {
    std::printf("  replicas    each block is in %s stores\n", volume["replicas"].dump().c_str());
  }
  for (std::size_t store = 0; store < step["stores"].size(); ++store)
  {
    std::printf("  store %05zu %s blocks, %s\n", store,
      step["stores"][store]["blocks"].dump().c_str(),
      DescribeBytes(step["stores"][store]["bytes"].get<double>()).c_str());
  }
  const Json& balance = step["balance"];
  std::printf("  balance     (maximum over mean) blocks %s, bytes %s\n",
    FormatRatio(balance["blocks"]).c_str(), FormatRatio(balance["bytes"]).c_str());
  for (std::size_t variable = 0; variable < volume["variables"].size(); ++variable)
  {
    const Json& triangles = balance["triangles"][variable];
    const std::string name = volume["variables"][variable].dump();
    if (triangles.is_null())
    {
      std::printf("              triangles of %s: no isovalue has %llu a store\n", name.c_str(),
        static_cast<unsigned long long>(MinimumTriangles));
      continue;
    }
    std::printf(
      "              triangles of %s: median %s, worst %s (isovalue %s) of %s isovalues\n",
      name.c_str(), FormatRatio(triangles["median"]).c_str(),
      FormatRatio(triangles["worst"]).c_str(), triangles["worstIsovalue"].dump().c_str(),
      triangles["isovalues"].dump().c_str());
  }
}

/// Prints the spectra of all variables, at all isovalues or at some.
Status PrintSpectra(BlockedVolume& volume, std::size_t step, bool isWhole)
{
  for (std::size_t variable = 0; variable < volume.GetVariables().GetCount(); ++variable)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto spectrum, volume.GetSpectrum(step, variable));
    const std::vector<SpectrumColumn> columns = MakeSpectrumColumns(*spectrum);
    const std::string table = isWhole
      ? FormatSpectrum(columns)
      : FormatSpectrum(columns, PickBins(*spectrum, PrintedIsovalues));
    std::printf(
      "  spectrum    %s\n%s", Json(FormatVariable(volume, variable)).dump().c_str(), table.c_str());
  }
  return Status::Ok();
}

Status Print(BlockedVolume& volume, const Json& told, bool withSpectrum)
{
  const Json& grid = told["grid"];
  std::printf("%s\n", volume.GetPath().c_str());
  std::printf("dimensions    %s\n", Join(grid["dimensions"], " x ").c_str());
  std::printf("extent        %s\n", Join(grid["extent"], " ").c_str());
  if (grid.contains("coordinates"))
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const Json& lines = grid["coordinates"][axis];
      std::printf("coordinates   %c: %s to %s\n", "xyz"[axis], lines.front().dump().c_str(),
        lines.back().dump().c_str());
    }
  }
  else
  {
    std::printf("spacing       %s\n", Join(grid["spacing"], " ").c_str());
    std::printf("origin        %s\n", Join(grid["origin"], " ").c_str());
    std::printf("direction     %s\n", Join(grid["direction"], " ").c_str());
  }
  if (grid.contains("unit"))
  {
    std::printf("unit          %s\n", grid["unit"].get<std::string>().c_str());
  }
  std::printf("blocks        %s cells a side, %s levels\n", told["blockSize"].dump().c_str(),
    told["levels"].dump().c_str());
  const auto codec = told["compression"]["codec"].get<std::string>();
  std::printf("compression   %s%s\n", codec.c_str(),
    codec == "none" ? "" : (", level " + told["compression"]["level"].dump()).c_str());
  std::printf("distribution  %s, seed %s\n",
    told["distribution"]["method"].get<std::string>().c_str(),
    told["distribution"]["seed"].dump().c_str());
  for (const Json& array : told["arrays"])
  {
    const auto components = array["components"].get<int>();
    std::printf("array         %s: %s%s%s\n", array["name"].dump().c_str(),
      array["type"].get<std::string>().c_str(),
      components > 1 ? (", " + std::to_string(components) + " components").c_str() : "",
      array.contains("unit") ? (", unit " + array["unit"].dump()).c_str() : "");
  }
  for (std::size_t step = 0; step < told["timeSteps"].size(); ++step)
  {
    PrintTimeStep(told, told["timeSteps"][step]);
    ISOSURFACE_RETURN_IF_ERROR(PrintSpectra(volume, step, withSpectrum));
  }
  return Status::Ok();
}

} // namespace

Status RunInfoCommand(const BlockVolumeOptions& options)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto volume, BlockedVolume::Open(options.Input));
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto told, Describe(*volume, options.WithSpectrum && options.IsJson));
  if (options.IsJson)
  {
    std::printf("%s\n", told.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
    return Status::Ok();
  }
  return Print(*volume, told, options.WithSpectrum);
}

} // namespace isosurface
