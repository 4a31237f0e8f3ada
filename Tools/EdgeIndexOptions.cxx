// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndexOptions.h"

#include <CLI/CLI.hpp>

namespace isosurface
{
namespace
{

constexpr const char* Description =
  "Prints the contents of an edge-index file (.eix), checks one, or decodes one to triangles.";

constexpr const char* Footer = R"(Formats of OUT, by its file extension:
  .ply .stl           binary
  .glb                binary glTF 2.0, a mesh for each isovalue, in metres and with y up
  .obj                text, a group for each isovalue
  .vtp                with GlobalIds, isovalues, arrays and normals

Examples:
  edgeindex info skull.eix --json
  edgeindex verify skull.eix
  edgeindex decode skull.eix skull.ply
  edgeindex decode skull.eix coarse.stl --preview
  edgeindex decode skull.eix skull.glb --triangles 2e6 --compress

The triangles of all blocks share their points, so the surface is watertight. (In .stl and .glb, points in
one place have equal coordinates.) All but .vtp are written piece by piece within --memory, however large
the surface; .vtp needs memory for all of it. Triangles with a point that is not a number are left out. Of a
truncated file the complete blocks are decoded, with a warning. Exit status: 0 for success, 1 for an error or a fault
found, 130 if the command was interrupted. OUT appears in one step at the end.)";

} // namespace

Result<EdgeIndexOptions> EdgeIndexOptions::Parse(int argc, const char* const* argv)
{
  EdgeIndexOptions options;
  CLI::App app(Description, "edgeindex");
  app.footer(Footer);
  app.set_version_flag("--version", std::string("edgeindex " ISOSURFACE_VERSION));
  app.require_subcommand(1);
  const auto addCommand = [&](const char* name, const char* description)
  {
    CLI::App* command = app.add_subcommand(name, description);
    command->add_option("FILE", options.Input, "The edge-index file, FILE.eix")->required();
    return command;
  };
  double triangles = 0;
  CLI::App* info = addCommand("info", "Print the contents of a file");
  info->add_flag("--json", options.IsJson, "As one JSON object");
  CLI::App* verify = addCommand("verify", "Decode the whole file, to find any fault");
  CLI::App* decode = addCommand("decode", "Write the triangles to OUT, or only count them");
  decode->add_option("OUT", options.Output, "OUT.ply, .stl, .glb, .vtp or .obj");
  decode->add_flag("--preview", options.IsPreview, "Only the coarse surface of the file");
  decode
    ->add_option("--triangles", triangles,
      "Simplify to about this number of triangles, in pieces whose borders are kept; 0: keep all")
    ->check(CLI::Range(0.0, 1e15))
    // Range takes NaN.
    ->check([](const std::string& text)
      { return text.find_first_of("nN") == std::string::npos ? "" : text + " is not a number"; });
  decode->add_flag(
    "--compress", options.IsCompressed, "Of a .glb: by meshoptimizer, with normals of 8 bits");
  decode->add_option(
    "--isovalue", options.Isovalue, "Only the surface of this isovalue of the file");
  std::string unit;
  decode->add_option("--unit", unit,
    "Of a .glb, which is in metres: the unit of the points, as m, mm or um, instead of that of the "
    "file; mm if neither tells");
  decode
    ->add_option(
      "--memory", options.MemoryMebibytes, "MiB to use, but for .vtp; a row of blocks must fit")
    ->check(CLI::Range(std::uint64_t{ 1 }, std::uint64_t{ 1 } << 30))
    ->capture_default_str();
  for (CLI::App* command : { verify, decode })
  {
    command->add_option("--threads", options.Threads, "Threads; 0: all cores")
      ->check(CLI::Range(0, 4096));
    command->add_flag("--quiet", options.IsQuiet, "Print only errors");
  }
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::CallForHelp&)
  {
    options.Text = app.help();
    return options;
  }
  catch (const CLI::CallForVersion& version)
  {
    options.Text = std::string(version.what()) + "\n";
    return options;
  }
  catch (const CLI::ParseError& error)
  {
    return Status(StatusCode::InvalidArgument, std::string(error.what()) + " (--help tells more)");
  }
  options.Unit = FindLengthUnit(unit);
  if (options.Unit == LengthUnit::Unknown && !unit.empty())
  {
    return Status(StatusCode::InvalidArgument,
      "--unit: \"" + unit + "\" is no unit of length, as m, mm, um or inch");
  }
  options.NumberOfTriangles = static_cast<std::uint64_t>(triangles);
  options.What = info->parsed() ? Command::Info
    : verify->parsed()          ? Command::Verify
                                : Command::Decode;
  return options;
}

} // namespace isosurface
