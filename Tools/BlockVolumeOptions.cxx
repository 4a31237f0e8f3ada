// SPDX-License-Identifier: BSD-3-Clause
#include "BlockVolumeOptions.h"

#include "Formats/Source/TextFields.h"
#include "Ground/Base/EnumeratorNames.h"
#include "Ground/Volume/ValueType.h"
#include "Storage/Distribution/BlockDistribution.h"
#include "Storage/Record/BlockCompression.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

constexpr const char* Description =
  "Writes a volume of any size as a blocked volume (OUT.bvol and .OUT.bvol.stores/), prints the\n"
  "contents of one, or checks one. Under mpirun all ranks write together; for a given\n"
  "number of stores the result does not depend on the number of ranks.";

constexpr const char* Footer = R"(IN is one of:
  .mhd .mha .nrrd .nhdr     MetaImage and NRRD, raw or gzip: read slab by slab
  .tif .tiff                TIFF or BigTIFF, one slice a page: read page by page
  a folder, 'scan*.tif'     a TIFF stack: all .tif files of the folder, or those that match the
                            pattern, ordered by the numbers in their names
  .nii .nii.gz .mrc .map    NIfTI and MRC: read slab by slab
  .h5 .vtkhdf FILE:/path    HDF5: VTKHDF image data, or a dataset of 3 to 5 axes; read slab by slab
  .nc FILE:variable         NetCDF on a regular grid, time steps included: read slab by slab
  a folder[:path]           Zarr, OME-Zarr (the finest level), N5: read chunk by chunk
  a folder or .dcm          a DICOM series, slice by slice; folder:UID chooses one
  any file --dimensions     samples without a header: read slab by slab. The same in the name:
                            FILE:512x512x300,uint16[,big-endian][,header-bytes=128]
  .vti .vtr .vtk .png ...   formats of VTK's readers; some always read the whole file

Examples:
  blockvolume head.mhd head.bvol
  mpirun -n 8 blockvolume 'slices/*.tif' scan.bvol --stores 32 --compression zstd:3
  blockvolume ct.raw ct.bvol --dimensions 2048,2048,2048 --type uint16 --memory 4096
  blockvolume step7.vti run.bvol --append --time 0.35 --arrays density,velocity
  blockvolume --list run.h5
  blockvolume run.h5:/entry/data run.bvol --axes tzyx --step 3
  blockvolume --in-place scan.zarr scan.bvol
  blockvolume --source /archive/scan.zarr scan.bvol
  blockvolume --info scan.bvol --json
  blockvolume --verify scan.bvol
  blockvolume head.mhd head.bvol --stores 8 --replicas 2
  blockvolume --repair head.bvol
  blockvolume --sandbox mail/unknown.dcm unknown.bvol

Exit status: 0 for success, 1 for an error or a fault found, 130 if the command was interrupted. OUT.bvol
appears in one step at the end; until then, and after an error, an older file stays unchanged.)";

Status MakeError(const std::string& option, const std::string& reason)
{
  return Status(StatusCode::InvalidArgument, option + ": " + reason);
}

/// What an option takes, for completion; nothing if it may be anything.
std::string ListValues(const std::string& option)
{
  return option == "type"      ? ListEnumerators(GetValueTypeName, " ")
    : option == "compression"  ? ListEnumerators(GetCodecName, " ")
    : option == "distribution" ? ListEnumerators(GetDistributionName, " ")
    : option == "unit"         ? ListEnumerators(GetLengthUnitName, " ")
    : option == "block-size"   ? "16 32 64"
                               : "";
}

std::vector<std::string> SplitAtCommas(const std::string& text)
{
  std::vector<std::string> words;
  std::size_t begin = 0;
  for (std::size_t comma = 0; comma != std::string::npos; begin = comma + 1)
  {
    comma = text.find(',', begin);
    words.push_back(TrimText(text.substr(begin, comma - begin)));
  }
  return words;
}

/// `names`: "X,Y,Z".
template <std::size_t Count>
Result<std::array<double, Count>> ParseNumbers(
  const std::string& option, const std::string& text, const char* names)
{
  const std::vector<std::string> words = SplitAtCommas(text);
  std::array<double, Count> values{};
  for (std::size_t number = 0; number < Count; ++number)
  {
    const auto value = words.size() == Count ? ParseDouble(words[number]) : std::nullopt;
    if (!value)
    {
      return MakeError(
        option, "\"" + text + "\" is not " + std::to_string(Count) + " numbers " + names);
    }
    values[number] = *value;
  }
  return values;
}

Result<std::array<double, 3>> ParseThree(const std::string& option, const std::string& text)
{
  return ParseNumbers<3>(option, text, "X,Y,Z");
}

/// "none", "lz4", "zstd:3".
Result<BlockCompression> ParseCompression(const std::string& text)
{
  const std::size_t colon = text.find(':');
  const auto codec = FindCodec(text.substr(0, colon));
  BlockCompression compression;
  bool isValid = codec.has_value();
  if (codec)
  {
    compression.Codec = *codec;
  }
  if (colon != std::string::npos)
  {
    const auto level = ParseInteger(text.substr(colon + 1));
    isValid = isValid && *codec != SegmentCodec::None && level && *level >= 1 && *level <= 100;
    compression.Level = isValid ? static_cast<int>(*level) : 0;
  }
  if (!isValid || !compression.IsValid())
  {
    return MakeError("--compression",
      "\"" + text + "\" is not none, lz4, lz4:1 to lz4:12, zstd or zstd:1 to zstd:19");
  }
  return compression;
}

/// Options as text, before they are parsed.
struct RawTexts
{
  std::string Distribution = "greedy";
  std::string Compression = "lz4";
  std::string Arrays;
  std::string Dimensions;
  std::string Type = "uint8";
  std::string Name = "scalars";
  std::string Region;
  std::string Spacing;
  std::string Origin;
  std::string Unit;
  std::uint64_t HeaderBytes = 0;
  bool IsBigEndian = false;
  bool IsGzip = false;
  std::uint64_t MemoryMebibytes = 1024;
  std::uint64_t SandboxMebibytes = 2048;
  std::optional<std::uint64_t> CacheMebibytes;
  std::string Endpoint;
  bool IsInfo = false;
  bool IsVerify = false;
  bool IsRepair = false;
  bool IsList = false;
};

void AddWritingOptions(CLI::App& app, RawTexts& texts, BlockVolumeOptions& options)
{
  app.option_defaults()->group("Writing");
  BlockedVolumeSettings& settings = options.Settings;
  app.add_option("--block-size", settings.BlockSize, "Cells along the side of a block: 16, 32, 64")
    ->capture_default_str();
  app
    .add_option("--stores", settings.NumberOfStores,
      "Stores that the blocks are distributed over; 0: the number of ranks")
    ->check(CLI::Range(0, 65536))
    ->capture_default_str();
  app
    .add_option("--replicas", settings.NumberOfReplicas,
      "Stores that have each block. With 2 or more a lost or damaged store costs nothing but "
      "speed,\n"
      "and --repair restores it. Default: 1, or as many as the volume that is appended to")
    ->check(CLI::Range(1, 16));
  app
    .add_option("--distribution", texts.Distribution,
      "How blocks are distributed: greedy (similar blocks in turn), balanced (equal shares of\n"
      "the estimated triangles), random (by a seeded hash), slab (neighbours together; the\n"
      "default with --in-place, because neighbours share chunks)")
    ->capture_default_str();
  app.add_option("--seed", settings.RandomSeed, "Seed of the random distribution")
    ->capture_default_str();
  app
    .add_option("--compression", texts.Compression,
      "Lossless: none, lz4[:1-12] (fast) or zstd[:1-19] (small)")
    ->capture_default_str();
  app
    .add_option("--memory", texts.MemoryMebibytes,
      "MiB that a rank may use, without the memory of VTK's readers")
    ->check(CLI::Range(std::uint64_t{ 1 }, std::uint64_t{ 1 } << 30))
    ->capture_default_str();
  app.add_option("--arrays", texts.Arrays,
    "Names of the arrays to write, A,B,...; the first one decides the distribution.\n"
    "Default: all numeric point arrays, with any number of components");
  app.add_flag("--in-place", options.IsInPlace,
    "Write no samples at full resolution: queries decode those of IN, which has to stay. For\n"
    "all formats but gzip streams and those of VTK's readers");
  app.add_option("--region", texts.Region,
    "X0,X1,Y0,Y1,Z0,Z1 in the world: only the part of IN that has this box, in whole chunks");
  app
    .add_option("--fetch-budget", options.FetchBudget,
      "MiB that may be fetched of an IN at an address, for all time steps and ranks; 0: no limit")
    ->check(CLI::Range(std::uint64_t{ 0 }, std::uint64_t{ 1 } << 40));
  app.add_flag("--cells", options.WithCells, "Write cell arrays, too, averaged to points");
  app.add_flag("--append", settings.Append,
    "Add IN to the time steps of OUT.bvol; it must have the same grid, arrays and options");
  app.add_option("--time", settings.Time, "The time of the time step, instead of that of IN");
  app.option_defaults()->group("General");
  app
    .add_option(
      "--threads", settings.Threads, "Threads of a rank; 0: its share of the node's cores")
    ->check(CLI::Range(0, 4096))
    ->capture_default_str();
  app
    .add_option("--cache", texts.CacheMebibytes,
      "MiB of what is fetched from addresses that stay on disk; 0: none. Default: 4096, or what\n"
      "$SCALABLE_ISOSURFACE_CACHE_BYTES says")
    ->check(CLI::Range(std::uint64_t{ 0 }, std::uint64_t{ 1 } << 40));
  app.add_option("--endpoint", texts.Endpoint,
    "URL of the server of s3:// addresses. Default: $AWS_ENDPOINT_URL, or Amazon's");
  app.add_flag("--quiet", options.IsQuiet, "No progress and no summary, only errors");
}

void AddDatasetOptions(CLI::App& app, RawTexts& texts, BlockVolumeOptions& options)
{
  app.option_defaults()->group("Files of several volumes (HDF5, NetCDF, Zarr, DICOM)");
  app.add_flag("--list", texts.IsList, "Print what is in IN: names, samples on each axis, types");
  app.add_option("--axes", options.Axes,
    "What the axes of a dataset are, the slowest first, of the letters x y z t c.\n"
    "Default: as the file says; otherwise zyx, tzyx or tczyx. Channels (c) are components if\n"
    "they come last, otherwise arrays");
  app.add_option("--step", options.Step, "Write this time step of IN, counted from 0, not all");
}

void AddInputOptions(CLI::App& app, RawTexts& texts)
{
  app.option_defaults()->group("Geometry, instead of that of IN");
  app.add_option("--spacing", texts.Spacing, "Distances between samples, X,Y,Z");
  app.add_option("--origin", texts.Origin, "Position of sample (0, 0, 0), X,Y,Z");
  app.add_option("--unit", texts.Unit, "Unit of both: m, cm, mm, um, nm, angstrom, inch, ...");
  app.option_defaults()->group("Samples without a header (x fastest, one array)");
  app.add_option("--dimensions", texts.Dimensions, "Number of samples, X,Y,Z");
  app.add_option("--type", texts.Type, ListEnumerators(GetValueTypeName, " "))
    ->capture_default_str();
  app.add_option("--header-bytes", texts.HeaderBytes, "Bytes before the samples")
    ->capture_default_str();
  app.add_flag("--big-endian", texts.IsBigEndian, "The high byte of a sample comes first");
  app.add_flag(
    "--gzip", texts.IsGzip, "The samples after the header bytes are a gzip or zlib stream");
  app.add_option("--name", texts.Name, "Name of the array")->capture_default_str();
}

void AddSourceOptions(CLI::App& app, BlockVolumeOptions& options)
{
  app.option_defaults()->group("Volumes in place");
  app
    .add_option("--source", options.Source,
      "Write nothing, but tell IN.bvol, which was written in place, where its IN is now")
    ->excludes("--list");
}

void AddSandboxOptions(CLI::App& app, RawTexts& texts, BlockVolumeOptions& options)
{
  app.option_defaults()->group("Files of strangers");
  CLI::Option* sandbox = app.add_flag("--sandbox", options.IsSandboxed,
    "Work in a process of its own, with limits: what crashes a library that reads IN, loops or "
    "takes\n"
    "all memory is an error. One process, no mpirun");
  app
    .add_option("--sandbox-memory", texts.SandboxMebibytes,
      "MiB of address space of that process, besides --memory")
    ->check(CLI::Range(std::uint64_t{ 1 }, std::uint64_t{ 1 } << 30))
    ->capture_default_str()
    ->needs(sandbox);
  app
    .add_option("--sandbox-seconds", options.SandboxSeconds,
      "Seconds of processor time that it may take without progress")
    ->check(CLI::Range(std::uint64_t{ 1 }, std::uint64_t{ 1 } << 30))
    ->capture_default_str()
    ->needs(sandbox);
}

void AddInspectingOptions(CLI::App& app, RawTexts& texts, BlockVolumeOptions& options)
{
  app.option_defaults()->group("Inspecting a blocked volume");
  CLI::Option* info = app
                        .add_flag("--info", texts.IsInfo,
                          "Print grid, arrays, time steps, stores, compression, balance and "
                          "contour spectrum of IN.bvol")
                        ->excludes("--list")
                        ->excludes("--source");
  app.add_flag("--json", options.IsJson, "... as JSON")->needs(info);
  app
    .add_flag("--spectrum", options.WithSpectrum,
      "... with the contour spectrum at all isovalues: triangles, active cells, active blocks, "
      "bytes, area, volume")
    ->needs(info);
  app
    .add_flag("--verify", texts.IsVerify,
      "Read all of IN.bvol, check every checksum and decode every block; print every fault")
    ->excludes(info)
    ->excludes("--list")
    ->excludes("--source");
  app
    .add_flag("--repair", texts.IsRepair,
      "Restore lost and damaged stores of IN.bvol from the other stores that have their blocks, if "
      "it\n"
      "was written with --replicas; print what cannot be restored")
    ->excludes(info)
    ->excludes("--verify")
    ->excludes("--list")
    ->excludes("--source");
}

Result<RawVolume> MakeRaw(const RawTexts& texts, const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto dimensions, ParseThree("--dimensions", texts.Dimensions));
  RawVolume raw;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double size = dimensions[axis];
    if (size < 1 || size > 2147483647 || size != static_cast<double>(static_cast<long>(size)))
    {
      return MakeError("--dimensions",
        "\"" + texts.Dimensions + "\": not three whole numbers from 1 to 2147483647");
    }
    raw.Grid.Extent[2 * axis] = 0;
    raw.Grid.Extent[2 * axis + 1] = static_cast<std::int64_t>(size) - 1;
  }
  const auto type = FindValueType(texts.Type);
  if (!type)
  {
    return MakeError(
      "--type", "\"" + texts.Type + "\": none of " + ListEnumerators(GetValueTypeName, ", "));
  }
  if (texts.Name.empty())
  {
    return MakeError("--name", "an array needs a name");
  }
  raw.Type = *type;
  raw.ArrayName = texts.Name;
  raw.IsBigEndian = texts.IsBigEndian;
  raw.IsGzip = texts.IsGzip;
  raw.Offset = texts.HeaderBytes;
  raw.Paths = { path };
  return raw;
}

Status TakeTexts(const RawTexts& texts, BlockVolumeOptions& options)
{
  if (!IsBlockSize(options.Settings.BlockSize))
  {
    return MakeError(
      "--block-size", std::to_string(options.Settings.BlockSize) + " is neither 16, 32 nor 64");
  }
  const auto distribution = FindDistribution(texts.Distribution);
  if (!distribution)
  {
    return MakeError("--distribution",
      "\"" + texts.Distribution + "\": neither greedy, balanced, random nor slab");
  }
  options.Settings.Distribution = *distribution;
  ISOSURFACE_ASSIGN_OR_RETURN(options.Settings.Compression, ParseCompression(texts.Compression));
  options.Settings.MemoryLimit = texts.MemoryMebibytes << 20;
  options.SandboxMemory = (texts.MemoryMebibytes + texts.SandboxMebibytes) << 20;
  // Whatever opens an address looks there.
  if (texts.CacheMebibytes)
  {
    const std::string bytes = std::to_string(*texts.CacheMebibytes << 20);
    ::setenv("SCALABLE_ISOSURFACE_CACHE_BYTES", bytes.c_str(), 1); // NOLINT(concurrency-mt-unsafe)
  }
  if (!texts.Endpoint.empty())
  {
    ::setenv("AWS_ENDPOINT_URL_S3", texts.Endpoint.c_str(), 1); // NOLINT(concurrency-mt-unsafe)
  }
  if (!texts.Arrays.empty())
  {
    options.Arrays = SplitAtCommas(texts.Arrays);
  }
  for (std::size_t index = 0; index < options.Arrays.size(); ++index)
  {
    const auto begin = options.Arrays.begin();
    const auto at = begin + static_cast<std::ptrdiff_t>(index);
    if (at->empty() || std::find(begin, at, *at) != at)
    {
      return MakeError("--arrays", "\"" + texts.Arrays + "\" has an empty name, or one twice");
    }
  }
  using Triple = std::optional<std::array<double, 3>>;
  for (const auto& [option, text, to] : { std::tuple<const char*, const std::string*, Triple*>{
                                            "--spacing", &texts.Spacing, &options.Spacing },
         { "--origin", &texts.Origin, &options.Origin } })
  {
    if (!text->empty())
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto values, ParseThree(option, *text));
      *to = values;
    }
  }
  if (!texts.Region.empty())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      options.Region, ParseNumbers<6>("--region", texts.Region, "X0,X1,Y0,Y1,Z0,Z1"));
  }
  options.Unit = FindLengthUnit(texts.Unit);
  if (options.Unit == LengthUnit::Unknown && !texts.Unit.empty())
  {
    return MakeError("--unit", "\"" + texts.Unit + "\" is no unit of length, as m, mm, um or inch");
  }
  if (!texts.Dimensions.empty())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(options.Raw, MakeRaw(texts, options.Input));
  }
  return Status::Ok();
}

Status CheckNames(const CLI::App& app, BlockVolumeOptions& options)
{
  const bool isWriting = options.What == BlockVolumeOptions::Command::Write;
  if (options.Input.empty() || (isWriting && options.Output.empty()))
  {
    return Status(StatusCode::InvalidArgument,
      isWriting ? "IN and OUT.bvol are needed (--help tells more)"
        : options.What == BlockVolumeOptions::Command::List ? "IN is needed"
                                                            : "IN.bvol is needed");
  }
  if (!isWriting && !options.Output.empty())
  {
    return MakeError(options.Output, "only one file at a time can be inspected");
  }
  const std::string end = ".bvol";
  if (isWriting &&
    (options.Output.size() <= end.size() ||
      options.Output.compare(options.Output.size() - end.size(), end.size(), end) != 0))
  {
    return MakeError(options.Output, "the name of a blocked volume ends in .bvol");
  }
  if (options.IsInPlace && app.count("--dimensions") > 0)
  {
    return MakeError("--in-place",
      "needs a name that says what the samples are, as in ct.raw:512x512x300,uint16; a MetaImage "
      "header (.mhd) does, too");
  }
  for (const char* option : { "--type", "--header-bytes", "--big-endian", "--gzip", "--name" })
  {
    if (app.count(option) > 0 && app.count("--dimensions") == 0)
    {
      return MakeError(option, "needs --dimensions: it is for samples without a header");
    }
  }
  return Status::Ok();
}

} // namespace

Result<BlockVolumeOptions> BlockVolumeOptions::Parse(int argc, const char* const* argv)
{
  BlockVolumeOptions options;
  RawTexts texts;
  CLI::App app(Description, "blockvolume");
  app.footer(Footer);
  app.set_version_flag("--version", std::string("blockvolume " ISOSURFACE_VERSION))
    ->group("General");
  app.get_help_ptr()->group("General");
  app.add_option(
    "IN", options.Input, "The volume to read; with --info, --verify, --repair: IN.bvol");
  app.add_option("OUT", options.Output, "The blocked volume to write, OUT.bvol");
  std::string completed;
  app.add_option("--values-of", completed)->group(""); // for completion.bash
  AddWritingOptions(app, texts, options);
  AddDatasetOptions(app, texts, options);
  AddInputOptions(app, texts);
  AddSourceOptions(app, options);
  AddSandboxOptions(app, texts, options);
  AddInspectingOptions(app, texts, options);
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::CallForHelp&)
  {
    options.What = Command::Print;
    options.Text = app.help();
    return options;
  }
  catch (const CLI::CallForVersion& version)
  {
    options.What = Command::Print;
    options.Text = std::string(version.what()) + "\n";
    return options;
  }
  catch (const CLI::ParseError& error)
  {
    return Status(StatusCode::InvalidArgument, error.what());
  }
  if (!completed.empty())
  {
    options.What = Command::Print;
    options.Text = ListValues(completed) + "\n";
    return options;
  }
  options.What = texts.IsInfo ? Command::Info
    : texts.IsVerify          ? Command::Verify
    : texts.IsRepair          ? Command::Repair
    : texts.IsList            ? Command::List
    : !options.Source.empty() ? Command::Relocate
                              : Command::Write;
  if (options.IsInPlace && app.count("--distribution") == 0)
  {
    texts.Distribution = "slab";
  }
  ISOSURFACE_RETURN_IF_ERROR(CheckNames(app, options));
  ISOSURFACE_RETURN_IF_ERROR(TakeTexts(texts, options));
  return options;
}

} // namespace isosurface
