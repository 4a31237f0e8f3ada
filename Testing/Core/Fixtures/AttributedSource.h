// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AttributedSource_h
#define isosurface_AttributedSource_h

#include "Fixtures/CodedVolumes.h"

#include <cmath>
#include <limits>
#include <vector>

namespace isosurface
{

/// Blocks with three more arrays: labels of vertices (int16), three floats each, and a double.
class AttributedSource : public TestBlockSource<std::uint8_t>
{
public:
  static constexpr int VectorSize = 3;

  /// odd: with NaN, infinity and great numbers among the floats.
  AttributedSource(const SampleVolume<std::uint8_t>& volume, int blockSize, bool odd)
    : TestBlockSource<std::uint8_t>(volume, blockSize)
    , Dimensions(volume.GetDimensions())
  {
    const auto vertices = static_cast<std::size_t>(volume.Geometry.GetNumberOfVertices());
    this->Labels.resize(vertices);
    this->Vectors.resize(VectorSize * vertices);
    this->Doubles.resize(vertices);
    for (std::size_t n = 0; n < vertices; ++n)
    {
      this->Labels[n] = static_cast<std::int16_t>(n * 7 % 2000 / 10 - 50);
      this->Doubles[n] = std::sin(0.01 * static_cast<double>(n));
      for (std::size_t c = 0; c < std::size_t{ VectorSize }; ++c)
      {
        this->Vectors[VectorSize * n + c] = static_cast<float>(n % 50 * (c + 1)) * 0.37F - 3;
      }
    }
    if (odd)
    {
      for (std::size_t n = 0; n < this->Vectors.size(); n += 37)
      {
        this->Vectors[n] = n % 4 == 0 ? std::numeric_limits<float>::quiet_NaN()
          : n % 4 == 1                ? std::numeric_limits<float>::infinity()
                                      : 3e38F;
      }
    }
  }

  Result<BlockSamples> Acquire(std::size_t block) override
  {
    Result<BlockSamples> samples = TestBlockSource<std::uint8_t>::Acquire(block);
    const VertexBox& box = samples->Scalars.Box;
    samples->Attributes.resize(3);
    samples->Attributes[0].Components = { this->MakeView(
      box, ValueType::Int16, this->Labels.data(), 1) };
    for (int c = 0; c < VectorSize; ++c)
    {
      samples->Attributes[1].Components.push_back(
        this->MakeView(box, ValueType::Float32, this->Vectors.data() + c, VectorSize));
    }
    samples->Attributes[2].Components = { this->MakeView(
      box, ValueType::Float64, this->Doubles.data(), 1) };
    return samples;
  }

private:
  SampleView MakeView(
    const VertexBox& box, ValueType type, const void* first, std::ptrdiff_t step) const
  {
    SampleView view;
    view.Type = type;
    view.First = first;
    view.Stride = { step, step * static_cast<std::ptrdiff_t>(this->Dimensions[0]),
      step * static_cast<std::ptrdiff_t>(this->Dimensions[0] * this->Dimensions[1]) };
    view.Available.High = this->Dimensions;
    view.Box = box;
    return view;
  }

  Index3 Dimensions;
  std::vector<std::int16_t> Labels;
  std::vector<float> Vectors;
  std::vector<double> Doubles;
};

/// A header for a surface with normals and these arrays.
inline EdgeIndexHeader MakeAttributedHeader(const SampleVolume<std::uint8_t>& volume,
  const std::vector<double>& isovalues, EdgeIndexMode mode, EdgeIndexProfile profile, double error)
{
  EdgeIndexHeader header = MakeHeader(volume, isovalues, mode, profile);
  header.Attributes.resize(4);
  header.Attributes[0].Name = "labels";
  header.Attributes[1].Name = "Normals";
  header.Attributes[1].NumberOfComponents = 3;
  header.Attributes[1].IsNormals = true;
  header.Attributes[2].Name = "vectors";
  header.Attributes[2].NumberOfComponents = AttributedSource::VectorSize;
  header.Attributes[2].MaximumError = error;
  header.Attributes[3].Name = "doubles";
  header.Attributes[3].Type = ValueType::Float64;
  header.Attributes[3].MaximumError = error;
  return header;
}

} // namespace isosurface

#endif
