// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SpectraFile_h
#define isosurface_SpectraFile_h

#include "Ground/Base/Coding.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/GridPlace.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * Appends a curve of counts in few bytes: the differences from one count to the next (of the first
 * one from 0), modulo 2^64, as signed varints (Coding.h). After a difference of 0 follows a varint:
 * the number of further zeros, which are omitted.
 */
void AppendPackedCounts(const std::vector<std::uint64_t>& counts, std::vector<std::uint8_t>& bytes);

/// Reads counts.size() counts; false if there are fewer, or a number does not fit.
bool ReadPackedCounts(ByteReader& reader, std::vector<std::uint64_t>& counts);

/**
 * The file `spectra` of a time step: the spectra of the whole volume and of each store, each of
 * which can be read alone. Little-endian, without alignment:
 *
 *     +------+--------------------------------------+    section s (from end s - 1 to end s)
 *     |    0 | "ISOSPECT"                 (8 bytes) |    +---+------------------------------+
 *     |    8 | format version 1            (uint32) |    | 0 | checksum of the rest,        |
 *     |   12 | number of variables A       (uint32) |    |   | seeded by s         (uint64) |
 *     |   16 | number of stores D          (uint64) |    | 8 | triangles                    |
 *     |   24 | identity of the time step   (uint64) |    |   | active cells                 |
 *     |   32 | per variable: first edge     (int64) |    |   | active blocks                |
 *     |      |   exponent                   (int32) |    |   | bytes                        |
 *     |      |   number of bins n          (uint32) |    |   | area, in units               |
 *     |      |   unit of area             (float64) |    |   | volume, in units             |
 *     |      |   unit of volume           (float64) |    +---+------------------------------+
 *     | 32 + | per section: its end in              |
 *     | 32 A |   the file, A (D + 1) times (uint64) |    n counts each, as AppendPackedCounts has
 *     |      | checksum of all above       (uint64) |    them
 *     |      | the sections                         |
 *     +------+--------------------------------------+
 *
 * Section a is that of variable a in the whole volume, section A (d + 1) + a that in store d.
 */
class SpectraFile
{
public:
  using Section = std::vector<std::uint8_t>;

  /// The counts of a spectrum: a section without its checksum.
  static Section Pack(const WorkloadSpectrum& spectrum);

  /// Writes the file: totals[variable], stores[variable + A * store]. `identity`: that of the time
  /// step whose spectra they are.
  static Status Write(FileSystem& files, const std::string& path, std::uint64_t identity,
    const std::vector<WorkloadSpectrum>& totals, const std::vector<Section>& stores);

  /// Reads all but the sections. Corrupt if the file has other numbers of variables or stores, or
  /// another identity; Unsupported if it is of a newer version.
  static Result<std::unique_ptr<SpectraFile>> Open(FileSystem& files, const std::string& path,
    std::uint64_t identity, std::size_t variables, std::size_t stores);

  /// Each by one read. The path must still lead to the same file.
  Result<WorkloadSpectrum> ReadTotal(std::size_t variable) const
  {
    return this->Read(variable, variable);
  }
  Result<WorkloadSpectrum> ReadStore(std::size_t variable, std::size_t store) const
  {
    return this->Read(variable, (store + 1) * this->Empty.size() + variable);
  }

private:
  SpectraFile(FileSystem& files, std::string path)
    : Files(files)
    , Path(std::move(path))
  {
  }
  Status ParseHeader(const std::vector<std::uint8_t>& header, std::uint64_t fileSize);
  Status Fail(StatusCode code, const std::string& reason) const
  {
    return Status(code, this->Path + ": " + reason);
  }
  Result<WorkloadSpectrum> Read(std::size_t variable, std::size_t section) const;

  FileSystem& Files;
  std::string Path;
  std::vector<WorkloadSpectrum> Empty; ///< per variable: bins and units
  std::vector<std::uint64_t> Ends;     ///< of the header and of each section
};

/**
 * The spectra of one time step: of the whole volume, and of each store, which add up to the whole.
 * They are in a file of their own, `spectra` in the time step's folder, so that the header stays
 * small with many stores and time steps.
 */
class VolumeSpectra
{
public:
  using Spectrum = std::shared_ptr<const WorkloadSpectrum>;

  /// The file of a time step.
  static std::string GetPath(
    FileSystem& files, const std::string& volumePath, const std::string& generation);

  /// What the file has in its header: it belongs to these stores, whose checksums are known.
  static std::uint64_t GetIdentity(const TimeStepDescription& step);

  /// Reads the spectra of the whole volume from a time step's folder. `scale`: from the grid in the file
  /// to that of the volume; an area that it does not tell becomes unknown.
  static Result<std::shared_ptr<const VolumeSpectra>> Read(FileSystem& files,
    const std::string& volumePath, const TimeStepDescription& step, std::size_t variables,
    const GridScale& scale = {});

  const Spectrum& GetTotal(std::size_t variable) const { return this->Totals[variable]; }
  /// Reads the spectrum of a store.
  Result<Spectrum> GetStore(std::size_t variable, std::size_t store) const;

private:
  Spectrum Share(WorkloadSpectrum&& spectrum) const;

  std::unique_ptr<SpectraFile> File;
  GridScale Scale;
  std::vector<Spectrum> Totals; ///< per variable
};

} // namespace isosurface

#endif
