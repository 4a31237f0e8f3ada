// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Meshes/MeshFile.h"

#include "Coding/Meshes/GlbFile.h"
#include "Ground/Base/Coding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <sstream>

namespace isosurface
{
namespace
{

constexpr std::size_t TextSize = 80;
constexpr std::size_t TrianglesAtOnce = 65536;

using Vector = std::array<float, 3>;

/// The unit normal of a triangle, or 0 if it has no area.
Vector FindNormal(const float* a, const float* b, const float* c)
{
  double normal[3];
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::size_t second = (axis + 1) % 3;
    const std::size_t third = (axis + 2) % 3;
    normal[axis] = (double{ b[second] } - a[second]) * (double{ c[third] } - a[third]) -
      (double{ b[third] } - a[third]) * (double{ c[second] } - a[second]);
  }
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  Vector unit{};
  for (std::size_t axis = 0; axis < 3 && length > 0; ++axis)
  {
    unit[axis] = static_cast<float>(normal[axis] / length);
  }
  return unit;
}

/// The bytes of a triangle in the file; returns where they end.
std::uint8_t* StoreTriangle(const Mesh& mesh, const std::uint32_t* corners, std::uint8_t* to)
{
  const float* points[3];
  for (std::size_t corner = 0; corner < 3; ++corner)
  {
    points[corner] = mesh.Points + std::size_t{ 3 } * corners[corner];
  }
  const Vector normal = FindNormal(points[0], points[1], points[2]);
  for (const float* vector : { normal.data(), points[0], points[1], points[2] })
  {
    for (std::size_t axis = 0; axis < 3; ++axis, to += sizeof(float))
    {
      StoreLittleEndian(to, vector[axis]);
    }
  }
  StoreLittleEndian(to, std::uint16_t{ 0 });
  return to + sizeof(std::uint16_t);
}

/// Binary STL: a text of 80 bytes, the number of triangles, and 50 bytes for each, with its normal.
class StlFile : public MeshFile
{
public:
  static constexpr std::size_t TriangleSize = 50;

  static Result<std::unique_ptr<MeshFile>> Create(
    std::unique_ptr<WritableFile> file, const Settings& settings)
  {
    std::vector<std::uint8_t> head(TextSize + sizeof(std::uint32_t), std::uint8_t{ ' ' });
    // "solid" would say that it is text.
    const std::string text = settings.HasDoublePoints
      ? "Isosurface, from " + ToText(settings.Origin)
      : "Isosurface of an edge-index file";
    std::memcpy(head.data(), text.data(), std::min(text.size(), TextSize));
    ISOSURFACE_RETURN_IF_ERROR(file->Append(head.data(), head.size()));
    return std::unique_ptr<MeshFile>(new StlFile(std::move(file)));
  }

  Status Append(const Mesh& mesh, const PointNumbers&) override
  {
    this->NumberOfTriangles += mesh.NumberOfTriangles;
    if (this->NumberOfTriangles > std::numeric_limits<std::uint32_t>::max())
    {
      return Status(StatusCode::Unsupported,
        this->File->GetPath() +
          ": more triangles than the 4,294,967,295 that an .stl file can have");
    }
    std::vector<std::uint8_t> bytes(
      TriangleSize * std::min(TrianglesAtOnce, mesh.NumberOfTriangles));
    std::uint8_t* to = bytes.data();
    for (std::size_t triangle = 0; triangle < mesh.NumberOfTriangles; ++triangle)
    {
      to = StoreTriangle(mesh, mesh.Corners + 3 * triangle, to);
      if (to == bytes.data() + bytes.size() || triangle + 1 == mesh.NumberOfTriangles)
      {
        ISOSURFACE_RETURN_IF_ERROR(
          this->File->Append(bytes.data(), static_cast<std::size_t>(to - bytes.data())));
        to = bytes.data();
      }
    }
    return Status::Ok();
  }

  Status Finish() override
  {
    std::vector<std::uint8_t> count;
    AppendLittleEndian(count, static_cast<std::uint32_t>(this->NumberOfTriangles));
    ISOSURFACE_RETURN_IF_ERROR(this->File->WriteAt(TextSize, count.data(), count.size()));
    return this->File->SyncAndClose();
  }

private:
  explicit StlFile(std::unique_ptr<WritableFile> file)
    : File(std::move(file))
  {
  }

  std::unique_ptr<WritableFile> File;
  std::uint64_t NumberOfTriangles = 0;
};

constexpr std::size_t TextAtOnce = std::size_t{ 4 } << 20;

/// A line of three numbers, from which the same floats or doubles are read.
template <typename Real>
void AppendLine(const char* key, const Real* numbers, std::string& text)
{
  char line[96];
  std::snprintf(line, sizeof(line), "%s %.*g %.*g %.*g\n", key,
    std::numeric_limits<Real>::max_digits10, static_cast<double>(numbers[0]),
    std::numeric_limits<Real>::max_digits10, static_cast<double>(numbers[1]),
    std::numeric_limits<Real>::max_digits10, static_cast<double>(numbers[2]));
  text += line;
}

/// Wavefront OBJ, as text: points with their normals, each once, and triangles, in a group for each
/// isovalue.
class ObjFile : public MeshFile
{
public:
  static std::uint64_t EstimateBytes(const Settings& settings)
  {
    constexpr std::uint64_t lineOfPoint = 34;
    constexpr std::uint64_t lineOfTriangle = 28;
    const std::uint64_t lines = settings.HasNormals ? 2 : 1;
    return lines * (lineOfPoint * settings.Points + lineOfTriangle * settings.Triangles);
  }

  static Result<std::unique_ptr<MeshFile>> Create(
    std::unique_ptr<WritableFile> file, const EdgeIndexHeader& header, const Settings& settings)
  {
    const std::string text = "# Isosurface of an edge-index file\n";
    ISOSURFACE_RETURN_IF_ERROR(file->Append(text.data(), text.size()));
    return std::unique_ptr<MeshFile>(new ObjFile(std::move(file), header, settings.HasNormals));
  }

  Status Append(const Mesh& mesh, const PointNumbers& numbers) override
  {
    std::string text;
    for (std::size_t point = 0; point < mesh.NumberOfPoints; ++point)
    {
      if (numbers.Values[point] < numbers.First)
      {
        continue;
      }
      if (mesh.DoublePoints)
      {
        AppendLine("v", mesh.DoublePoints + 3 * point, text);
      }
      else
      {
        AppendLine("v", mesh.Points + 3 * point, text);
      }
      if (this->HasNormals)
      {
        AppendLine("vn", mesh.Normals + 3 * point, text);
      }
      ISOSURFACE_RETURN_IF_ERROR(this->WriteIfMany(text));
    }
    std::ostringstream group;
    group << "g isovalue_" << this->Header.Isovalues[mesh.Isovalue] << "\n";
    text += group.str();
    for (std::size_t triangle = 0; triangle < mesh.NumberOfTriangles; ++triangle)
    {
      text += "f";
      for (std::size_t corner = 0; corner < 3; ++corner)
      {
        const std::string number =
          std::to_string(numbers.Values[mesh.Corners[3 * triangle + corner]] + 1);
        text += " " + (this->HasNormals ? number + "//" + number : number);
      }
      text += "\n";
      ISOSURFACE_RETURN_IF_ERROR(this->WriteIfMany(text));
    }
    return this->File->Append(text.data(), text.size());
  }

  Status Finish() override { return this->File->SyncAndClose(); }

private:
  ObjFile(std::unique_ptr<WritableFile> file, const EdgeIndexHeader& header, bool hasNormals)
    : File(std::move(file))
    , Header(header)
    , HasNormals(hasNormals)
  {
  }

  Status WriteIfMany(std::string& text)
  {
    Status status;
    if (text.size() >= TextAtOnce)
    {
      status = this->File->Append(text.data(), text.size());
      text.clear();
    }
    return status;
  }

  std::unique_ptr<WritableFile> File;
  const EdgeIndexHeader& Header;
  bool HasNormals;
};

constexpr std::size_t PlyHeaderSize = 512; ///< room for any numbers of points and triangles
constexpr std::size_t BytesAtOnce = std::size_t{ 4 } << 20;

/// Gathers bytes into larger pieces of a file.
class Gatherer
{
public:
  explicit Gatherer(WritableFile& file)
    : File(file)
  {
    this->Bytes.reserve(BytesAtOnce + 64);
  }
  std::vector<std::uint8_t>& GetBytes() { return this->Bytes; }
  Status WriteIfMany() { return this->Bytes.size() < BytesAtOnce ? Status::Ok() : this->Write(); }
  Status Write()
  {
    Status status = this->File.Append(this->Bytes.data(), this->Bytes.size());
    this->Bytes.clear();
    return status;
  }

private:
  WritableFile& File;
  std::vector<std::uint8_t> Bytes;
};

template <typename Real>
void AppendVector(const Real* vector, std::vector<std::uint8_t>& bytes)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    AppendLittleEndian(bytes, vector[axis]);
  }
}

Status Copy(const RandomAccessFile& from, WritableFile& to)
{
  std::vector<std::uint8_t> bytes;
  for (std::uint64_t offset = 0; offset < from.GetSize(); offset += bytes.size())
  {
    bytes.resize(
      static_cast<std::size_t>(std::min<std::uint64_t>(BytesAtOnce, from.GetSize() - offset)));
    ISOSURFACE_RETURN_IF_ERROR(from.Read(offset, bytes.size(), bytes.data()));
    ISOSURFACE_RETURN_IF_ERROR(to.Append(bytes.data(), bytes.size()));
  }
  return Status::Ok();
}

/**
 * Binary PLY, little-endian: points with their normals, each once, then triangles. Triangles go to a
 * second file first, PATH.faces, which is appended at the end.
 */
class PlyFile : public MeshFile
{
public:
  static Result<std::unique_ptr<MeshFile>> Create(
    FileSystem& files, std::unique_ptr<WritableFile> file, const Settings& settings)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto faces, files.CreateForWriting(settings.Partial + ".faces"));
    std::unique_ptr<PlyFile> mesh(new PlyFile(files, std::move(file), std::move(faces), settings));
    const std::string text = mesh->MakeHeader();
    ISOSURFACE_RETURN_IF_ERROR(mesh->File->Append(text.data(), text.size()));
    return std::unique_ptr<MeshFile>(std::move(mesh));
  }

  ~PlyFile() override
  {
    const std::string path = this->Faces->GetPath();
    this->Faces.reset();
    static_cast<void>(this->Files.RemoveAll(path));
  }

  Status Append(const Mesh& mesh, const PointNumbers& numbers) override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->AppendNewPoints(mesh, numbers));
    if (this->NumberOfPoints > std::numeric_limits<std::uint32_t>::max())
    {
      return Status(StatusCode::Unsupported,
        this->File->GetPath() + ": more points than the 4,294,967,295 that a .ply file can number");
    }
    this->NumberOfTriangles += mesh.NumberOfTriangles;
    return this->AppendTriangles(mesh, numbers);
  }

  Status Finish() override
  {
    const std::string faces = this->Faces->GetPath();
    ISOSURFACE_RETURN_IF_ERROR(this->Faces->SyncAndClose());
    ISOSURFACE_ASSIGN_OR_RETURN(const auto written, this->Files.OpenForReading(faces));
    ISOSURFACE_RETURN_IF_ERROR(Copy(*written, *this->File));
    const std::string text = this->MakeHeader();
    ISOSURFACE_RETURN_IF_ERROR(this->File->WriteAt(0, text.data(), text.size()));
    return this->File->SyncAndClose();
  }

private:
  PlyFile(FileSystem& files, std::unique_ptr<WritableFile> file,
    std::unique_ptr<WritableFile> faces, const Settings& settings)
    : Files(files)
    , File(std::move(file))
    , Faces(std::move(faces))
    , HasNormals(settings.HasNormals)
    , HasDoublePoints(settings.HasDoublePoints)
  {
  }

  std::string MakeHeader() const
  {
    const bool isWide = this->NumberOfPoints > std::numeric_limits<std::int32_t>::max();
    std::ostringstream text;
    text << "element vertex " << this->NumberOfPoints << "\n";
    for (const char* name : { "x", "y", "z" })
    {
      text << "property " << (this->HasDoublePoints ? "double " : "float ") << name << "\n";
    }
    text << (this->HasNormals ? "property float nx\nproperty float ny\nproperty float nz\n" : "");
    text << "element face " << this->NumberOfTriangles << "\nproperty list uchar "
         << (isWide ? "uint" : "int") << " vertex_indices\nend_header\n";
    std::string head =
      "ply\nformat binary_little_endian 1.0\ncomment Isosurface of an edge-index file";
    head.resize(PlyHeaderSize - text.str().size() - 1, ' ');
    return head + "\n" + text.str();
  }

  Status AppendNewPoints(const Mesh& mesh, const PointNumbers& numbers)
  {
    Gatherer gatherer(*this->File);
    for (std::size_t point = 0; point < mesh.NumberOfPoints; ++point)
    {
      if (numbers.Values[point] >= numbers.First)
      {
        ++this->NumberOfPoints;
        if (this->HasDoublePoints)
        {
          AppendVector(mesh.DoublePoints + 3 * point, gatherer.GetBytes());
        }
        else
        {
          AppendVector(mesh.Points + 3 * point, gatherer.GetBytes());
        }
        if (this->HasNormals)
        {
          AppendVector(mesh.Normals + 3 * point, gatherer.GetBytes());
        }
        ISOSURFACE_RETURN_IF_ERROR(gatherer.WriteIfMany());
      }
    }
    return gatherer.Write();
  }

  Status AppendTriangles(const Mesh& mesh, const PointNumbers& numbers)
  {
    Gatherer gatherer(*this->Faces);
    for (std::size_t triangle = 0; triangle < mesh.NumberOfTriangles; ++triangle)
    {
      gatherer.GetBytes().push_back(3);
      for (std::size_t corner = 0; corner < 3; ++corner)
      {
        AppendLittleEndian(gatherer.GetBytes(),
          static_cast<std::uint32_t>(numbers.Values[mesh.Corners[3 * triangle + corner]]));
      }
      ISOSURFACE_RETURN_IF_ERROR(gatherer.WriteIfMany());
    }
    return gatherer.Write();
  }

  FileSystem& Files;
  std::unique_ptr<WritableFile> File;
  std::unique_ptr<WritableFile> Faces;
  bool HasNormals;
  bool HasDoublePoints;
  std::uint64_t NumberOfPoints = 0;
  std::uint64_t NumberOfTriangles = 0;
};

bool EndsIn(const std::string& path, const std::string& ending)
{
  return path.size() > ending.size() &&
    path.compare(path.size() - ending.size(), ending.size(), ending) == 0;
}

} // namespace

std::string ToText(const Vector3& place)
{
  std::ostringstream text;
  text.precision(std::numeric_limits<double>::digits10);
  text << place[0] << " " << place[1] << " " << place[2];
  return text.str();
}

bool MeshFile::Knows(const std::string& path)
{
  return EndsIn(path, ".stl") || EndsIn(path, ".ply") || EndsIn(path, ".glb") ||
    EndsIn(path, ".obj");
}

std::uint64_t MeshFile::EstimateBytes(const Settings& settings)
{
  constexpr std::uint64_t cornersBytes = 3 * sizeof(std::uint32_t);
  if (EndsIn(settings.Path, ".stl"))
  {
    return StlFile::TriangleSize * settings.Triangles;
  }
  if (EndsIn(settings.Path, ".obj"))
  {
    return ObjFile::EstimateBytes(settings);
  }
  const bool isDouble = settings.HasDoublePoints && EndsIn(settings.Path, ".ply");
  const std::uint64_t pointBytes =
    3 * ((settings.HasNormals ? sizeof(float) : 0) + (isDouble ? sizeof(double) : sizeof(float)));
  return pointBytes * settings.Points + cornersBytes * settings.Triangles +
    (EndsIn(settings.Path, ".ply") ? settings.Triangles : 0);
}

Status MeshFile::CheckLimits(const Settings& settings)
{
  constexpr double limit = 4294967296.0;
  // Points on the faces of blocks are counted twice, and not all have two triangles.
  constexpr double certain = 0.8;
  const auto isBeyond = [](std::uint64_t estimate)
  { return certain * static_cast<double>(estimate) > limit; };
  const auto refuse = [&settings](std::uint64_t estimate, const char* most)
  {
    return Status(StatusCode::Unsupported,
      settings.Path + ": would have about " + std::to_string(estimate) + " " + most +
        ". Take another format, or fewer triangles (--triangles)");
  };
  if (EndsIn(settings.Path, ".stl") && isBeyond(settings.Triangles))
  {
    return refuse(settings.Triangles, "triangles; an .stl file has at most 4,294,967,295");
  }
  if (EndsIn(settings.Path, ".ply") && isBeyond(settings.Points))
  {
    return refuse(settings.Points, "points; a .ply file has at most 4,294,967,295");
  }
  const std::uint64_t bytes = EstimateBytes(settings);
  return EndsIn(settings.Path, ".glb") && !settings.Compression && isBeyond(bytes)
    ? refuse(bytes >> 20, "MiB; a .glb file has at most 4096 MiB, and --compress makes it smaller")
    : Status::Ok();
}

Result<std::unique_ptr<MeshFile>> MeshFile::Create(
  FileSystem& files, const EdgeIndexHeader& header, const Settings& settings)
{
  ISOSURFACE_RETURN_IF_ERROR(CheckLimits(settings));
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.CreateForWriting(settings.Partial));
  if (EndsIn(settings.Path, ".stl"))
  {
    return StlFile::Create(std::move(file), settings);
  }
  if (EndsIn(settings.Path, ".ply"))
  {
    return PlyFile::Create(files, std::move(file), settings);
  }
  if (EndsIn(settings.Path, ".obj"))
  {
    return ObjFile::Create(std::move(file), header, settings);
  }
  return CreateGlbFile(std::move(file), header, settings);
}

} // namespace isosurface
