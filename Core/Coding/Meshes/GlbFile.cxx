// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Meshes/GlbFile.h"

#include "Ground/Base/Coding.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

namespace isosurface
{
namespace
{

constexpr std::size_t HeaderSize = 12;
constexpr std::size_t ChunkHeaderSize = 8;
constexpr std::uint32_t Magic = 0x46546C67;
constexpr std::uint32_t JsonChunk = 0x4E4F534A;
constexpr std::uint32_t BinaryChunk = 0x004E4942;

// Numbers of OpenGL.
constexpr int Byte = 5120;
constexpr int UnsignedInt = 5125;
constexpr int Float = 5126;
constexpr int ArrayBuffer = 34962;
constexpr int ElementArrayBuffer = 34963;
constexpr int Triangles = 4;

constexpr const char* CompressionName = "EXT_meshopt_compression";

/// Room for the JSON text: of what all files have, of an isovalue, of a mesh.
std::size_t FindJsonBytes(const EdgeIndexHeader& header, std::size_t meshes)
{
  const std::size_t name = 6 * header.Array.size() + 64;
  return 4 * ((2048 + header.Isovalues.size() * (name + 256) + meshes * 2048) / 4);
}

/// Makes a vector one of unit length. Returns whether it has a direction.
bool Normalize(float* vector)
{
  const auto x = static_cast<double>(vector[0]);
  const auto y = static_cast<double>(vector[1]);
  const auto z = static_cast<double>(vector[2]);
  const double length = std::hypot(x, y, z);
  if (!std::isfinite(length) || length == 0)
  {
    return false;
  }
  vector[0] = static_cast<float>(x / length);
  vector[1] = static_cast<float>(y / length);
  vector[2] = static_cast<float>(z / length);
  return true;
}

/// For each point the mean direction of its triangles, by their areas; along z if they have none.
std::vector<float> ComputeNormals(const Mesh& mesh)
{
  std::vector<float> normals(3 * mesh.NumberOfPoints, 0.0F);
  for (std::size_t triangle = 0; triangle < mesh.NumberOfTriangles; ++triangle)
  {
    const std::uint32_t* corners = mesh.Corners + 3 * triangle;
    const float* points[3];
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      points[corner] = mesh.Points + std::size_t{ 3 } * corners[corner];
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const std::size_t u = (axis + 1) % 3;
      const std::size_t v = (axis + 2) % 3;
      const float normal = (points[1][u] - points[0][u]) * (points[2][v] - points[0][v]) -
        (points[1][v] - points[0][v]) * (points[2][u] - points[0][u]);
      for (std::size_t corner = 0; corner < 3; ++corner)
      {
        normals[std::size_t{ 3 } * corners[corner] + axis] += normal;
      }
    }
  }
  for (std::size_t point = 0; point < mesh.NumberOfPoints; ++point)
  {
    float* normal = normals.data() + 3 * point;
    if (!Normalize(normal))
    {
      normal[0] = normal[1] = 0;
      normal[2] = 1;
    }
  }
  return normals;
}

/// The mesh's normals, with unit length.
std::vector<float> MakeUnitNormals(const Mesh& mesh)
{
  std::vector<float> normals(mesh.Normals, mesh.Normals + 3 * mesh.NumberOfPoints);
  std::vector<float> ofTriangles;
  for (std::size_t point = 0; point < mesh.NumberOfPoints; ++point)
  {
    if (!Normalize(normals.data() + 3 * point))
    {
      ofTriangles = ofTriangles.empty() ? ComputeNormals(mesh) : std::move(ofTriangles);
      std::copy_n(ofTriangles.data() + 3 * point, 3, normals.data() + 3 * point);
    }
  }
  return normals;
}

/**
 * Binary glTF 2.0: a mesh for each isovalue, with a primitive for each piece. Points where pieces meet
 * are in both, with equal coordinates. The JSON chunk comes before the samples and is known at the
 * end: it has room that is filled with blanks.
 *
 * glTF is in metres, with y up. So a node turns the isovalues' nodes, whose z is up, and scales them
 * from the unit of the points. It also moves them from their origin. Normals get unit length; where there is none, they are those of the
 * triangles.
 *
 * Compressed (EXT_meshopt_compression, KHR_mesh_quantization): points are exact, normals have 8 bits
 * in an octahedron, triangles come in another order.
 */
class GlbFile : public MeshFile
{
public:
  static Result<std::unique_ptr<MeshFile>> Create(
    std::unique_ptr<WritableFile> file, const EdgeIndexHeader& header, const Settings& settings)
  {
    std::unique_ptr<GlbFile> mesh(new GlbFile(std::move(file), header, settings));
    const std::vector<std::uint8_t> room(static_cast<std::size_t>(mesh->BinaryStart));
    ISOSURFACE_RETURN_IF_ERROR(mesh->File->Append(room.data(), room.size()));
    return std::unique_ptr<MeshFile>(std::move(mesh));
  }

  Status Append(const Mesh& given, const PointNumbers&) override
  {
    Mesh mesh = given;
    std::vector<float> normals;
    if (this->HasNormals)
    {
      normals = MakeUnitNormals(given);
      mesh.Normals = normals.data();
    }
    ISOSURFACE_RETURN_IF_ERROR(
      this->Compression ? this->AppendCompressed(mesh) : this->AppendPlain(mesh));
    this->AddPrimitive(mesh.Isovalue);
    return Status::Ok();
  }

  Status Finish() override
  {
    std::string json = this->MakeJson();
    if (json.size() > this->JsonBytes)
    {
      return Status(StatusCode::Unsupported,
        this->File->GetPath() + ": the surface has too many pieces; more --memory makes fewer");
    }
    json.resize(this->JsonBytes, ' ');
    std::vector<std::uint8_t> head;
    const auto append = [&head](std::uint64_t number)
    { AppendLittleEndian(head, static_cast<std::uint32_t>(number)); };
    append(Magic);
    append(2);
    append(this->File->GetSize());
    append(this->JsonBytes);
    append(JsonChunk);
    head.insert(head.end(), json.begin(), json.end());
    append(this->GetBinaryBytes());
    append(BinaryChunk);
    ISOSURFACE_RETURN_IF_ERROR(this->File->WriteAt(0, head.data(), head.size()));
    return this->File->SyncAndClose();
  }

private:
  using Json = nlohmann::ordered_json;
  /// An array of the file, as a reader sees it.
  struct View
  {
    const void* Bytes = nullptr;
    std::size_t Count = 0;
    std::size_t Stride = 0;
    bool IsOfIndices = false;
    const char* Filter = nullptr; ///< of the compressed bytes
  };

  GlbFile(
    std::unique_ptr<WritableFile> file, const EdgeIndexHeader& header, const Settings& settings)
    : File(std::move(file))
    , Header(header)
    , HasNormals(settings.HasNormals)
    , Compression(settings.Compression)
    , UnitInMetres(settings.UnitInMetres)
    , Origin(settings.Origin)
    , JsonBytes(FindJsonBytes(header, settings.MostMeshes))
    , BinaryStart(HeaderSize + ChunkHeaderSize + this->JsonBytes + ChunkHeaderSize)
    , Primitives(header.Isovalues.size(), Json::array())
  {
  }

  std::uint64_t GetBinaryBytes() const { return this->File->GetSize() - this->BinaryStart; }
  Status AppendPlain(const Mesh& mesh)
  {
    constexpr std::size_t stride = 3 * sizeof(float);
    ISOSURFACE_RETURN_IF_ERROR(
      this->AppendView({ mesh.Points, mesh.NumberOfPoints, stride, false, nullptr }));
    this->AddPoints(mesh.Points, mesh.NumberOfPoints);
    if (this->HasNormals)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        this->AppendView({ mesh.Normals, mesh.NumberOfPoints, stride, false, nullptr }));
      this->AddAccessor(Float, mesh.NumberOfPoints, "VEC3");
    }
    ISOSURFACE_RETURN_IF_ERROR(this->AppendView(
      { mesh.Corners, 3 * mesh.NumberOfTriangles, sizeof(std::uint32_t), true, nullptr }));
    this->AddAccessor(UnsignedInt, 3 * mesh.NumberOfTriangles, "SCALAR");
    return Status::Ok();
  }

  Status AppendCompressed(const Mesh& mesh)
  {
    const CompressibleMesh ordered = this->Compression->Order(mesh);
    const std::size_t points = ordered.Points.size() / 3;
    ISOSURFACE_RETURN_IF_ERROR(
      this->AppendView({ ordered.Points.data(), points, 3 * sizeof(float), false, nullptr }));
    this->AddPoints(ordered.Points.data(), points);
    if (this->HasNormals)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        this->AppendView({ ordered.OctahedralNormals.data(), points, 4, false, "OCTAHEDRAL" }));
      this->AddAccessor(Byte, points, "VEC3", true);
    }
    ISOSURFACE_RETURN_IF_ERROR(this->AppendView(
      { ordered.Corners.data(), ordered.Corners.size(), sizeof(std::uint32_t), true, nullptr }));
    this->AddAccessor(UnsignedInt, ordered.Corners.size(), "SCALAR");
    return Status::Ok();
  }

  /// Writes an array, and adds it to the JSON as a buffer view.
  Status AppendView(const View& view)
  {
    const std::size_t bytes = view.Count * view.Stride;
    const std::uint64_t offset = this->GetBinaryBytes();
    Json json = { { "buffer", this->Compression ? 1 : 0 },
      { "byteOffset", this->Compression ? this->PlainBytes : offset }, { "byteLength", bytes },
      { "target", view.IsOfIndices ? ElementArrayBuffer : ArrayBuffer } };
    if (!view.IsOfIndices)
    {
      json["byteStride"] = view.Stride;
    }
    if (this->Compression)
    {
      const std::vector<std::uint8_t> code = view.IsOfIndices
        ? this->Compression->EncodeTriangles(
            static_cast<const std::uint32_t*>(view.Bytes), view.Count)
        : this->Compression->EncodeVertices(view.Bytes, view.Count, view.Stride);
      ISOSURFACE_RETURN_IF_ERROR(this->AppendBytes(code.data(), code.size()));
      Json extension = { { "buffer", 0 }, { "byteOffset", offset }, { "byteLength", code.size() },
        { "byteStride", view.Stride }, { "count", view.Count },
        { "mode", view.IsOfIndices ? "TRIANGLES" : "ATTRIBUTES" } };
      if (view.Filter)
      {
        extension["filter"] = view.Filter;
      }
      json["extensions"][CompressionName] = extension;
    }
    else
    {
      ISOSURFACE_RETURN_IF_ERROR(this->AppendBytes(view.Bytes, bytes));
    }
    this->PlainBytes += bytes;
    this->Views.push_back(std::move(json));
    return Status::Ok();
  }

  Status AppendBytes(const void* bytes, std::size_t size)
  {
    constexpr std::uint8_t padding[4] = {};
    ISOSURFACE_RETURN_IF_ERROR(this->File->Append(bytes, size));
    ISOSURFACE_RETURN_IF_ERROR(this->File->Append(padding, (4 - size % 4) % 4));
    return this->File->GetSize() <= std::numeric_limits<std::uint32_t>::max()
      ? Status::Ok()
      : Status(StatusCode::Unsupported,
          this->File->GetPath() +
            ": larger than the 4 GiB that a .glb file can have; --triangles makes it smaller");
  }

  void AddAccessor(
    int componentType, std::size_t count, const char* type, bool isNormalized = false)
  {
    Json accessor = { { "bufferView", this->Views.size() - 1 }, { "componentType", componentType },
      { "count", count }, { "type", type } };
    if (isNormalized)
    {
      accessor["normalized"] = true;
    }
    this->Accessors.push_back(std::move(accessor));
  }

  /// Adds the accessor of points, with their bounds.
  void AddPoints(const float* points, std::size_t count)
  {
    this->AddAccessor(Float, count, "VEC3");
    std::vector<float> least(points, points + 3);
    std::vector<float> most = least;
    for (std::size_t value = 3; value < 3 * count; ++value)
    {
      least[value % 3] = std::min(least[value % 3], points[value]);
      most[value % 3] = std::max(most[value % 3], points[value]);
    }
    this->Accessors.back()["min"] = least;
    this->Accessors.back()["max"] = most;
  }

  /// Adds the triangles of the last accessors to the mesh of an isovalue.
  void AddPrimitive(std::size_t isovalue)
  {
    const std::size_t accessors = this->Accessors.size();
    Json attributes = { { "POSITION", accessors - (this->HasNormals ? 3 : 2) } };
    if (this->HasNormals)
    {
      attributes["NORMAL"] = accessors - 2;
    }
    this->Primitives[isovalue].push_back(Json::object({ { "attributes", attributes },
      { "indices", accessors - 1 }, { "material", 0 }, { "mode", Triangles } }));
  }

  std::string MakeJson() const
  {
    Json json = Json::object();
    json["asset"] =
      Json::object({ { "version", "2.0" }, { "generator", "ScalableIsosurface edgeindex" } });
    json["scene"] = 0;
    Json numbers = Json::array();
    // x stays, z becomes y, y becomes -z.
    const double unit = this->UnitInMetres;
    Json nodes = Json::array({ Json::object({ { "name", "isosurfaces, z up" },
      { "matrix",
        { unit, 0, 0, 0, 0, 0, -unit, 0, 0, unit, 0, 0, unit * this->Origin[0],
          unit * this->Origin[2], -unit * this->Origin[1], 1 } } }) });
    Json meshes = Json::array();
    for (std::size_t isovalue = 0; isovalue < this->Primitives.size(); ++isovalue)
    {
      if (!this->Primitives[isovalue].empty())
      {
        std::ostringstream name;
        name << this->Header.Array << " = " << this->Header.Isovalues[isovalue];
        numbers.push_back(nodes.size());
        nodes.push_back(Json::object({ { "mesh", meshes.size() }, { "name", name.str() } }));
        meshes.push_back(Json::object({ { "primitives", this->Primitives[isovalue] } }));
      }
    }
    nodes[0]["children"] = numbers;
    json["scenes"] = Json::array({ Json::object({ { "nodes", { 0 } } }) });
    json["nodes"] = nodes;
    json["meshes"] = meshes;
    // Surfaces are open where the volume ends: both sides are seen.
    json["materials"] = Json::array({ Json::object({ { "doubleSided", true },
      { "pbrMetallicRoughness",
        Json::object({ { "metallicFactor", 0 }, { "roughnessFactor", 0.6 } }) } }) });
    json["accessors"] = this->Accessors;
    json["bufferViews"] = this->Views;
    json["buffers"] = Json::array({ Json::object({ { "byteLength", this->GetBinaryBytes() } }) });
    if (this->Compression)
    {
      Json fallback = Json::object({ { "byteLength", this->PlainBytes } });
      fallback["extensions"][CompressionName]["fallback"] = true;
      json["buffers"].push_back(fallback);
      json["extensionsUsed"] = { CompressionName, "KHR_mesh_quantization" };
      json["extensionsRequired"] = json["extensionsUsed"];
    }
    // Names that are no UTF-8 must not end the file.
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  }

  std::unique_ptr<WritableFile> File;
  const EdgeIndexHeader& Header;
  bool HasNormals;
  const MeshCompression* Compression; ///< null: none
  double UnitInMetres;
  Vector3 Origin; ///< of the points
  std::size_t JsonBytes;
  std::uint64_t BinaryStart;
  std::uint64_t PlainBytes = 0; ///< of the views, if nothing were compressed
  Json Views = Json::array();
  Json Accessors = Json::array();
  std::vector<Json> Primitives; ///< of each isovalue
};

} // namespace

Result<std::unique_ptr<MeshFile>> CreateGlbFile(std::unique_ptr<WritableFile> file,
  const EdgeIndexHeader& header, const MeshFile::Settings& settings)
{
  return GlbFile::Create(std::move(file), header, settings);
}

} // namespace isosurface
