// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Meshes/PlyFile.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <limits>
#include <sstream>

namespace isosurface
{
namespace
{

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

} // namespace

Result<std::unique_ptr<MeshFile>> PlyFile::Create(
  FileSystem& files, std::unique_ptr<WritableFile> file, const Settings& settings)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto faces, files.CreateForWriting(settings.Partial + ".faces"));
  std::unique_ptr<PlyFile> mesh(new PlyFile(files, std::move(file), std::move(faces), settings));
  const std::string text = mesh->MakeHeader();
  ISOSURFACE_RETURN_IF_ERROR(mesh->File->Append(text.data(), text.size()));
  return std::unique_ptr<MeshFile>(std::move(mesh));
}

PlyFile::~PlyFile()
{
  const std::string path = this->Faces->GetPath();
  this->Faces.reset();
  static_cast<void>(this->Files.RemoveAll(path));
}

std::string PlyFile::MakeHeader() const
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

Status PlyFile::AppendNewPoints(const Mesh& mesh, const PointNumbers& numbers)
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

Status PlyFile::AppendTriangles(const Mesh& mesh, const PointNumbers& numbers)
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

Status PlyFile::Append(const Mesh& mesh, const PointNumbers& numbers)
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

Status PlyFile::Finish()
{
  const std::string faces = this->Faces->GetPath();
  ISOSURFACE_RETURN_IF_ERROR(this->Faces->SyncAndClose());
  ISOSURFACE_ASSIGN_OR_RETURN(const auto written, this->Files.OpenForReading(faces));
  ISOSURFACE_RETURN_IF_ERROR(Copy(*written, *this->File));
  const std::string text = this->MakeHeader();
  ISOSURFACE_RETURN_IF_ERROR(this->File->WriteAt(0, text.data(), text.size()));
  return this->File->SyncAndClose();
}

} // namespace isosurface
