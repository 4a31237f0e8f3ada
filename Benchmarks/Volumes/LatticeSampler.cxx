// SPDX-License-Identifier: BSD-3-Clause
#include "Volumes/LatticeSampler.h"

#include <algorithm>

namespace isosurface
{
namespace
{

/// A number in [-1, 1) for a point of a lattice, by the finalizer of MurmurHash3.
float HashPoint(std::uint32_t rowSeed, std::uint32_t i)
{
  std::uint32_t hash = rowSeed ^ (i * 0x9E3779B9u);
  hash ^= hash >> 16;
  hash *= 0x85EBCA6Bu;
  hash ^= hash >> 13;
  hash *= 0xC2B2AE35u;
  hash ^= hash >> 16;
  return static_cast<float>(static_cast<std::int32_t>(hash)) * (1.0F / 2147483648.0F);
}

std::uint32_t HashRow(std::uint64_t seed, std::int64_t j, std::int64_t k)
{
  std::uint64_t hash = seed + static_cast<std::uint64_t>(j) * 0x9E3779B97F4A7C15u +
    static_cast<std::uint64_t>(k) * 0xC2B2AE3D27D4EB4Fu;
  hash ^= hash >> 33;
  hash *= 0xFF51AFD7ED558CCDu;
  hash ^= hash >> 33;
  return static_cast<std::uint32_t>(hash);
}

std::array<float, 4> FindWeights(double t, bool isInterpolating)
{
  const double u = 1 - t;
  std::array<double, 4> weights{};
  if (isInterpolating) // Catmull-Rom
  {
    weights = { -0.5 * t * u * u, 1 + t * t * (1.5 * t - 2.5), 1 + u * u * (1.5 * u - 2.5),
      -0.5 * u * t * t };
  }
  else // uniform cubic B-spline
  {
    weights = { u * u * u / 6, (4 - 6 * t * t + 3 * t * t * t) / 6,
      (4 - 6 * u * u + 3 * u * u * u) / 6, t * t * t / 6 };
  }
  return { static_cast<float>(weights[0]), static_cast<float>(weights[1]),
    static_cast<float>(weights[2]), static_cast<float>(weights[3]) };
}

/// out = sum of weights[n] * rows[n].
void Blend(const std::array<const float*, 4>& rows, const std::array<float, 4>& weights,
  std::size_t count, float* out)
{
  for (std::size_t i = 0; i < count; ++i)
  {
    out[i] = weights[0] * rows[0][i] + weights[1] * rows[1][i] + weights[2] * rows[2][i] +
      weights[3] * rows[3][i];
  }
}

std::int64_t Clamp(std::int64_t point, std::int64_t size)
{
  return std::clamp<std::int64_t>(point, 0, size - 1);
}

} // namespace

LatticeSampler::LatticeSampler(const Lattice& lattice, const Index3& dimensions)
  : Points(lattice)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    this->Axes[axis] = MakeTaps(lattice.Size[axis], dimensions[axis], lattice.IsInterpolating);
  }
  this->Width = static_cast<std::size_t>(dimensions[0]);
  this->Hashed.resize(4 * static_cast<std::size_t>(lattice.Size[0]));
  this->Blended.resize(static_cast<std::size_t>(lattice.Size[0]) + 8);
  this->Rows.resize(static_cast<std::size_t>(lattice.Size[1]) * this->Width);
}

void LatticeSampler::SetSlice(std::int64_t k)
{
  const Taps& z = this->Axes[2];
  const auto slice = static_cast<std::size_t>(k);
  for (std::int64_t j = 0; j < this->Points.Size[1]; ++j)
  {
    std::array<const float*, 4> rows{};
    for (std::int64_t tap = 0; tap < 4; ++tap)
    {
      rows[static_cast<std::size_t>(tap)] = this->GetLatticeRow(
        j, Clamp(z.First[slice] + tap, this->Points.Size[2]), static_cast<std::size_t>(tap));
    }
    this->BlendRow(rows, z.Weights[slice]);
    this->StretchRow(&this->Rows[static_cast<std::size_t>(j) * this->Width]);
  }
}

void LatticeSampler::GetRow(std::int64_t j, float* out) const
{
  const Taps& y = this->Axes[1];
  const auto row = static_cast<std::size_t>(j);
  std::array<const float*, 4> rows{};
  for (std::int64_t tap = 0; tap < 4; ++tap)
  {
    const std::int64_t point = Clamp(y.First[row] + tap, this->Points.Size[1]);
    rows[static_cast<std::size_t>(tap)] =
      &this->Rows[static_cast<std::size_t>(point) * this->Width];
  }
  Blend(rows, y.Weights[row], this->Width, out);
}

const float* LatticeSampler::GetLatticeRow(std::int64_t j, std::int64_t k, std::size_t tap)
{
  const auto size = static_cast<std::size_t>(this->Points.Size[0]);
  if (!this->Points.Values.empty())
  {
    return &this->Points.Values[static_cast<std::size_t>(k * this->Points.Size[1] + j) * size];
  }
  const std::uint32_t seed = HashRow(this->Points.Seed, j, k);
  float* row = &this->Hashed[tap * size];
  for (std::size_t i = 0; i < size; ++i)
  {
    row[i] = HashPoint(seed, static_cast<std::uint32_t>(i));
  }
  return row;
}

/// Interpolates the points of a row along z. Repeats the ends for the taps beyond them.
void LatticeSampler::BlendRow(const std::array<const float*, 4>& rows, std::array<float, 4> weights)
{
  const auto size = static_cast<std::size_t>(this->Points.Size[0]);
  for (float& weight : weights)
  {
    weight *= this->Points.Amplitude;
  }
  Blend(rows, weights, size, this->Blended.data() + 1);
  this->Blended[0] = this->Blended[1];
  std::fill_n(
    this->Blended.begin() + static_cast<std::ptrdiff_t>(size) + 1, 7, this->Blended[size]);
}

void LatticeSampler::StretchRow(float* out) const
{
  const Taps& x = this->Axes[0];
  for (std::size_t i = 0; i < this->Width; ++i)
  {
    const float* points = this->Blended.data() + 1 + x.First[i];
    const std::array<float, 4>& weights = x.Weights[i];
    out[i] = weights[0] * points[0] + weights[1] * points[1] + weights[2] * points[2] +
      weights[3] * points[3];
  }
}

LatticeSampler::Taps LatticeSampler::MakeTaps(
  std::int64_t points, std::int64_t vertices, bool isInterpolating)
{
  Taps taps;
  for (std::int64_t vertex = 0; vertex < vertices; ++vertex)
  {
    // Computed in integers, so that it is exact at the samples of the scan.
    const std::int64_t product = vertex * (points - 1);
    const std::int64_t point =
      std::min(product / (vertices - 1), std::max<std::int64_t>(0, points - 2));
    const double t =
      static_cast<double>(product - point * (vertices - 1)) / static_cast<double>(vertices - 1);
    taps.First.push_back(static_cast<std::int32_t>(point - 1));
    taps.Weights.push_back(FindWeights(t, isInterpolating));
  }
  return taps;
}

} // namespace isosurface
