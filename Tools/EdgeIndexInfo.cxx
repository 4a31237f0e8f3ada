// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndexCommands.h"
#include "ProgressDisplay.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Ground/Base/PrintableText.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <string>
#include <vector>

namespace isosurface
{
namespace
{

using Json = nlohmann::ordered_json;

const char* GetModeName(EdgeIndexMode mode)
{
  const char* const names[] = { "lossless", "bounded", "quantized", "smallest" };
  return names[static_cast<std::size_t>(mode)];
}

/// Blocks, crossed edges and bytes of some records.
struct Totals
{
  std::uint64_t Blocks = 0;
  std::uint64_t Points = 0;
  std::uint64_t Bytes = 0;

  void Add(const EdgeIndexEntry& entry)
  {
    ++this->Blocks;
    this->Points += entry.Block.NumberOfPoints;
    this->Bytes += entry.Size;
  }
  void Describe(Json& json) const
  {
    json["blocks"] = this->Blocks;
    json["points"] = this->Points;
    json["bytes"] = this->Bytes;
  }
};

Json DescribeSettings(const EdgeIndexHeader& header)
{
  const EdgeIndexSettings& settings = header.Settings;
  Json json = { { "mode", GetModeName(settings.Mode) },
    { "profile", settings.Profile == EdgeIndexProfile::Small ? "small" : "working" } };
  if (settings.Mode == EdgeIndexMode::Bounded || settings.Mode == EdgeIndexMode::Smallest)
  {
    json["maximumError"] = settings.MaximumError;
  }
  if (settings.Mode == EdgeIndexMode::Quantized)
  {
    json["quantizationBits"] = settings.QuantizationBits;
    json["quantizationRange"] = { settings.QuantizationMinimum, settings.QuantizationMaximum };
  }
  return json;
}

Json Describe(const EdgeIndexFile& file)
{
  const EdgeIndexHeader& header = file.GetHeader();
  std::vector<Totals> isovalues(header.Isovalues.size());
  Totals preview;
  for (const EdgeIndexEntry& entry : file.GetEntries())
  {
    (entry.Block.IsPreview ? preview : isovalues[entry.Block.Isovalue]).Add(entry);
  }
  Json json = { { "file", file.GetPath() }, { "bytes", file.GetSize() },
    { "isComplete", file.IsComplete() } };
  if (!file.IsComplete())
  {
    json["missing"] = file.GetMissing();
  }
  const GridGeometry& grid = header.Geometry;
  json["grid"] = { { "dimensions", grid.GetDimensions() }, { "extent", grid.Extent },
    { "origin", grid.Origin }, { "spacing", grid.Spacing }, { "direction", grid.Direction } };
  if (grid.Unit != LengthUnit::Unknown)
  {
    json["grid"]["unit"] = GetLengthUnitName(grid.Unit);
  }
  json["array"] = header.Array;
  json["type"] = GetValueTypeName(header.Type);
  json["source"] = header.Source;
  json["time"] = header.Time ? Json(*header.Time) : Json();
  json["settings"] = DescribeSettings(header);
  if (!header.ClosedSides.IsEmpty())
  {
    json["closed"] = header.ClosedSides.AreBeyondInside ? "below" : "above";
  }
  if (header.LacksIslands)
  {
    json["lacksIslands"] = true;
  }
  json["attributes"] = Json::array();
  for (const EdgeIndexAttribute& attribute : header.Attributes)
  {
    json["attributes"].push_back({ { "name", attribute.Name },
      { "type", GetValueTypeName(attribute.Type) }, { "components", attribute.NumberOfComponents },
      { "maximumError", attribute.MaximumError }, { "isNormals", attribute.IsNormals } });
  }
  json["isovalues"] = Json::array();
  for (std::size_t n = 0; n < isovalues.size(); ++n)
  {
    Json one = { { "isovalue", header.Isovalues[n] } };
    isovalues[n].Describe(one);
    json["isovalues"].push_back(std::move(one));
  }
  if (header.PreviewLevel > 0)
  {
    json["preview"] = { { "level", header.PreviewLevel },
      { "maximumError", header.PreviewMaximumError } };
    preview.Describe(json["preview"]);
  }
  return json;
}

/// Names and paths may be any bytes.
std::string Dump(const Json& json, int indent = -1)
{
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string Join(const Json& values, const char* between)
{
  std::string text;
  for (const Json& value : values)
  {
    text += (text.empty() ? "" : between) + Dump(value);
  }
  return text;
}

void PrintTotals(const std::string& name, const Json& totals)
{
  const auto points = totals["points"].get<double>();
  const auto bytes = totals["bytes"].get<double>();
  std::printf("%-13s %s blocks, %s points, %s", name.c_str(), Dump(totals["blocks"]).c_str(),
    Dump(totals["points"]).c_str(), DescribeBytes(bytes).c_str());
  if (points > 0)
  {
    std::printf(", %.2f bits a point", 8 * bytes / points);
  }
  std::printf("\n");
}

void Print(const Json& told)
{
  const Json& grid = told["grid"];
  const Json& settings = told["settings"];
  std::printf("%s\n", told["file"].get<std::string>().c_str());
  std::printf("size          %s\n", DescribeBytes(told["bytes"].get<double>()).c_str());
  std::printf("dimensions    %s\n", Join(grid["dimensions"], " x ").c_str());
  std::printf("extent        %s\n", Join(grid["extent"], " ").c_str());
  std::printf("spacing       %s\n", Join(grid["spacing"], " ").c_str());
  std::printf("origin        %s\n", Join(grid["origin"], " ").c_str());
  std::printf("direction     %s\n", Join(grid["direction"], " ").c_str());
  if (grid.contains("unit"))
  {
    std::printf("unit          %s\n", grid["unit"].get<std::string>().c_str());
  }
  std::printf("array         %s: %s, of %s\n", Dump(told["array"]).c_str(),
    told["type"].get<std::string>().c_str(), Dump(told["source"]).c_str());
  if (!told["time"].is_null())
  {
    std::printf("time          %s\n", Dump(told["time"]).c_str());
  }
  std::printf("mode          %s", settings["mode"].get<std::string>().c_str());
  if (settings.contains("maximumError"))
  {
    std::printf(", to within %s of an edge", Dump(settings["maximumError"]).c_str());
  }
  if (settings.contains("quantizationBits"))
  {
    std::printf(", %s bits from %s", Dump(settings["quantizationBits"]).c_str(),
      Join(settings["quantizationRange"], " to ").c_str());
  }
  std::printf("; profile %s\n", settings["profile"].get<std::string>().c_str());
  if (told.contains("closed"))
  {
    std::printf("closed        %s the isovalue\n", told["closed"].get<std::string>().c_str());
  }
  if (told.contains("lacksIslands"))
  {
    std::printf("islands       some are left out\n");
  }
  for (const Json& attribute : told["attributes"])
  {
    std::printf("attribute     %s: %s x %s, to within %s\n", Dump(attribute["name"]).c_str(),
      attribute["type"].get<std::string>().c_str(), Dump(attribute["components"]).c_str(),
      Dump(attribute["maximumError"]).c_str());
  }
  for (const Json& isovalue : told["isovalues"])
  {
    PrintTotals("isovalue " + Dump(isovalue["isovalue"]), isovalue);
  }
  if (told.contains("preview"))
  {
    PrintTotals(
      "preview, 1/" + std::to_string(1 << told["preview"]["level"].get<int>()), told["preview"]);
  }
  if (told.contains("missing"))
  {
    std::printf("missing       %s\n", MakePrintable(told["missing"].get<std::string>()).c_str());
  }
}

} // namespace

Status RunEdgeIndexInfo(const EdgeIndexOptions& options)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto file, EdgeIndexFile::Open(GetLocalFileSystem(), options.Input));
  const Json told = Describe(*file);
  if (options.IsJson)
  {
    std::printf("%s\n", Dump(told, 2).c_str());
  }
  else
  {
    Print(told);
  }
  return Status::Ok();
}

} // namespace isosurface
