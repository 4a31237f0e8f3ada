// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DicomSlice_h
#define isosurface_DicomSlice_h

#include "Formats/Dicom/DicomCompression.h"
#include "Formats/Source/ConvertedSource.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ValueType.h"
#include "Ground/Volume/Vector3.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// What the header of a DICOM file says about its image.
struct DicomSlice
{
  std::string Path;
  std::string Series; ///< instance UID
  std::string Description;
  std::string Modality;     ///< "CT"
  std::string SeriesNumber; ///< may be empty
  std::string Photometric;  ///< "MONOCHROME2"
  std::string Syntax;       ///< UID of the transfer syntax
  std::int64_t Rows = 0;
  std::int64_t Columns = 0;
  std::int64_t Frames = 1;
  int Channels = 1;
  ValueType Type = ValueType::UInt8; ///< as stored
  int BitsStored = 8;
  int LowBit = 0;                     ///< of a stored word, the lowest that is of the sample
  bool HasOverlay = false;            ///< whether an overlay is in other bits of the words
  std::optional<CompressedForm> Form; ///< of a compressed image, if its start tells
  int ValueBits = 8;                  ///< that samples may have
  SampleScale Scale;
  std::string Unit;          ///< of scaled samples: "HU", "BQML"; empty if the header tells none
  double WindowCenter = 0;   ///< of the first window of scaled samples
  double WindowWidth = 0;    ///< of that; 0: there is none
  bool HasPlace = false;     ///< whether the next four are in the header
  Vector3 Position{};        ///< of the first pixel, in millimetres: left, back, up
  double PositionUnit = 0;   ///< a step of the last digit of those, in millimetres
  Vector3 AlongRow{};        ///< unit vector from column to column
  Vector3 AlongColumn{};     ///< unit vector from row to row
  bool HasDistances = false; ///< whether the next two are in the header (Pixel Spacing)
  double RowDistance = 1;    ///< between rows
  double ColumnDistance = 1;
  double SliceDistance = 0; ///< SpacingBetweenSlices; 0: it is not in the header
  std::string Frame;        ///< UID of the Frame of Reference
  std::string ImageType;    ///< "ORIGINAL\PRIMARY\AXIAL"
  /// What may differ between images of one place: those of DicomSlice::MomentNames.
  std::array<std::string, 8> Moments;
  std::string Notes; ///< what of the header is not obeyed, for a message

  static const std::array<const char*, 8> MomentNames;

  bool IsSigned() const;

  /// Reads the header. NotFound if the file is no DICOM image; otherwise as the errors of files.
  /// `series` gets the UID as far as the header tells it, after an error, too; it may be null.
  static Result<DicomSlice> Read(const std::string& path, std::string* series = nullptr);

  /// Decodes the image, with any transfer syntax that GDCM supports. `to`: Rows * Columns samples of
  /// Type. May be called by several threads at once; those of compressed images wait for each other.
  /// Errors name the file: Corrupt; Unsupported if it is compressed and has 4 GiB, or if it has negative
  /// samples and its header says that it has none; those of the file.
  Status Decode(std::vector<std::uint8_t>& to) const;
};

} // namespace isosurface

#endif
